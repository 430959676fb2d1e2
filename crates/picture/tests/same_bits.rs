//! A picture depends on the stage alone: not on threads, and not on how far from the origin it is.

mod common;

use common::{shapes, turned};
use rockfall_math::{DVec3, Pose};
use rockfall_picture::{Actor, Air, Camera, Quality, Shot, Stage, render, stone, tone};

fn stage(origin: DVec3) -> Stage {
    let shapes = shapes();
    let last = shapes.len() as u32 - 1;
    let actor = |k: u32| {
        let place = DVec3::new(f64::from(k % 4) * 2.25, f64::from(k / 4) * 2.25, 1.25);
        let ground = k == last;
        let position = if ground { origin } else { origin + place };
        let rotation = if ground { Pose::default().rotation } else { turned(k) };
        let color = stone(k.into()).to_array();
        Actor { shape: k, pose: Pose { position, rotation }, color, moves: !ground }
    };
    Stage { actors: (0..=last).map(actor).collect(), shapes }
}

fn camera(origin: DVec3) -> Camera {
    let at = |x, y, z| origin + DVec3::new(x, y, z);
    Camera { eye: at(9.0, -9.0, 7.5), target: at(3.5, 2.5, 0.75), up: DVec3::Z, fov: 40.0, lens: None }
}

const SHOT: Shot = Shot { width: 160, height: 90, quality: Quality::Standard, air: Air { reach: 60.0 } };

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let picture = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| render(&stage(DVec3::ZERO), &camera(DVec3::ZERO), &SHOT))
    };
    let one = picture(1);
    assert!(one.depth.iter().any(|depth| depth.is_finite()));
    for threads in [2, 5] {
        assert!(picture(threads) == one, "{threads} threads");
    }
}

#[test]
fn a_thousand_kilometres_from_the_origin_the_picture_is_the_same() {
    let picture = |origin| tone(&render(&stage(origin), &camera(origin), &SHOT));
    // Powers of two, so that the differences of places are the same numbers.
    let far = DVec3::new(f64::from(1 << 20), -f64::from(1 << 21), f64::from(1 << 19));
    assert!(picture(DVec3::ZERO) == picture(far));
}

#[test]
fn a_stage_with_nothing_on_it_and_one_with_nonsense_are_sky() {
    let empty = render(&Stage::default(), &camera(DVec3::ZERO), &SHOT);
    assert!(empty.depth.iter().all(|depth| depth.is_infinite()));
    let mut broken = stage(DVec3::ZERO);
    for (k, actor) in broken.actors.iter_mut().enumerate() {
        match k % 3 {
            0 => actor.pose.position.x = f64::NAN,
            1 => actor.shape = 1000,
            _ => actor.pose.position.y = f64::INFINITY,
        }
    }
    assert!(render(&broken, &camera(DVec3::ZERO), &SHOT).light == empty.light);
    let tiny = Shot { width: 0, height: 0, ..SHOT };
    assert_eq!(render(&stage(DVec3::ZERO), &camera(DVec3::ZERO), &tiny).light.len(), 1);
}
