//! Python's `zarr` reads what Rockfall writes.

use crate::synthetic;
use rockfall_cache::{Poses, TRAJECTORY};
use std::fs;
use std::path::Path;
use std::process::Command;

/// The variable that names a Python with the packages `zarr` and `numpy`; the `test` script sets it.
const PYTHON: &str = "ROCKFALL_PYTHON";

#[test]
fn zarr_for_python_reads_every_value() {
    let Some(python) = std::env::var_os(PYTHON) else {
        println!("SKIPPED: {PYTHON} is not set; `./test` makes a Python with zarr and sets it");
        return;
    };
    // Chunks of many frames, of some, and of one frame with a padded chunk at its end.
    for (bodies, frames) in [(11, 300), (3000, 11), (70_001, 2)] {
        let folder = tempfile::tempdir().unwrap();
        let run = folder.path().join("run");
        let expected = folder.path().join("expected");
        synthetic::write(&run, bodies, frames).unwrap();
        write_expected(&expected, bodies, frames);
        let output = Command::new(&python)
            .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/read_with_zarr.py"))
            .args([run.join(TRAJECTORY), expected])
            .output()
            .unwrap_or_else(|error| panic!("cannot start {}: {error}", python.display()));
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(said.trim(), format!("{frames} frames of {bodies} bodies are equal"));
    }
}

fn write_expected(folder: &Path, bodies: usize, frames: u64) {
    let table = synthetic::table(bodies);
    let (mut positions, mut orientations) = (Vec::new(), Vec::new());
    for frame in 0..frames {
        let (ids, poses) = synthetic::state(bodies, frame);
        let mut packed = Poses::default();
        packed.gather(&table, synthetic::ORIGIN, &ids, &poses).unwrap();
        positions.extend(packed.positions.iter().flat_map(|x| x.to_le_bytes()));
        orientations.extend(packed.orientations.iter().flat_map(|x| x.to_le_bytes()));
    }
    fs::create_dir(folder).unwrap();
    let write = |name: &str, bytes: Vec<u8>| fs::write(folder.join(name), bytes).unwrap();
    write("position.f32", positions);
    write("orientation.f32", orientations);
    write("time.f64", (0..frames).map(synthetic::time).flat_map(f64::to_le_bytes).collect());
    write("id.u64", table.ids.iter().flat_map(|x| x.to_le_bytes()).collect());
    write("shape.u32", table.shapes.iter().flat_map(|x| x.to_le_bytes()).collect());
    write("scale.f32", table.scales.iter().flat_map(|x| x.to_le_bytes()).collect());
    write("names.txt", table.names.join("\n").into_bytes());
}
