//! Cameras of scenes, at a moment.

use crate::camera::{Camera, Lens};
use crate::{Error, Sight};
use rockfall_math::{DVec3, trig};
use rockfall_scene::{Course, SceneCamera};

impl Camera {
    /// A camera of a scene at the moment of `sight`.
    ///
    /// # Errors
    /// [`Error::Unknown`] where it follows a body that is not there.
    pub fn of_scene(camera: &SceneCamera, sight: &Sight) -> Result<Camera, Error> {
        let (eye, target) = match &camera.course {
            Course::Fixed { position, target } => (*position, *target),
            Course::Orbit { target, distance, elevation, azimuth, speed } => {
                let turn = |angle: f64| trig::sin_cos((angle % std::f64::consts::TAU) as f32);
                let (sin, cos) = turn(azimuth + speed * sight.time);
                let (high, level) = turn(*elevation);
                let way = DVec3::new(f64::from(level * cos), f64::from(level * sin), f64::from(high));
                (*target + *distance * way, *target)
            }
            Course::Follow { body, offset } => {
                let found = sight.names.get(body).and_then(|&id| sight.row(id));
                let Some(row) = found else {
                    let why =
                        format!("the body `{body}`, which it follows, is not there at frame {}", sight.frame);
                    return Err(Error::Unknown { what: "camera", why });
                };
                let at = sight.bodies[row].pose.position;
                (at + *offset, at)
            }
            Course::Keys(keys) => between(keys, sight.time),
        };
        let lens = (camera.aperture > 0.0).then_some(Lens { aperture: camera.aperture, focus: camera.focus });
        Ok(Camera { eye, target, up: DVec3::Z, fov: camera.fov, lens })
    }
}

/// Place and target at a time: cubic between two keys, through each with the mean speed of the stretches beside it (Catmull and Rom, "A class of local
/// interpolating splines", 1974, for uneven times). It stands still before the first key and after the last one.
fn between(keys: &[(f64, DVec3, DVec3)], time: f64) -> (DVec3, DVec3) {
    let Some(next) = keys.iter().position(|key| key.0 > time) else {
        return keys.last().map_or((DVec3::ZERO, DVec3::Y), |key| (key.1, key.2));
    };
    if next == 0 {
        return (keys[0].1, keys[0].2);
    }
    let (a, b) = (next - 1, next);
    let length = keys[b].0 - keys[a].0;
    let s = (time - keys[a].0) / length;
    let curve = |of: &dyn Fn(usize) -> DVec3| {
        let speed = |k: usize| {
            let (before, after) = (k.saturating_sub(1), (k + 1).min(keys.len() - 1));
            (of(after) - of(before)) / (keys[after].0 - keys[before].0)
        };
        let (s2, s3) = (s * s, s * s * s);
        (2.0 * s3 - 3.0 * s2 + 1.0) * of(a)
            + (s3 - 2.0 * s2 + s) * length * speed(a)
            + (3.0 * s2 - 2.0 * s3) * of(b)
            + (s3 - s2) * length * speed(b)
    };
    (curve(&|k| keys[k].1), curve(&|k| keys[k].2))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera(course: Course) -> SceneCamera {
        SceneCamera { name: "a".into(), fov: 35.0, aperture: 0.0, focus: None, course }
    }

    fn at(course: &Course, time: f64) -> Camera {
        let sight = Sight { time, ..Sight::default() };
        Camera::of_scene(&camera(course.clone()), &sight).expect("a camera")
    }

    #[test]
    fn an_orbit_keeps_its_distance_and_comes_around() {
        let course = Course::Orbit {
            target: DVec3::new(1.0, 2.0, 3.0),
            distance: 5.0,
            elevation: 0.5,
            azimuth: 0.0,
            speed: std::f64::consts::PI,
        };
        let [start, half, whole] = [0.0, 1.0, 2.0].map(|time| at(&course, time));
        for camera in [start, half, whole] {
            assert!(((camera.eye - camera.target).length() - 5.0).abs() < 1e-5);
        }
        assert!((start.eye - whole.eye).length() < 1e-4);
        assert!((start.eye.x - half.eye.x).abs() > 8.0, "{} {}", start.eye, half.eye);
    }

    #[test]
    fn keys_are_passed_at_their_times_and_evenly_where_they_are_even() {
        let key = |time: f64| (time, DVec3::new(2.0 * time, 1.0, 0.0), DVec3::new(0.0, 10.0 - time, 0.0));
        let course = Course::Keys([1.0, 2.0, 4.0, 5.0].map(key).to_vec());
        for time in [1.0, 1.25, 2.0, 3.1, 4.0, 4.9, 5.0] {
            let camera = at(&course, time);
            assert!((camera.eye - key(time).1).length() < 1e-9, "{time}: {}", camera.eye);
            assert!((camera.target - key(time).2).length() < 1e-9);
        }
        assert_eq!(at(&course, 0.0).eye, key(1.0).1);
        assert_eq!(at(&course, 9.0).eye, key(5.0).1);
    }

    #[test]
    fn a_camera_whose_body_is_not_there_says_so() {
        let course = Course::Follow { body: "hammer".into(), offset: DVec3::Y };
        let error = Camera::of_scene(&camera(course), &Sight::default()).expect_err("no body").to_string();
        assert!(error.contains("`hammer`"), "{error}");
    }
}
