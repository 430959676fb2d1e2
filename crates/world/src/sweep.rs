//! Stage 13, **sweep**: continuous detection.

use crate::Shape;
use crate::bodies::Bodies;
use crate::index::Index;

pub(crate) fn sweep(_bodies: &mut Bodies, _shapes: &[Shape], _trees: &Index) {}
