//! ParaView's own library reads every file, and compares it with the trajectory.

use crate::python::python;
use crate::sample::{FRAMES, Sample};
use rockfall_export::Vtp;

#[test]
fn vtk_reads_every_body_and_every_triangle() {
    for (away, frames) in [(0.0, FRAMES), (4.0e6, 5)] {
        let sample = Sample::new(away, frames);
        for meshes in [false, true] {
            let name = format!("out-{meshes}");
            let done = sample.export(&Vtp { meshes }, "", &name).unwrap();
            assert_eq!(done.frames, frames);
            let said = python("read_with_vtk.py", &[sample.path("run"), sample.path(&name)]);
            let Some(said) = said else { return };
            assert_eq!(said, format!("{frames} frames of 65 bodies are equal"));
        }
    }
}

/// The run's columns are arrays of the points, as the store has them; one whose name is taken has another.
#[test]
fn vtk_reads_the_columns_of_the_run() {
    let sample = Sample::with_motion(0.0);
    sample.export(&Vtp::default(), "", "out").unwrap();
    let Some(said) = python("read_with_vtk.py", &[sample.path("run"), sample.path("out")]) else { return };
    assert_eq!(said, format!("{FRAMES} frames of 65 bodies are equal"));
}
