//! A ray and any convex shape whose signed distance from a point is known: conservative advancement.
//!
//! At a point outside, the nearest point of the shape and the direction to it span a plane that the shape does not cross. The ray may advance to that
//! plane; if it moves away from it, it meets nothing. On a curved surface the steps shrink as those of Newton's method do.

use super::{INSIDE, Ray, RayHit, Stretch};
use crate::distance;
use rockfall_math::{DVec3, Isometry, Vec3};
use rockfall_shape::Shape;

/// Distance at which the surface is reached, as a share of the shape's outer radius: what single precision tells apart.
const REACHED: f64 = 1e-6;

/// A ray that grazes a surface comes near it slowly; most end within ten.
const MAX_STEPS: usize = 100;

/// [`cast_ray`](crate::cast_ray) for a bounded convex shape by [`distance`] alone, so that a kind of shape without a closed form can be met as well; the part
/// is always 0. Exact to a millionth of the shape's size along the normal, and slower by tens of times.
///
/// Nothing for half-spaces, meshes and height fields.
pub fn cast_ray_by_distance(shape: &Shape, ray: &Ray, solid: bool) -> Option<RayHit> {
    let center = shape.bounds().center().as_dvec3();
    let radius = f64::from(shape.radius_about(center.as_vec3()));
    if !ray.makes_sense() || !shape.is_convex() || !radius.is_finite() {
        return None;
    }
    // From where the line enters a ball around the shape to where it leaves that.
    let around = super::ball(center, 1.001 * radius, ray)?;
    let length = ray.direction.length();
    let [enter, exit] = [(around.enter, 1.0), (around.exit, -1.0)].map(|(start, sense)| {
        let way = Way { start: ray.at(start), direction: ray.direction * (sense / length), radius };
        let (gone, normal) = way.first(shape, (around.exit - around.enter) * length)?;
        Some((start + sense * gone / length, normal))
    });
    let ((enter, outside), (exit, beyond)) = (enter?, exit?);
    let stretch = Stretch { enter, exit: exit.max(enter), parts: [0, 1] };
    let (t, part) = stretch.seen(ray, solid)?;
    let normal = match part {
        INSIDE => Vec3::ZERO,
        0 => outside,
        _ => beyond,
    };
    Some(RayHit { t, normal, part: if part == INSIDE { INSIDE } else { 0 } })
}

struct Way {
    start: DVec3,
    direction: DVec3,
    radius: f64,
}

impl Way {
    /// How far it is to the shape, no further than `most`, metres, and the outward normal there.
    fn first(&self, shape: &Shape, most: f64) -> Option<(f64, Vec3)> {
        let mut gone = 0.0;
        let mut normal = -self.direction.as_vec3();
        for _ in 0..MAX_STEPS {
            let place = (self.start + gone * self.direction).as_vec3();
            let point = Isometry { translation: place, ..Isometry::IDENTITY };
            let near = distance(shape, &Shape::Sphere { radius: 0.0 }, &point)?;
            let gap = f64::from(near.distance);
            if gap <= REACHED * self.radius {
                return Some((gone, if gap > 0.0 { near.normal } else { normal }));
            }
            normal = near.normal;
            let closing = -near.normal.as_dvec3().dot(self.direction);
            if closing <= 0.0 {
                return None;
            }
            gone += gap / closing;
            if gone > most {
                return None;
            }
        }
        Some((gone, normal))
    }
}
