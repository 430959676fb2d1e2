//! Bodies that follow a path, whatever they meet.

use super::{Placed, RATE};
use rockfall::math::{DVec3, Pose, Quat, Vec3, rotation};

/// A body whose pose at any time is known.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Driven {
    /// Into [`Scene::shapes`](super::Scene::shapes).
    pub(crate) shape: usize,
    pub(super) path: Path,
}

/// How it goes.
#[derive(Clone, Copy, Debug)]
pub(super) enum Path {
    /// Around the z axis, without turning itself.
    Circle {
        /// Metres.
        radius: f64,
        /// rad/s; positive from x to y.
        rate: f64,
    },
    /// About its own origin.
    Spin {
        /// Where the origin starts.
        middle: DVec3,
        /// Of the origin, m/s.
        velocity: DVec3,
        /// Unit vector.
        axis: Vec3,
        /// rad/s.
        rate: f64,
    },
}

impl Driven {
    /// Where it is after so many steps.
    pub(crate) fn after(&self, steps: u32) -> Pose {
        let time = f64::from(steps) / f64::from(RATE);
        match self.path {
            Path::Circle { radius, rate } => {
                let (sin, cos) = (rate * time).sin_cos();
                Pose::at(DVec3::new(radius * cos, radius * sin, 0.0))
            }
            Path::Spin { middle, velocity, axis, rate } => {
                let (sin, cos) = (0.5 * rate * time).sin_cos();
                let rotation = Quat::from_vec4((axis * sin as f32).extend(cos as f32));
                Pose { position: middle + velocity * time, rotation: rotation::normalize(rotation) }
            }
        }
    }

    /// The shape where it is after so many steps.
    pub(crate) fn placed(&self, steps: u32) -> Placed {
        Placed { shape: self.shape, pose: self.after(steps) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    #[test]
    fn a_quarter_of_a_circle_ends_on_the_other_axis() {
        let driven = Driven { shape: 0, path: Path::Circle { radius: 35.0, rate: 0.5 * PI } };
        assert_eq!(driven.after(0), Pose::at(DVec3::new(35.0, 0.0, 0.0)));
        assert!((driven.after(60).position - DVec3::new(0.0, 35.0, 0.0)).length() < 1e-9);
    }

    #[test]
    fn a_spin_turns_points_about_the_axis_and_drifts() {
        let (middle, velocity) = (DVec3::new(0.0, 0.0, 21.0), DVec3::X);
        let path = Path::Spin { middle, velocity, axis: -Vec3::Y, rate: 0.5 * PI };
        let pose = Driven { shape: 0, path }.after(60);
        assert!((pose.point(Vec3::X) - DVec3::new(1.0, 0.0, 22.0)).length() < 1e-6, "{pose:?}");
    }
}
