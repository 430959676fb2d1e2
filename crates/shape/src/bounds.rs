//! Boxes around shapes, at rest in their own frame and placed in the world.

use crate::{Frustum, Hull, Part, Shape};
use rockfall_math::{Aabb, DVec3, Mat3, Pose, Vec3, rotation};

/// Half-spaces have no end; their boxes reach to this coordinate, metres: finite, so that sums and areas of
/// boxes are, and beyond every place in the world.
pub const UNBOUNDED: f32 = 1e15;

impl Shape {
    /// The smallest box around the shape in its own frame; see [`Shape::placed_bounds`] for half-spaces.
    pub fn bounds(&self) -> Aabb {
        match self {
            Shape::Sphere { radius } => symmetric(Vec3::splat(*radius)),
            Shape::Box { half } => symmetric(*half),
            Shape::Capsule { half_length, radius } => {
                symmetric(Vec3::new(*radius, *radius, *half_length + *radius))
            }
            Shape::Cylinder { .. } | Shape::Cone { .. } => {
                let (r, h) = Frustum::of(self).map_or((0.0, 0.0), |f| (f.widest(), f.half_length));
                symmetric(Vec3::new(r, r, h))
            }
            Shape::Ellipsoid { half } => symmetric(*half),
            Shape::RoundedBox { half, radius } => symmetric(*half + *radius),
            Shape::Hull(hull) => hull.bounds,
            Shape::RoundedHull { hull, radius } => hull.bounds.grown(*radius),
            Shape::HalfSpace { normal, offset } => half_space(*normal, f64::from(*offset)),
            Shape::Mesh(mesh) => mesh.bounds,
            Shape::Field(field) => field.mesh().bounds,
            Shape::HeightField(field) => field.bounds,
            Shape::Compound(compound) => compound.bounds(),
        }
    }

    /// A box around the shape placed in the world, rounded outwards. The smallest one for convex shapes (up
    /// to a millionth of their size); for turned meshes, fields and height fields the one around their turned box; for compounds the one around the boxes of their parts. A half-space reaches to [`UNBOUNDED`] on all sides, but ends at its surface
    /// where its normal is along an axis.
    pub fn placed_bounds(&self, pose: &Pose) -> Aabb {
        match self {
            Shape::Sphere { radius } => around(pose.position, Vec3::splat(*radius)),
            Shape::Box { half } => placed_box(*half, pose),
            Shape::RoundedBox { half, radius } => outwards(placed_box(*half, pose), *radius),
            Shape::Capsule { half_length, radius } => {
                let axis = rotation::rotate(pose.rotation, Vec3::Z * *half_length);
                around(pose.position, axis.abs() + Vec3::splat(*radius + rounding(axis.abs())))
            }
            Shape::Cylinder { half_length, radius } => {
                let frustum = Frustum { half_length: *half_length, lower: *radius, upper: *radius };
                placed_frustum(&frustum, pose)
            }
            Shape::Cone { half_length, lower, upper } => {
                let frustum = Frustum { half_length: *half_length, lower: *lower, upper: *upper };
                placed_frustum(&frustum, pose)
            }
            Shape::Ellipsoid { half } => {
                // Along each axis as far as the half axes reach, summed in squares.
                let r = matrix(pose);
                let [x, y, z] = [r.x_axis * half.x, r.y_axis * half.y, r.z_axis * half.z];
                let squares = x * x + y * y + z * z;
                let reach = Vec3::new(squares.x.sqrt(), squares.y.sqrt(), squares.z.sqrt());
                around(pose.position, reach + Vec3::splat(rounding(*half)))
            }
            Shape::Hull(hull) => placed_hull(hull, pose),
            Shape::RoundedHull { hull, radius } => outwards(placed_hull(hull, pose), *radius),
            Shape::HalfSpace { normal, offset } => {
                let turned = rotation::rotate(pose.rotation, *normal);
                half_space(turned, f64::from(*offset) + turned.as_dvec3().dot(pose.position))
            }
            Shape::Mesh(_) | Shape::Field(_) | Shape::HeightField(_) => {
                let local = self.bounds();
                local.grown(rounding(local.min.abs().max(local.max.abs()))).placed(pose)
            }
            Shape::Compound(compound) => {
                let of = |part: &Part| part.shape.placed_bounds(&part.within(pose));
                let all = compound.parts().iter().map(of).fold(Aabb::EMPTY, |all, one| all.union(&one));
                let local = compound.bounds();
                all.grown(rounding(local.min.abs().max(local.max.abs())))
            }
        }
    }
}

/// What a rotation in single precision may add to coordinates up to `size`.
fn rounding(size: Vec3) -> f32 {
    4.0 * f32::EPSILON * size.max_element()
}

fn matrix(pose: &Pose) -> Mat3 {
    pose.isometry_from(pose.position).rotation
}

fn symmetric(half: Vec3) -> Aabb {
    Aabb::new(-half, half)
}

fn around(center: DVec3, half: Vec3) -> Aabb {
    Aabb::around(center - half.as_dvec3(), center + half.as_dvec3())
}

fn placed_hull(hull: &Hull, pose: &Pose) -> Aabb {
    let turn = matrix(pose);
    let turned = Aabb::from_points(hull.vertices.iter().map(|v| turn * *v));
    let margin = DVec3::splat(f64::from(rounding(hull.bounds.min.abs().max(hull.bounds.max.abs()))));
    let min = pose.position + turned.min.as_dvec3() - margin;
    let max = pose.position + turned.max.as_dvec3() + margin;
    Aabb::around(min, max)
}

fn placed_box(half: Vec3, pose: &Pose) -> Aabb {
    let r = matrix(pose);
    let reach = r.x_axis.abs() * half.x + r.y_axis.abs() * half.y + r.z_axis.abs() * half.z;
    around(pose.position, reach + Vec3::splat(rounding(half)))
}

/// The box around both ends, which are discs.
fn placed_frustum(frustum: &Frustum, pose: &Pose) -> Aabb {
    let r = matrix(pose);
    let axis = r.z_axis * frustum.half_length;
    let wide = r.x_axis * r.x_axis + r.y_axis * r.y_axis;
    let wide = Vec3::new(wide.x.sqrt(), wide.y.sqrt(), wide.z.sqrt());
    let margin = rounding(Vec3::splat(frustum.widest() + frustum.half_length));
    let (low, high) = (wide * frustum.lower + margin, wide * frustum.upper + margin);
    let min = (-axis - low).min(axis - high).as_dvec3();
    let max = (-axis + low).max(axis + high).as_dvec3();
    Aabb::around(pose.position + min, pose.position + max)
}

/// A box that was rounded outwards, grown by `radius`, again rounded outwards.
fn outwards(inner: Aabb, radius: f32) -> Aabb {
    let radius = DVec3::splat(f64::from(radius));
    Aabb::around(inner.min.as_dvec3() - radius, inner.max.as_dvec3() + radius)
}

fn half_space(normal: Vec3, offset: f64) -> Aabb {
    let mut whole = symmetric(Vec3::splat(UNBOUNDED));
    let surface = Aabb::around(DVec3::splat(offset), DVec3::splat(offset));
    for axis in 0..3 {
        let mut e = Vec3::ZERO;
        e[axis] = 1.0;
        if normal == e {
            whole.max[axis] = surface.max[axis];
        } else if normal == -e {
            whole.min[axis] = -surface.max[axis];
        }
    }
    whole
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_core::{Rng, SeedableRng};
    use rockfall_math::Quat;
    use std::sync::Arc;

    fn poses() -> Vec<Pose> {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut next = move || (rng.next_u32() >> 8) as f32 / (1 << 23) as f32 - 1.0;
        (0..200)
            .map(|i| Pose {
                position: DVec3::new(next().into(), next().into(), next().into()) * f64::from(1 << (i % 20)),
                rotation: rotation::normalize(Quat::from_xyzw(next(), next(), next(), next())),
            })
            .collect()
    }

    /// The box must contain the exact one and exceed it by rounding only.
    fn assert_tight(shape: &Shape, corners: &[Vec3], radius: f32) {
        for pose in poses() {
            let q = pose.rotation.as_dquat();
            let placed: Vec<DVec3> = corners.iter().map(|c| pose.position + q * c.as_dvec3()).collect();
            let r = DVec3::splat(f64::from(radius));
            let min = placed.iter().fold(DVec3::INFINITY, |m, p| m.min(*p)) - r;
            let max = placed.iter().fold(DVec3::NEG_INFINITY, |m, p| m.max(*p)) + r;
            let found = shape.placed_bounds(&pose);
            let low = min - found.min.as_dvec3();
            let high = found.max.as_dvec3() - max;
            let allowed =
                2e-6 * f64::from(shape.radius_about(Vec3::ZERO)) + 2e-7 * pose.position.abs().max_element();
            for gap in [low.to_array(), high.to_array()].concat() {
                assert!((0.0..allowed).contains(&gap), "{} {gap} {allowed}", shape.name());
            }
        }
    }

    #[test]
    fn placed_bounds_are_tight_and_never_too_small() {
        let half = Vec3::new(0.5, 2.0, 0.25);
        let corners = Hull::cuboid(half).vertices;
        assert_tight(&Shape::Box { half }, &corners, 0.0);
        assert_tight(&Shape::Hull(Arc::new(Hull::cuboid(half))), &corners, 0.0);
        assert_tight(&Shape::Sphere { radius: 0.7 }, &[Vec3::ZERO], 0.7);
        assert_tight(
            &Shape::Capsule { half_length: 1.5, radius: 0.2 },
            &[1.5 * Vec3::Z, -1.5 * Vec3::Z],
            0.2,
        );
    }

    /// As [`assert_tight`], for round shapes: their exact reach along a direction in their own frame.
    fn assert_tight_along(shape: &Shape, reach: impl Fn(DVec3) -> f64) {
        for pose in poses() {
            let q = pose.rotation.as_dquat();
            let found = shape.placed_bounds(&pose);
            let allowed =
                2e-6 * f64::from(shape.radius_about(Vec3::ZERO)) + 2e-7 * pose.position.abs().max_element();
            for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                let own = q.conjugate() * axis;
                let at = pose.position.dot(axis);
                let high = found.max.as_dvec3().dot(axis) - (at + reach(own));
                let low = at - reach(-own) - found.min.as_dvec3().dot(axis);
                assert!((0.0..allowed).contains(&high), "{} {high} {allowed}", shape.name());
                assert!((0.0..allowed).contains(&low), "{} {low} {allowed}", shape.name());
            }
        }
    }

    #[test]
    fn placed_bounds_of_round_shapes_are_tight_and_never_too_small() {
        let disc = |d: DVec3, z: f64, r: f64| z * d.z + r * (d.x * d.x + d.y * d.y).sqrt();
        for (h, low, high) in [(0.5, 1.0, 1.0), (2.0, 0.3, 0.0), (0.1, 0.2, 1.5)] {
            let shape = Shape::Cone { half_length: h, lower: low, upper: high };
            let (h, low, high) = (f64::from(h), f64::from(low), f64::from(high));
            assert_tight_along(&shape, |d| disc(d, -h, low).max(disc(d, h, high)));
        }
        assert_tight_along(&Shape::Cylinder { half_length: 0.25, radius: 2.0 }, |d| {
            disc(d, 0.25, 2.0).max(disc(d, -0.25, 2.0))
        });
        let half = Vec3::new(0.5, 2.0, 0.25);
        assert_tight_along(&Shape::Ellipsoid { half }, |d| (half.as_dvec3() * d).length());
        let grown = |d: DVec3| half.as_dvec3().dot(d.abs()) + 0.125;
        assert_tight_along(&Shape::RoundedBox { half, radius: 0.125 }, grown);
        let hull = Arc::new(Hull::cuboid(half));
        assert_tight_along(&Shape::RoundedHull { hull, radius: 0.125 }, grown);
    }

    #[test]
    fn bounds_in_its_own_frame() {
        let shape = Shape::Capsule { half_length: 2.0, radius: 0.5 };
        assert_eq!(shape.bounds(), symmetric(Vec3::new(0.5, 0.5, 2.5)));
        assert_eq!(Shape::Sphere { radius: 0.5 }.bounds(), symmetric(Vec3::splat(0.5)));
    }

    #[test]
    fn a_half_space_ends_at_its_surface_only_along_an_axis() {
        let floor = Shape::HalfSpace { normal: Vec3::Z, offset: 2.0 };
        let b = floor.placed_bounds(&Pose::at(DVec3::new(5.0, 5.0, 1.0)));
        assert_eq!(b, Aabb::new(Vec3::splat(-UNBOUNDED), Vec3::new(UNBOUNDED, UNBOUNDED, 3.0)));
        let ceiling = Shape::HalfSpace { normal: -Vec3::Z, offset: -4.0 };
        assert_eq!(ceiling.bounds().min.z, 4.0);
        let slope = Shape::HalfSpace { normal: Vec3::new(0.6, 0.0, 0.8), offset: 0.0 };
        assert_eq!(slope.bounds(), symmetric(Vec3::splat(UNBOUNDED)));
        assert!(slope.bounds().is_valid());
    }
}
