//! Runs whose poses are off, but never by more than was said.

use crate::synthetic::{self, ORIGIN, bounded, rolling, start_with};
use rockfall_cache::{Contents, Error, Frame, Poses, Precision, RunReader, TRAJECTORY};
use std::fs;
use std::path::Path;

/// The largest distance, metres, and angle, radians, between poses; both are there or neither.
fn off(a: &Poses, b: &Poses) -> (f64, f64) {
    let far = |a: &[f32], b: &[f32]| {
        a.iter().zip(b).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2)).sum::<f64>().sqrt()
    };
    let (mut way, mut turn) = (0.0_f64, 0.0_f64);
    assert_eq!(a.positions.len(), b.positions.len());
    for (a, b) in a.positions.as_chunks::<3>().0.iter().zip(b.positions.as_chunks::<3>().0) {
        assert_eq!(a.map(f32::is_nan), b.map(f32::is_nan));
        way = way.max(far(a, b));
    }
    for (a, b) in a.orientations.as_chunks::<4>().0.iter().zip(b.orientations.as_chunks::<4>().0) {
        assert_eq!(a.map(f32::is_nan), b.map(f32::is_nan));
        turn = turn.max(4.0 * (0.5 * far(a, b)).asin());
    }
    (way, turn)
}

fn exact(bodies: usize, frame: u64) -> Poses {
    let (ids, poses, _) = rolling(bodies, frame);
    let mut exact = Poses::default();
    exact.gather(&synthetic::table(bodies), ORIGIN, &ids, &poses).unwrap();
    exact
}

/// Promise: every pose of every frame is within the bound, however many frames there were before; each body's history says the
/// same; velocities are as they were.
#[test]
fn every_pose_is_within_the_bound() {
    let folder = tempfile::tempdir().unwrap();
    for (bodies, frames) in [(7, 600), (20_000, 33)] {
        let path = folder.path().join(format!("{bodies}"));
        synthetic::write_bounded(&path, bodies, frames).unwrap();
        let run = RunReader::open(&path).unwrap();
        let precision = run.precision().unwrap();
        assert_eq!(precision, bounded().precision);
        let mut worst = (0.0_f64, 0.0_f64);
        for frame in 0..frames {
            let (way, turn) = off(&run.poses(frame).unwrap(), &exact(bodies, frame));
            worst = (worst.0.max(way), worst.1.max(turn));
            let (_, _, velocities) = rolling(bodies, frame);
            let read = run.velocities(frame).unwrap().unwrap();
            let bits = |values: &[f32]| values.iter().map(|x| x.to_bits()).collect::<Vec<u32>>();
            assert!(
                bits(&read.linear) == bits(&velocities.linear)
                    && bits(&read.angular) == bits(&velocities.angular)
            );
        }
        assert!(worst.0 <= 1e-4 && worst.1 <= 0.1_f64.to_radians(), "{worst:?}");
        assert!(
            worst.0 > 0.4e-4 && worst.1 > 0.4 * 0.1_f64.to_radians(),
            "{worst:?}: the bound is not made use of"
        );
        for row in [0, bodies / 2 + 1, bodies - 1] {
            let history = run.history(row).unwrap();
            assert_eq!(history.positions.len() as u64, 3 * frames);
            for frame in [0, 1, frames / 2, frames - 1] {
                let poses = run.poses(frame).unwrap();
                let one = Poses {
                    positions: poses.positions[3 * row..3 * row + 3].to_vec(),
                    orientations: poses.orientations[4 * row..4 * row + 4].to_vec(),
                };
                let at = frame as usize;
                let there = Poses {
                    positions: history.positions[3 * at..3 * at + 3].to_vec(),
                    orientations: history.orientations[4 * at..4 * at + 4].to_vec(),
                };
                assert_eq!(off(&one, &there), (0.0, 0.0));
            }
        }
        assert!(matches!(run.history(bodies), Err(Error::NoBody(_))));
    }
}

/// Promise: velocities that are gone are told of, not taken for such as never were.
#[test]
fn velocities_that_were_lost_are_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    synthetic::write_bounded(&path, 7, 3).unwrap();
    fs::remove_dir_all(path.join(TRAJECTORY).join("velocity")).unwrap();
    let run = RunReader::open(&path).unwrap();
    assert!(matches!(run.velocities(1), Err(Error::Damaged { .. })));
}

/// Promise: what can't be stored is absent, and counted; the rest of the frame is whole.
#[test]
fn a_body_too_far_away_is_told_of_and_spoils_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = start_with(&folder.path().join("run"), 3, bounded()).unwrap();
    for index in 0..3 {
        let mut poses = exact(3, 1);
        if index > 0 {
            poses.positions[4] = -2.0e5;
        }
        let (_, _, velocities) = rolling(3, 1);
        writer.push(Frame { time: index as f64, poses, velocities, ..Frame::default() }).unwrap();
    }
    assert_eq!(writer.finish().unwrap().too_far, 2);
    let run = RunReader::open(&folder.path().join("run")).unwrap();
    let poses = run.poses(2).unwrap();
    assert!(poses.positions[3..6].iter().chain(&poses.orientations[4..8]).all(|x| x.is_nan()));
    assert!(poses.positions[..3].iter().chain(&poses.positions[6..]).all(|x| x.is_finite()));
    assert!(run.poses(0).unwrap().positions.iter().all(|x| x.is_finite()));
}

#[test]
fn bounds_that_nobody_can_keep_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let precision = Precision { position: Some(1e-9), rotation: None };
    let contents = Contents { precision, ..Contents::from(ORIGIN) };
    let error = start_with(&folder.path().join("run"), 3, contents).unwrap_err();
    assert!(matches!(error, Error::Precision { .. }), "{error}");
}

fn bytes(folder: &Path) -> u64 {
    let sizes = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().metadata().unwrap().len());
    sizes.sum()
}

/// Promise: bodies that rest cost next to nothing, with a bound and without.
#[test]
fn resting_bodies_are_nearly_free() {
    let folder = tempfile::tempdir().unwrap();
    for (kind, contents) in
        [("lossless", Contents::from(ORIGIN)), ("bounded", Contents { velocities: false, ..bounded() })]
    {
        let path = folder.path().join(kind);
        let mut writer = start_with(&path, 5000, contents).unwrap();
        for index in 0..64 {
            let poses = exact(5000, 9);
            writer.push(Frame { time: index as f64, poses, ..Frame::default() }).unwrap();
        }
        writer.finish().unwrap();
        let sum = ["position", "orientation"].map(|name| bytes(&path.join(TRAJECTORY).join(name)));
        let each = sum.iter().sum::<u64>() as f64 / (64.0 * 5000.0);
        assert!(each < 1.5, "{kind}: {each} bytes");
    }
}

/// Promise: chunks of bodies that rest, which are not compressed again, are those of every frame: before a body moves, when it does, and when all rest once more.
#[test]
fn what_rests_and_moves_and_rests_again_reads_back() {
    let folder = tempfile::tempdir().unwrap();
    // Two columns of chunks of sixteen frames: in the second one nobody moves.
    let bodies = 16_384;
    let pose_of = |frame: u64| if (35..50).contains(&frame) { frame } else { 3 + frame / 70 };
    let poses = |frame: u64| {
        let (mut here, there) = (exact(bodies, 3), exact(bodies, pose_of(frame)));
        here.positions[..30].copy_from_slice(&there.positions[..30]);
        here.orientations[..40].copy_from_slice(&there.orientations[..40]);
        here
    };
    for (kind, contents) in
        [("lossless", Contents::from(ORIGIN)), ("bounded", Contents { velocities: false, ..bounded() })]
    {
        let path = folder.path().join(kind);
        let mut writer = start_with(&path, bodies, contents).unwrap();
        for index in 0..120 {
            writer.push(Frame { time: index as f64, poses: poses(index), ..Frame::default() }).unwrap();
        }
        writer.finish().unwrap();
        let run = RunReader::open(&path).unwrap();
        let off = |(a, b): (&f32, &f32)| if (a - b).is_nan() { f32::INFINITY } else { (a - b).abs() };
        let worst = |a: &[f32], b: &[f32]| a.iter().zip(b).map(off).fold(0.0, f32::max);
        let bound = if kind == "lossless" { 0.0 } else { 1e-3 };
        for frame in 0..120 {
            let (found, expected) = (run.poses(frame).unwrap(), poses(frame));
            assert!(worst(&found.positions, &expected.positions) <= bound, "{kind}, frame {frame}");
            assert!(worst(&found.orientations, &expected.orientations) <= bound, "{kind}, frame {frame}");
        }
        let chunk = |row: u32, column: u32| {
            fs::read(path.join(TRAJECTORY).join(format!("position/c.{row}.{column}.0"))).unwrap()
        };
        assert_eq!(chunk(0, 1), chunk(6, 1));
        assert!(chunk(0, 0) == chunk(1, 0) && chunk(1, 0) != chunk(2, 0) && chunk(5, 0) == chunk(6, 0));
    }
}
