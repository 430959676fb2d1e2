//! A camera that finds its own place: three-quarter view, all that moves in the picture.

use super::Camera;
use crate::Stage;
use crate::view::{Beam, View};
use rockfall_math::{DVec3, trig};
use rockfall_shape::Shape;

/// Vertical field of view, degrees: that of a lens of 40 mm before a picture 36 mm wide, at 16 to 9.
const FOV: f32 = 28.0;

/// How far the line of sight points down, degrees.
const DOWN: f32 = 21.0;

/// Sides from which to look, degrees about z from the x axis, the favourite first: there the sun is on the left, a little behind the camera.
const SIDES: [f32; 8] = [-57.0, -100.0, -12.0, -145.0, 35.0, 170.0, 80.0, 125.0];

/// Share of the balls on each side that need not be in the picture, where there are many: what has flown off is not what it is about.
const LEFT_OUT: usize = 200;

/// Balls that are looked for behind what is in the way.
const LOOKED_FOR: usize = 400;

/// A side is better if it shows this share more.
const BETTER: f64 = 0.03;

/// Room around what fits exactly.
const ROOM: f64 = 1.12;

impl Camera {
    /// A three-quarter view of all `balls` (centres and radii, metres), which are those of one moment or of several, in a picture that is `aspect` times as wide
    /// as high. Of eight sides it takes the first from which most of them are to be seen on `stage`.
    pub fn fitting(stage: &Stage, balls: &[(DVec3, f64)], aspect: f64) -> Camera {
        let balls: Vec<(DVec3, f64)> = balls
            .iter()
            .copied()
            .filter(|(center, radius)| center.is_finite() && radius.is_finite())
            .collect();
        if balls.is_empty() {
            return Camera {
                eye: DVec3::new(6.0, -9.0, 5.0),
                target: DVec3::ZERO,
                up: DVec3::Z,
                fov: FOV,
                lens: None,
            };
        }
        let sight = |side: f32| {
            let (sin, cos) = trig::sin_cos(side.to_radians());
            let (down, along) = trig::sin_cos(DOWN.to_radians());
            -DVec3::new(f64::from(cos * along), f64::from(sin * along), f64::from(down))
        };
        let from = |side: f32| fit(&balls, sight(side), aspect);
        let favourite = from(SIDES[0]);
        let hides = |shape: &Shape| !matches!(shape, Shape::HalfSpace { .. });
        let walls = stage.actors.iter().any(|a| !a.moves && stage.shape_of(a).is_some_and(hides));
        if !walls {
            return favourite;
        }
        let view = View::new(stage, favourite.target);
        let step = balls.len().div_ceil(LOOKED_FOR);
        let shown = |camera: &Camera| {
            let some = balls.iter().step_by(step);
            let all = some.clone().count() as f64;
            let seen = some.filter(|(center, radius)| {
                let origin = camera.eye - favourite.target;
                let way = *center - camera.eye;
                let length = way.length();
                // As far as the ball's surface.
                let max = (1.0 - 1.01 * radius / length) as f32;
                let up = DVec3::Z * *radius * 0.9;
                let origin = origin.as_vec3();
                let free = |way: DVec3| !view.blocked_by_fixed(&Beam::new(origin, way.as_vec3(), max));
                max > 0.0 && (free(way) || free(way + up))
            });
            seen.count() as f64 / all
        };
        let mut best = (favourite, shown(&favourite));
        for side in &SIDES[1..] {
            let camera = from(*side);
            let share = shown(&camera);
            if share > best.1 + BETTER {
                best = (camera, share);
            }
        }
        best.0
    }
}

/// As near as possible along a line of sight. Each side of the picture is a plane through the eye; it has to leave the balls inside, and where two
/// opposite ones do, the eye is known across and in depth.
fn fit(balls: &[(DVec3, f64)], forward: DVec3, aspect: f64) -> Camera {
    let middle = balls.iter().map(|(center, _)| *center).sum::<DVec3>() / balls.len() as f64;
    let camera = Camera { eye: middle - forward, target: middle, up: DVec3::Z, fov: FOV, lens: None };
    let [right, up, forward] = camera.axes();
    let half = camera.half_height();
    let place = |axis: DVec3, tan: f64| {
        let tan = tan / ROOM;
        let scale = (1.0 + tan * tan).sqrt();
        // Of a ball at (a, d) across and in depth the eye at (e, z) needs ±(a - e) + r scale ≤ (d - z) tan.
        let reach = |sign: f64| {
            let mut reaches: Vec<f64> = balls
                .iter()
                .map(|(center, r)| {
                    let from = *center - middle;
                    sign * from.dot(axis) + r * scale - from.dot(forward) * tan
                })
                .collect();
            let place = reaches.len() - 1 - reaches.len() / LEFT_OUT;
            *reaches.select_nth_unstable_by(place, f64::total_cmp).1
        };
        let (plus, minus) = (reach(1.0), reach(-1.0));
        // plus ≤ e - z tan, minus ≤ -e - z tan.
        (0.5 * (plus - minus), -0.5 * (plus + minus) / tan)
    };
    let (across, depth) = place(right, half * aspect);
    let (above, depth_too) = place(up, half);
    let depth = depth.min(depth_too);
    let eye = middle + across * right + above * up + depth * forward;
    let distance = (middle - eye).dot(forward).max(1e-6);
    Camera { eye, target: eye + distance * forward, ..camera }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::hash::mix;

    /// A share of one, the same for the same number.
    fn share(k: u64) -> f64 {
        (mix(k) >> 11) as f64 / (1_u64 << 53) as f64
    }

    #[test]
    fn all_balls_are_in_the_picture_and_two_of_them_at_its_borders() {
        let point = |k: u64| DVec3::new(9.0 * share(3 * k), 4.0 * share(3 * k + 1), share(3 * k + 2));
        let balls: Vec<(DVec3, f64)> = (0..100).map(|k| (1e5 + 10.0 * point(k), 0.5 + share(k))).collect();
        for (width, height) in [(1280, 720), (300, 600)] {
            let camera = Camera::fitting(&Stage::default(), &balls, f64::from(width) / f64::from(height));
            let frame = camera.frame(width, height);
            let mut nearest = f64::INFINITY;
            for (center, radius) in &balls {
                let (at, distance) = frame.project(*center).expect("it is in front");
                let reach = radius / (distance * frame.pixel);
                for (x, size) in at.into_iter().zip([width, height]) {
                    let border = x.min(f64::from(size) - x) - 0.9 * reach;
                    assert!(border > 0.0, "{border} pixels from the border");
                    nearest = nearest.min(border / f64::from(size));
                }
            }
            assert!(nearest < 0.1, "{nearest} of the picture is empty on each side");
        }
    }

    #[test]
    fn one_body_far_away_does_not_shrink_a_thousand() {
        let mut balls: Vec<(DVec3, f64)> =
            (0..1000).map(|k| (DVec3::new(share(k), share(k + 5000), 0.0) * 10.0, 0.1)).collect();
        let near = Camera::fitting(&Stage::default(), &balls, 1.5);
        balls.push((DVec3::new(1e5, 0.0, 0.0), 0.1));
        let with = Camera::fitting(&Stage::default(), &balls, 1.5);
        let distance = |camera: &Camera| camera.eye.length();
        assert!(distance(&with) < 1.5 * distance(&near), "{with:?}");
    }
}
