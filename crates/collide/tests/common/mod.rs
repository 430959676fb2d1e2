//! What the tests share: random numbers that are the same on every machine, and shapes of another size.

#![allow(dead_code)] // Every test uses another part of it.

use rockfall_math::{Isometry, Mat3, Quat, Vec3, hash, rotation};
use rockfall_shape::{Hull, Shape};
use std::sync::Arc;

/// A stream of numbers.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        hash::mix(self.0)
    }

    /// Uniform in [low, high).
    pub(crate) fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * ((self.word() >> 40) as f32 / (1_u64 << 24) as f32)
    }

    /// Each coordinate uniform in [-reach, reach).
    pub(crate) fn point(&mut self, reach: f32) -> Vec3 {
        Vec3::new(self.between(-reach, reach), self.between(-reach, reach), self.between(-reach, reach))
    }

    /// Uniform on the sphere.
    pub(crate) fn direction(&mut self) -> Vec3 {
        loop {
            let v = self.point(1.0);
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }

    /// Any rotation.
    pub(crate) fn turn(&mut self) -> Quat {
        let v = self.point(1.0);
        rotation::normalize(Quat::from_xyzw(v.x, v.y, v.z, self.between(-1.0, 1.0)))
    }

    /// Any rotation, and a point in a cube of this half edge.
    pub(crate) fn place(&mut self, reach: f32) -> Isometry {
        Isometry { rotation: Mat3::from_quat(self.turn()), translation: self.point(reach) }
    }
}

/// A convex shape, so many times as large.
pub(crate) fn at_size(shape: &Shape, by: f32) -> Shape {
    let hull = |hull: &Hull| {
        let corners: Vec<Vec3> = hull.vertices.iter().map(|v| *v * by).collect();
        Arc::new(Hull::from_points(&corners).unwrap())
    };
    match shape {
        Shape::Sphere { radius } => Shape::Sphere { radius: by * radius },
        Shape::Box { half } => Shape::Box { half: by * *half },
        Shape::Capsule { half_length, radius } => {
            Shape::Capsule { half_length: by * half_length, radius: by * radius }
        }
        Shape::Cylinder { half_length, radius } => {
            Shape::Cylinder { half_length: by * half_length, radius: by * radius }
        }
        Shape::Cone { half_length, lower, upper } => {
            Shape::Cone { half_length: by * half_length, lower: by * lower, upper: by * upper }
        }
        Shape::Ellipsoid { half } => Shape::Ellipsoid { half: by * *half },
        Shape::RoundedBox { half, radius } => Shape::RoundedBox { half: by * *half, radius: by * radius },
        Shape::Hull(h) => Shape::Hull(hull(h)),
        Shape::RoundedHull { hull: h, radius } => Shape::RoundedHull { hull: hull(h), radius: by * radius },
        other => other.clone(),
    }
}
