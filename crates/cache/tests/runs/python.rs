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
    // Chunks of many frames, of some, and of sixteen with a padded chunk at the end; lossless, and within a bound.
    for (bodies, frames, bounded) in
        [(11, 300, false), (3000, 35, false), (70_001, 2, false), (11, 300, true), (20_000, 18, true)]
    {
        let folder = tempfile::tempdir().unwrap();
        let run = folder.path().join("run");
        let expected = folder.path().join("expected");
        if bounded {
            synthetic::write_bounded(&run, bodies, frames).unwrap();
        } else {
            synthetic::write(&run, bodies, frames).unwrap();
        }
        write_expected(&expected, bodies, frames, bounded);
        let output = Command::new(&python)
            .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/read_with_zarr.py"))
            .args([run.join(TRAJECTORY), expected])
            .output()
            .unwrap_or_else(|error| panic!("cannot start {}: {error}", python.display()));
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
        let how = if bounded { "within the bound" } else { "equal" };
        assert_eq!(said.trim(), format!("{frames} frames of {bodies} bodies are {how}"));
    }
}

/// Contacts, events and columns as `docs/run.md` says to read them.
#[test]
fn zarr_for_python_reads_contacts_events_and_columns() {
    let Some(python) = std::env::var_os(PYTHON) else {
        println!("SKIPPED: {PYTHON} is not set; `./test` makes a Python with zarr and sets it");
        return;
    };
    for (bodies, frames) in [(7, 300), (20_000, 19)] {
        let folder = tempfile::tempdir().unwrap();
        let run = folder.path().join("run");
        synthetic::write_everything(&run, bodies, frames).unwrap();
        let output = Command::new(&python)
            .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/read_extras_with_zarr.py"))
            .arg(run.join(TRAJECTORY))
            .output()
            .unwrap_or_else(|error| panic!("cannot start {}: {error}", python.display()));
        let said = String::from_utf8_lossy(&output.stdout);
        assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(said.trim(), format!("{frames} frames of {bodies} bodies are equal"));
    }
}

fn write_expected(folder: &Path, bodies: usize, frames: u64, bounded: bool) {
    let table = synthetic::table(bodies);
    let (mut positions, mut orientations, mut speeds) = (Vec::new(), Vec::new(), Vec::new());
    for frame in 0..frames {
        let (ids, poses) = if bounded {
            let (ids, poses, velocities) = synthetic::rolling(bodies, frame);
            speeds.extend(velocities.linear.iter().flat_map(|x| x.to_le_bytes()));
            (ids, poses)
        } else {
            synthetic::state(bodies, frame)
        };
        let mut packed = Poses::default();
        packed.gather(&table, synthetic::ORIGIN, &ids, &poses).unwrap();
        positions.extend(packed.positions.iter().flat_map(|x| x.to_le_bytes()));
        orientations.extend(packed.orientations.iter().flat_map(|x| x.to_le_bytes()));
    }
    fs::create_dir(folder).unwrap();
    let write = |name: &str, bytes: Vec<u8>| fs::write(folder.join(name), bytes).unwrap();
    write("position.f32", positions);
    write("orientation.f32", orientations);
    if bounded {
        write("velocity.f32", speeds);
    }
    write("time.f64", (0..frames).map(synthetic::time).flat_map(f64::to_le_bytes).collect());
    write("id.u64", table.ids.iter().flat_map(|x| x.to_le_bytes()).collect());
    write("shape.u32", table.shapes.iter().flat_map(|x| x.to_le_bytes()).collect());
    write("scale.f32", table.scales.iter().flat_map(|x| x.to_le_bytes()).collect());
    write("names.txt", table.names.join("\n").into_bytes());
}
