//! Stages of OpenUSD with `UsdPhysics`: text (`.usda`), binary (`.usdc`), and packages (`.usdz`).
//!
//! The crate `openusd` reads and composes them: sublayers, references, payloads, inherits, variants and instances are followed. What is taken of the composed
//! prims is what UsdPhysics says of them, at the default time; where an attribute has samples alone, at the first of them.

mod body;
mod collider;
mod crate_file;
mod filter;
mod guard;
mod instancer;
mod known;
mod material;
mod names;
mod text;
mod units;
mod values;
mod walk;
mod xform;

use crate::affine::Affine;
use crate::build::Builder;
use crate::content::Content;
use openusd::usd::Stage;
use std::path::Path;
use units::Units;
use values::said;
use walk::Walk;

/// kg/m³ of what has neither mass nor density (UsdPhysics takes that of water).
const DENSITY: f32 = 1000.0;

/// Reads a stage; `place` is where it lies in the world, in metres and with z up.
pub(crate) fn read(path: &Path, place: &Affine) -> Result<Content, String> {
    let name = path.to_str().ok_or("its path is not Unicode, which the reader of OpenUSD needs")?;
    let (resolver, refused) = guard::Resolver::new();
    let opened = Stage::builder().resolver(resolver).open(name);
    // A reason of ours says more than what the library makes of it.
    let stage = opened.map_err(|error| refused.first().unwrap_or_else(|| said(error)))?;
    let mut builder = Builder::default();
    let units = Units::read(&stage, &mut builder)?;
    let mut walk = Walk::new(&stage, units, builder);
    let bodies = walk.whole(place)?;
    let mut content = walk.finish(bodies)?;
    let errors = stage.composition_errors();
    let missing = errors.iter().map(|error| crate::content::Note {
        what: format!("a part of the stage is missing: {}", said(error)),
        first: String::new(),
        count: 1,
    });
    content.notes.extend(missing);
    content.density = Some(DENSITY);
    Ok(content)
}
