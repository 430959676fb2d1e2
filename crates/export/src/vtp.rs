//! ParaView: a folder of VTK's XML files, all numbers raw.
//!
//! | file | what |
//! |---|---|
//! | `frame-NUMBER.vtp` | the bodies that can move: a point for each, or their triangles |
//! | `bodies.pvd` | these files and their times: the one to open |
//! | `static.vtp` | triangles of the bodies that nobody moves |
//! | `shape-NUMBER.vtp` | triangles of each shape, for glyphs; not where the triangles of all bodies are there anyway |
//!
//! The format: <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

mod bodies;
mod file;
mod meshes;

use crate::prototypes::Prototypes;
use crate::{Detail, Error, Format, Job, Makes, Moment};
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// The format of ParaView.
#[derive(Clone, Copy, Debug, Default)]
pub struct Vtp {
    /// The triangles of all bodies instead of a point for each.
    pub meshes: bool,
}

/// The digits of a frame's number in the name of a file; more where it takes more.
const DIGITS: usize = 6;

impl Format for Vtp {
    fn name(&self) -> &'static str {
        "vtp"
    }

    fn makes(&self) -> Makes {
        Makes::Folder { extensions: &["vtp", "pvd"] }
    }

    fn write(&self, job: &Job<'_>, to: &Path) -> Result<(), Error> {
        let (run, inventory) = (job.run(), job.inventory()?);
        let (moving, fixed) = (inventory.moving(), inventory.fixed());
        if !fixed.is_empty() {
            let prototypes = Prototypes::of(run, &fixed, &inventory.shape_of)?.alike();
            let mut still = job.at(job.frames()[0], &fixed)?;
            // Bodies that never move have no time.
            still.time = f64::NAN;
            meshes::of(run, inventory, &prototypes, &still).write(&to.join("static.vtp"))?;
        }
        let mut prototypes = Prototypes::of(run, &moving, &inventory.shape_of)?;
        if self.meshes {
            prototypes = prototypes.alike();
        } else {
            for (shape, surface) in prototypes.iter() {
                meshes::prototype(surface).write(&to.join(format!("shape-{shape}.vtp")))?;
            }
        }
        let one = |moment: Moment| {
            let name = format!("frame-{:0DIGITS$}.vtp", moment.frame);
            let path = to.join(&name);
            match self.meshes {
                true => meshes::of(run, inventory, &prototypes, &moment).write(&path)?,
                false => bodies::of(run, inventory, &moment).write(&path)?,
            }
            Ok((moment.time, name))
        };
        let mut list = String::from(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n  <Collection>\n",
        );
        let detail = if self.meshes { Detail::Motion } else { Detail::All };
        job.stream(&moving, detail, one, |(time, name)| {
            // Writing to a string cannot fail.
            let _ = writeln!(list, "    <DataSet timestep=\"{time}\" part=\"0\" file=\"{name}\"/>");
            Ok(())
        })?;
        list.push_str("  </Collection>\n</VTKFile>\n");
        let path = to.join("bodies.pvd");
        fs::write(&path, list).map_err(|error| Error::io("write", &path, &error))
    }
}
