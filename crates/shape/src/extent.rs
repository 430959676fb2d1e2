//! How far shapes reach: support points, outer and inner radius.

use crate::{Frustum, Hull, Shape};
use rockfall_math::Vec3;

impl Shape {
    /// The point of a bounded convex shape that is farthest along `direction`, which need not be of unit
    /// length. The first corner wins a tie. `None` for half-spaces, meshes, fields, height fields and compounds.
    pub fn support(&self, direction: Vec3) -> Option<Vec3> {
        match self {
            Shape::Sphere { radius } => Some(direction.normalize_or_zero() * *radius),
            Shape::Box { half } => Some(Vec3::select(direction.cmplt(Vec3::ZERO), -*half, *half)),
            Shape::Capsule { half_length, radius } => {
                let center = if direction.z < 0.0 { -*half_length } else { *half_length };
                Some(Vec3::Z * center + direction.normalize_or_zero() * *radius)
            }
            Shape::Cylinder { .. } | Shape::Cone { .. } => {
                Frustum::of(self).map(|f| f.support(direction.as_dvec3()).as_vec3())
            }
            Shape::Ellipsoid { half } => {
                let stretched = *half * direction;
                Some(*half * stretched.normalize_or_zero())
            }
            Shape::RoundedBox { half, radius } => {
                let corner = Vec3::select(direction.cmplt(Vec3::ZERO), -*half, *half);
                Some(corner + direction.normalize_or_zero() * *radius)
            }
            Shape::Hull(hull) => Some(hull.vertices[hull.support(direction)]),
            Shape::RoundedHull { hull, radius } => {
                Some(hull.vertices[hull.support(direction)] + direction.normalize_or_zero() * *radius)
            }
            Shape::HalfSpace { .. }
            | Shape::Mesh(_)
            | Shape::Field(_)
            | Shape::HeightField(_)
            | Shape::Compound(_) => None,
        }
    }

    /// Distance from `center` to the farthest point of the shape, metres; infinite for half-spaces. For an ellipsoid
    /// about another point than its centre, that much or a little more.
    pub fn radius_about(&self, center: Vec3) -> f32 {
        let farthest = |points: &mut dyn Iterator<Item = Vec3>| {
            points.map(|p| (p - center).length_squared()).fold(0.0, f32::max).sqrt()
        };
        match self {
            Shape::Sphere { radius } => center.length() + radius,
            Shape::Box { half } => (center.abs() + *half).length(),
            Shape::Capsule { half_length, radius } => {
                (center.abs() + Vec3::Z * *half_length).length() + radius
            }
            Shape::Cylinder { .. } | Shape::Cone { .. } => {
                Frustum::of(self).map_or(0.0, |f| f.radius_about(center))
            }
            Shape::Ellipsoid { half } => center.length() + half.max_element(),
            Shape::RoundedBox { half, radius } => (center.abs() + *half).length() + radius,
            Shape::Hull(hull) => farthest(&mut hull.vertices.iter().copied()),
            Shape::RoundedHull { hull, radius } => farthest(&mut hull.vertices.iter().copied()) + radius,
            Shape::HalfSpace { .. } => f32::INFINITY,
            Shape::Mesh(mesh) => farthest(&mut mesh.vertices.iter().copied()),
            Shape::Field(field) => farthest(&mut field.mesh().vertices.iter().copied()),
            Shape::HeightField(field) => farthest(&mut field.samples()),
            Shape::Compound(compound) => {
                compound.parts().iter().map(|part| part.radius_about(center)).fold(0.0, f32::max)
            }
        }
    }

    /// Radius of a ball that fits inside, metres: a body that moves by less in a step can't pass through a
    /// thin wall unseen. Infinite for half-spaces, zero for height fields and meshes without an inside, of a compound that of its thinnest part.
    pub fn inner_radius(&self) -> f32 {
        match self {
            Shape::Sphere { radius } | Shape::Capsule { radius, .. } => *radius,
            Shape::Box { half } | Shape::Ellipsoid { half } => half.min_element(),
            Shape::Cylinder { .. } | Shape::Cone { .. } => {
                Frustum::of(self).map_or(0.0, |f| f.inner_ball().1)
            }
            Shape::RoundedBox { half, radius } => half.min_element() + radius,
            Shape::Hull(hull) => hull.inner_radius,
            Shape::RoundedHull { hull, radius } => hull.inner_radius + radius,
            Shape::HalfSpace { .. } => f32::INFINITY,
            Shape::Field(field) => field.inner_ball().1,
            Shape::Mesh(mesh) => mesh.inner_ball.1,
            Shape::HeightField(_) => 0.0,
            Shape::Compound(compound) => compound.thinnest().shape.inner_radius(),
        }
    }
}

impl Shape {
    /// The length by which a body's contacts are measured, metres: how far ahead they are looked for, how long they follow the body. The inner radius; of a field and a mesh that has an inside, whose walls may be
    /// thin, a quarter of the outer radius if that is more.
    pub fn contact_scale(&self) -> f32 {
        match self {
            Shape::Field(field) => field.contact_scale(),
            Shape::Mesh(mesh) if mesh.inner_ball.1 == 0.0 => 0.0,
            Shape::Mesh(mesh) => mesh.inner_ball.1.max(0.25 * mesh.bounds.half_extents().length()),
            Shape::Compound(compound) => compound.thinnest().shape.contact_scale(),
            _ => self.inner_radius(),
        }
    }

    /// The centre of the ball of [`Shape::inner_radius`], in the shape's frame; the origin for what has none.
    pub fn inner_center(&self) -> Vec3 {
        match self {
            Shape::Hull(hull) | Shape::RoundedHull { hull, .. } => hull.center,
            Shape::Field(field) => field.inner_ball().0,
            Shape::Mesh(mesh) => mesh.inner_ball.0,
            Shape::Cylinder { .. } | Shape::Cone { .. } => {
                Frustum::of(self).map_or(Vec3::ZERO, |f| Vec3::Z * f.inner_ball().0)
            }
            Shape::Compound(compound) => {
                let part = compound.thinnest();
                part.place.point(part.shape.inner_center())
            }
            _ => Vec3::ZERO,
        }
    }
}

impl Hull {
    /// The corner that is farthest along `direction`, the first of several.
    pub fn support(&self, direction: Vec3) -> usize {
        let mut best = (0, f32::NEG_INFINITY);
        for (i, v) in self.vertices.iter().enumerate() {
            let reach = direction.dot(*v);
            if reach > best.1 {
                best = (i, reach);
            }
        }
        best.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    fn shapes() -> Vec<Shape> {
        vec![
            Shape::Sphere { radius: 0.7 },
            Shape::Box { half: Vec3::new(0.5, 2.0, 0.25) },
            Shape::Capsule { half_length: 1.5, radius: 0.2 },
            Shape::Hull(Arc::new(Hull::cuboid(Vec3::new(1.0, 0.1, 0.3)))),
            Shape::Cylinder { half_length: 0.5, radius: 1.0 },
            Shape::Cone { half_length: 1.0, lower: 0.75, upper: 0.0 },
            Shape::Cone { half_length: 0.5, lower: 0.25, upper: 2.0 },
            Shape::Ellipsoid { half: Vec3::new(0.5, 2.0, 0.25) },
            Shape::RoundedBox { half: Vec3::new(0.5, 2.0, 0.25), radius: 0.125 },
            Shape::RoundedHull { hull: Arc::new(Hull::cuboid(Vec3::new(1.0, 0.5, 0.25))), radius: 0.25 },
        ]
    }

    #[test]
    fn support_points_touch_the_box_around_the_shape() {
        for shape in shapes() {
            let b = shape.bounds();
            for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                let high = shape.support(3.0 * axis).unwrap().dot(axis);
                let low = shape.support(-axis).unwrap().dot(axis);
                assert_eq!((low, high), (b.min.dot(axis), b.max.dot(axis)), "{}", shape.name());
            }
        }
        assert_eq!(Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 }.support(Vec3::Z), None);
    }

    #[test]
    fn no_support_point_is_outside_the_outer_radius_or_inside_the_inner_one() {
        for shape in shapes() {
            let center = Vec3::new(0.1, -0.2, 0.05);
            let outer = shape.radius_about(center);
            let mut farthest = 0.0_f32;
            for i in 0..1000 {
                let (s, c) = rockfall_math::trig::sin_cos(i as f32);
                let direction = Vec3::new(s, c, (i as f32) / 500.0 - 1.0).normalize();
                let p = shape.support(direction).unwrap();
                farthest = farthest.max((p - center).length());
                let inner = (p - shape.inner_center()).dot(direction);
                assert!(inner >= shape.inner_radius() * 0.999_999, "{}", shape.name());
            }
            assert!(farthest <= outer * 1.000_001 && farthest > 0.9 * outer, "{}", shape.name());
        }
    }
}
