//! OpenUSD and Blender open exports, and compare every pose with the trajectory.

use crate::python::{blender, python};
use crate::sample::{Counter, FRAMES, HARE, Sample};
use rockfall_export::{Frames, Glb, Options, Usd, export};
use std::ffi::OsString;

/// The run `away` metres from the world's origin, its export, the numbers of the frames and what the script has to know.
fn exported(away: f64, usd: Usd, every: u64) -> (Sample, [OsString; 3]) {
    exported_of(Sample::new(away, FRAMES), usd, every)
}

fn exported_of(sample: Sample, usd: Usd, every: u64) -> (Sample, [OsString; 3]) {
    let frames = Frames { every, ..Frames::default() };
    let name = if usd.clip.is_some() { "out" } else { "out.usdc" };
    let options = Options { frames, to: Some(sample.path(name)), threads: Some(2), ..Options::default() };
    export(&sample.run(), &usd, &options, &Counter::default()).unwrap();
    let numbers: Vec<String> = frames.among(FRAMES).unwrap().iter().map(u64::to_string).collect();
    let file = if usd.clip.is_some() { sample.path("out/scene.usdc") } else { sample.path("out.usdc") };
    let arguments = [sample.path("run").into(), file.into(), numbers.join(",").into()];
    (sample, arguments)
}

/// One file and clips, all frames and some, near the world's origin and far from it.
const CASES: [(f64, Option<u64>, u64); 4] =
    [(0.0, None, 1), (4.0e6, None, 3), (0.0, Some(8), 1), (4.0e6, Some(3), 2)];

#[test]
fn openusd_evaluates_every_pose() {
    for (away, clip, every) in CASES {
        // All that there can be, near the origin.
        let all: &[bool] = if away == 0.0 { &[false, true] } else { &[false] };
        for &all in all {
            let usd = Usd { velocities: all, precise: all, clip };
            let (_sample, arguments) = exported(away, usd, every);
            let mut arguments = arguments.to_vec();
            arguments.extend(["velocities", "precise"].into_iter().filter(|_| all).map(OsString::from));
            let Some(said) = python("read_with_usd.py", &arguments) else { return };
            let frames = FRAMES.div_ceil(every);
            assert_eq!(said, format!("{frames} frames of 65 bodies are equal"), "{usd:?}");
        }
    }
}

/// Promise: colours and visual meshes of the scene are in USD and glTF.
#[test]
fn bodies_look_as_the_scene_says() {
    let sample = Sample::with_looks();
    let last = (FRAMES - 1).to_string();
    sample.export(&Usd::default(), "", "out.usdc").unwrap();
    sample.export(&Glb::default(), &last, "out.glb").unwrap();
    let arguments = [sample.path("out.usdc"), sample.path("out.glb"), HARE.into()];
    let Some(said) = python("read_looks.py", &arguments) else { return };
    assert_eq!(said, "looks are those of the scene");
}

#[test]
fn blender_shows_every_body_where_it_is() {
    for (away, clip, every) in CASES {
        let (_sample, arguments) = exported(away, Usd { clip, ..Usd::default() }, every);
        let Some(said) = blender("read_with_blender.py", &arguments) else { return };
        let frames = FRAMES.div_ceil(every);
        assert!(said.ends_with(&format!("{frames} frames of 65 bodies are equal")), "{said}");
    }
}

/// Promise: static bodies of which many look alike are instances, each where it is; the others are meshes as ever.
#[test]
fn many_static_bodies_are_instances() {
    for away in [0.0, 4.0e6] {
        let (_sample, arguments) = exported_of(Sample::with_crowd(away, FRAMES), Usd::default(), 10);
        let said = [python("read_with_usd.py", &arguments), blender("read_with_blender.py", &arguments)];
        for said in said.into_iter().flatten() {
            assert!(said.ends_with("3 frames of 145 bodies are equal"), "{said}");
        }
    }
}

#[test]
fn large_runs_have_clips_of_a_quarter_of_a_gibibyte() {
    let usd = Usd::default();
    assert_eq!(usd.sized(100_000, 240).clip, None);
    assert_eq!(usd.sized(1_000_000, 240).clip, Some(13));
    assert_eq!(usd.sized(100_000_000, 2).clip, Some(1));
    assert_eq!(usd.sized(0, 1_000_000).clip, None);
    let all = Usd { velocities: true, precise: true, ..usd };
    assert_eq!(all.sized(100_000, 240).clip, Some(44));
}
