//! Axis-aligned boxes in single precision.

use crate::{Pose, Vec3};
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// An axis-aligned box, metres. Empty when `min > max` on any axis.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Aabb {
    /// Smallest corner.
    pub min: Vec3,
    /// Largest corner.
    pub max: Vec3,
}

impl Aabb {
    /// The box that contains nothing: the neutral element of [`Aabb::union`].
    pub const EMPTY: Aabb = Aabb { min: Vec3::INFINITY, max: Vec3::NEG_INFINITY };

    /// The box from `min` to `max`.
    pub const fn new(min: Vec3, max: Vec3) -> Self {
        Aabb { min, max }
    }

    /// The smallest box around `points`.
    pub fn from_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Aabb { min: b.min.min(p), max: b.max.max(p) })
    }

    /// The smallest single-precision box that contains the double-precision one from `min` to `max`: each side
    /// is rounded outwards, so that a box far from the origin grows but never shrinks.
    pub fn around(min: DVec3, max: DVec3) -> Self {
        let down = |x: f64| if f64::from(x as f32) > x { (x as f32).next_down() } else { x as f32 };
        let up = |x: f64| if f64::from(x as f32) < x { (x as f32).next_up() } else { x as f32 };
        Aabb {
            min: Vec3::new(down(min.x), down(min.y), down(min.z)),
            max: Vec3::new(up(max.x), up(max.y), up(max.z)),
        }
    }

    /// The box that this box, given in a body's frame, occupies in the world, not tight for a rotated box.
    pub fn placed(&self, pose: &Pose) -> Self {
        let rotation = pose.isometry_from(pose.position).rotation;
        let abs = glam::Mat3::from_cols(rotation.x_axis.abs(), rotation.y_axis.abs(), rotation.z_axis.abs());
        let centre = pose.position + (rotation * self.center()).as_dvec3();
        let half = (abs * self.half_extents()).as_dvec3();
        Aabb::around(centre - half, centre + half)
    }

    /// The smallest box around both.
    pub fn union(&self, other: &Aabb) -> Self {
        Aabb { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// This box, larger by `margin` on every side.
    pub fn grown(&self, margin: f32) -> Self {
        Aabb { min: self.min - Vec3::splat(margin), max: self.max + Vec3::splat(margin) }
    }

    /// Whether the two boxes share a point; touching counts.
    pub fn overlaps(&self, other: &Aabb) -> bool {
        self.min.cmple(other.max).all() && other.min.cmple(self.max).all()
    }

    /// Whether `other` lies inside this box.
    pub fn contains(&self, other: &Aabb) -> bool {
        self.min.cmple(other.min).all() && other.max.cmple(self.max).all()
    }

    /// Centre of the box.
    pub fn center(&self) -> Vec3 {
        0.5 * (self.min + self.max)
    }

    /// Half of the edge lengths.
    pub fn half_extents(&self) -> Vec3 {
        0.5 * (self.max - self.min)
    }

    /// Whether all six numbers are finite and the box is not empty.
    pub fn is_valid(&self) -> bool {
        self.min.is_finite() && self.max.is_finite() && self.min.cmple(self.max).all()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_outwards_never_loses_a_point() {
        for x in [1.0e7 + 0.3, -1.0e7 - 0.3, 1.0 / 3.0, -1.0 / 3.0] {
            let b = Aabb::around(DVec3::splat(x), DVec3::splat(x));
            assert!(f64::from(b.min.x) <= x && x <= f64::from(b.max.x));
        }
    }

    #[test]
    fn placed_box_contains_all_corners() {
        let b = Aabb::new(Vec3::new(-1.0, -2.0, -0.5), Vec3::new(3.0, 1.0, 0.5));
        let pose = Pose {
            position: DVec3::new(5.0, -7.0, 1.0e6),
            rotation: crate::Quat::from_xyzw(0.1, 0.7, -0.3, 0.6).normalize(),
        };
        let placed = b.placed(&pose).grown(1e-5);
        for i in 0..8 {
            let pick = |bit: i32, lo: f32, hi: f32| if i & bit == 0 { lo } else { hi };
            let corner =
                Vec3::new(pick(1, b.min.x, b.max.x), pick(2, b.min.y, b.max.y), pick(4, b.min.z, b.max.z));
            let p = pose.point(corner);
            assert!(p.cmpge(placed.min.as_dvec3()).all() && p.cmple(placed.max.as_dvec3()).all());
        }
    }
}
