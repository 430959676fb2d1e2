//! OpenUSD: one PointInstancer for all bodies that move, ordinary prims for the rest.
//!
//! | prim | what |
//! |---|---|
//! | `/World` | everything; its translation is the run's origin |
//! | `/World/Bodies` | the PointInstancer: ids, positions and orientations |
//! | `/World/Bodies/Prototypes` | a mesh for each shape in each colour |
//! | `/World/Static` | a mesh for each body that nobody moves; a PointInstancer for those of which many look alike |
//! | `/World/Looks` | a material for each colour |
//!
//! Time codes are numbers of frames. A small run is one file. A large one is a folder with value clips: `scene.usdc`, the one to open, names files that hold some
//! frames each, of which a program reads those that it shows; `manifest.usdc` says what is in them.
//!
//! What decided this is what programs do with it. A prim for each body takes Blender 500 times as long to open. Blender reads orientations of half precision
//! alone, wants the prototypes under a prim with a type, has no colours of single instances, and gives no material to spheres, boxes and the like,
//! only to meshes. Bodies that are not there are in `invisibleIds`; so the arrays keep their length, and programs can interpolate between frames.

mod clips;
mod crowd;
mod fixed;
mod look;
mod mesh;
mod names;
mod stage;

use crate::prototypes::Prototypes;
use crate::{Detail, Error, Format, Job, Makes};
use clips::Clips;
use crowd::Crowd;
use rockfall_usd::Writer;
use stage::Stage;
use std::path::Path;

/// An export is one file up to this size, bytes.
const ONE_FILE: u64 = 1 << 30;

/// About the size of a clip, bytes.
const CLIP: u64 = 1 << 28;

/// What a program opens where there are clips.
const SCENE: &str = "scene.usdc";

/// The format of OpenUSD.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Usd {
    /// Velocities and angular velocities as well: 24 bytes more for a body and frame.
    pub velocities: bool,
    /// Orientations of single precision as well, `orientationsf`: 16 bytes more for a body and frame.
    pub precise: bool,
    /// Frames in a clip; one file for all where `None`.
    pub clip: Option<u64>,
}

impl Usd {
    /// The same as one file where `frames` frames of `bodies` bodies are at most 1 GiB, and else with clips of some 256 MiB.
    pub fn sized(self, bodies: u64, frames: u64) -> Self {
        let frame = self.bytes_per_body().saturating_mul(bodies).max(1);
        let large = frame.saturating_mul(frames) > ONE_FILE;
        Usd { clip: large.then(|| (CLIP / frame).max(1)), ..self }
    }

    /// Bytes of a body at a frame.
    pub fn bytes_per_body(&self) -> u64 {
        20 + if self.velocities { 24 } else { 0 } + if self.precise { 16 } else { 0 }
    }

    /// Leads the crowd through all frames.
    fn frames(
        &self,
        job: &Job<'_>,
        rows: &[u32],
        crowd: &mut Crowd,
        mut write: impl FnMut(&Crowd) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let motion = if self.velocities { Detail::Motion } else { Detail::Poses };
        let encode = |moment| Ok(self.columns(moment));
        job.stream(rows, motion, encode, |columns| {
            crowd.move_to(columns);
            write(crowd)
        })
    }
}

impl Format for Usd {
    fn name(&self) -> &'static str {
        "usd"
    }

    fn makes(&self) -> Makes {
        match self.clip {
            None => Makes::File { extension: "usdc" },
            Some(_) => Makes::Folder { extensions: &["usdc"] },
        }
    }

    fn write(&self, job: &Job<'_>, to: &Path) -> Result<(), Error> {
        let rows = job.inventory()?.moving();
        let surfaces = Prototypes::of(job.run(), &rows, &job.inventory()?.shown_of)?;
        let mut crowd = Crowd::of(job, self, &rows, mesh::reach(&surfaces));
        let stage = Stage::of(job, &rows, &surfaces, &crowd)?;
        match self.clip {
            None => {
                let mut writer = Writer::create(to)?;
                self.frames(job, &rows, &mut crowd, |crowd| crowd.sample(&mut writer))?;
                writer.finish(&stage.layer(None))?;
            }
            Some(length) => {
                let mut clips = Clips::new(to, job, length, crowd.declared());
                self.frames(job, &rows, &mut crowd, |crowd| clips.write(crowd))?;
                let clips = clips.finish()?;
                Writer::create(&to.join(SCENE))?.finish(&stage.layer(Some(clips)))?;
            }
        }
        Ok(())
    }
}

impl From<rockfall_usd::Error> for Error {
    fn from(error: rockfall_usd::Error) -> Self {
        match error {
            rockfall_usd::Error::Io { path, reason, kind } => {
                Error::Io { action: "write", path, reason, kind }
            }
            other => Error::Limit(other.to_string()),
        }
    }
}
