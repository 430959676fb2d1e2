//! glTF, judged by Khronos' validator and compared with the store by a reader of our own in Python.

use crate::python::python;
use crate::sample::{Counter, FRAMES, Sample};
use rockfall_cache::{BodyTable, FORMAT, Frame, Poses, RunFolder, RunWriter, Summary, VERSION};
use rockfall_export::{Error, Glb, MOST_ANIMATED, Options, Run, export};
use rockfall_math::DVec3;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The variable that names the folder of the npm package `gltf-validator`; the `test` script sets it where there is npm.
const VALIDATOR: &str = "ROCKFALL_GLTF_VALIDATOR";

/// What the validator counts in a file of which it has nothing bad to say.
fn validate(file: &Path) -> Option<String> {
    let Some(module) = std::env::var_os(VALIDATOR) else {
        assert!(
            std::env::var_os("CI").is_none(),
            "no validator of glTF files: install npm, for `./test` fetches it by that"
        );
        println!(
            "SKIPPED: {VALIDATOR} is not set; `./test` installs Khronos' validator where there is npm and sets it"
        );
        return None;
    };
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/validate_gltf.cjs");
    let output = Command::new("node").arg(script).arg(module).arg(file).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}

fn compare(run: PathBuf, file: PathBuf, first: u64) -> Option<String> {
    python("read_glb.py", &[run, file, first.to_string().into()])
}

#[test]
fn stills_are_valid_and_every_instance_is_where_its_body_is() {
    for (away, frames) in [(0.0, FRAMES), (4.0e6, 5)] {
        let sample = Sample::new(away, frames);
        for frame in [0, frames - 1] {
            let name = format!("{frame}.glb");
            sample.export(&Glb::default(), &frame.to_string(), &name).unwrap();
            if let Some(said) = validate(&sample.path(&name)) {
                assert!(said.starts_with("valid: ") && said.contains(" 0 animations"), "{said}");
            }
            if let Some(said) = compare(sample.path("run"), sample.path(&name), frame) {
                assert!(said.starts_with("1 frames of "), "{said}");
            }
        }
    }
}

#[test]
fn animations_are_valid_and_every_node_is_where_its_body_is() {
    for (away, frames, first) in [(0.0, FRAMES, 3), (4.0e6, 5, 0)] {
        let sample = Sample::new(away, frames);
        sample.export(&Glb::default(), &format!("{first}.."), "out.glb").unwrap();
        if let Some(said) = validate(&sample.path("out.glb")) {
            assert!(said.contains(" 1 animations"), "{said}");
        }
        if let Some(said) = compare(sample.path("run"), sample.path("out.glb"), first) {
            assert!(said.starts_with(&format!("{} frames of ", frames - first)), "{said}");
        }
    }
}

#[test]
fn files_in_which_nothing_moves_or_nothing_is_there_are_valid() {
    let sample = Sample::new(0.0, FRAMES);
    // The floor, and one that is poured later.
    for (bodies, frames, draws) in [("1", "", 1), ("1", "5", 1), ("64", "0", 0), ("64", "0..1", 0)] {
        let name = format!("{bodies}-{frames}.glb");
        sample.export(&Glb { bodies: Some(bodies.parse().unwrap()) }, frames, &name).unwrap();
        if let Some(said) = validate(&sample.path(&name)) {
            assert!(said.starts_with(&format!("valid: {draws} draws, 0 animations")), "{said}");
        }
    }
}

#[test]
fn chosen_bodies_alone_are_there() {
    let sample = Sample::new(0.0, FRAMES);
    let glb = Glb { bodies: Some("5000".parse().unwrap()) };
    sample.export(&glb, "", "out.glb").unwrap();
    if let Some(said) = validate(&sample.path("out.glb")) {
        assert!(said.starts_with("valid: 1 draws, 1 animations"), "{said}");
    }
}

#[test]
fn more_bodies_than_an_animation_bears_are_refused_and_fit_in_a_still() {
    let sample = Sample::new(0.0, 2);
    let many = sample.path("many");
    let count = MOST_ANIMATED + 1;
    let scene = format!(
        "[shapes.ball]\nkind = \"sphere\"\nradius = 0.5\n[[generators]]\nkind = \"grid\"\nshape = \"ball\"\ncount = [{count}, 1, 1]\nspacing = [2, 2, 2]\n"
    );
    let scene = rockfall_scene::Scene::parse(&scene, "many.toml", ".").unwrap();
    let rows = scene.body_table().unwrap();
    let table = BodyTable {
        ids: rows.iter().map(|row| row.id).collect(),
        names: vec![String::new(); count],
        shapes: vec![0; count],
        scales: vec![1.0; count],
    };
    let summary = Summary { format: FORMAT.into(), format_version: VERSION, ..Summary::default() };
    let folder = RunFolder::at(&many, false).unwrap();
    let mut writer =
        RunWriter::create(&folder, &scene.to_toml_filled(), &summary, &table, DVec3::ZERO).unwrap();
    for time in [0.0, 1.0] {
        let (positions, orientations) = (vec![0.25; 3 * count], [0.0, 0.0, 0.0, 1.0].repeat(count));
        let poses = Poses { positions, orientations };
        writer.push(Frame { time, poses, ..Frame::default() }).unwrap();
    }
    writer.finish().unwrap();
    let run = Run::open(&many).unwrap();
    let options = |frames: &str| Options {
        frames: frames.parse().unwrap(),
        to: Some(sample.path("out.glb")),
        ..Options::default()
    };
    let refused = export(&run, &Glb::default(), &options("0.."), &Counter::default()).unwrap_err();
    assert!(matches!(refused, Error::Limit(_)), "{refused}");
    assert!(refused.to_string().starts_with("10001 bodies can move"), "{refused}");
    export(&run, &Glb::default(), &options("1"), &Counter::default()).unwrap();
    if let Some(said) = validate(&sample.path("out.glb")) {
        assert!(said.starts_with("valid: 1 draws, 0 animations"), "{said}");
    }
}
