//! glTF in its binary form: one file with shapes, materials and poses.
//!
//! One frame becomes a still: a node for each shape and material, with all bodies that have both as instances (`EXT_mesh_gpu_instancing`). Several become an
//! animation: a node for each body, which few programs bear for very many.
//!
//! glTF has y up: a node above all others turns the world's z there. Positions are single precision and count from the run's origin, which that node names.
//! The format: <https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html>.

mod animation;
mod document;
mod still;
mod tracks;

use crate::{Error, Format, Ids, Job, Makes};
use std::path::Path;

/// Bodies that can move in an animation, at most.
pub const MOST_ANIMATED: usize = 10_000;

/// The format of web pages, game engines and everything else that shows a scene.
#[derive(Clone, Debug, Default)]
pub struct Glb {
    /// Which bodies; all where `None`.
    pub bodies: Option<Ids>,
}

impl Format for Glb {
    fn name(&self) -> &'static str {
        "glb"
    }

    fn makes(&self) -> Makes {
        Makes::File { extension: "glb" }
    }

    fn write(&self, job: &Job<'_>, to: &Path) -> Result<(), Error> {
        let mut rows = job.rows(self.bodies.as_ref())?;
        if self.bodies.is_none() {
            let sensors = &job.inventory()?.sensors;
            rows.retain(|&row| !sensors[row as usize]);
        }
        if job.frames().len() == 1 { still::write(job, &rows, to) } else { animation::write(job, &rows, to) }
    }
}
