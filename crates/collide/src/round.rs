//! Spheres and capsules among themselves: closed forms around the nearest points of their cores.

use crate::closest::{CONCENTRIC, Closest};
use crate::feature;
use crate::segments;
use crate::{ContactPoint, Manifold};
use rockfall_math::{Isometry, Vec3};

/// The core of a capsule and the thickness of the skin around it, metres.
#[derive(Clone, Copy)]
pub(crate) struct Capsule {
    pub(crate) half_length: f32,
    pub(crate) radius: f32,
}

impl Capsule {
    /// Ends of the core in the capsule's own frame.
    pub(crate) fn core(&self) -> [Vec3; 2] {
        [Vec3::new(0.0, 0.0, -self.half_length), Vec3::new(0.0, 0.0, self.half_length)]
    }

    /// Ends of the core in the frame that `pose` maps to.
    pub(crate) fn placed_core(&self, pose: &Isometry) -> [Vec3; 2] {
        let reach = self.half_length * pose.rotation.z_axis;
        [pose.translation - reach, pose.translation + reach]
    }
}

/// Cores whose distance is below this share of their size touch: their difference has no direction.
const TOUCH: f32 = 1e-6;

/// Cores that stay side by side to this share of the smaller radius, over the stretch that they have in common,
/// touch along a line, with a point at each end of it.
const ASIDE: f32 = 0.1;

/// Two spheres.
pub(crate) fn spheres(a: f32, b: f32, b_in_a: &Isometry) -> Closest {
    let distance = b_in_a.translation.length();
    // Concentric spheres may part in any direction.
    let normal = if distance > CONCENTRIC { b_in_a.translation / distance } else { Vec3::Z };
    let core = Closest {
        distance,
        normal,
        on_a: Vec3::ZERO,
        on_b: b_in_a.translation,
        feature: feature::pair(0, 0),
    };
    core.with_skins(a, b)
}

/// A capsule and a sphere.
pub(crate) fn capsule_sphere(a: Capsule, b: f32, b_in_a: &Isometry) -> Closest {
    let center = b_in_a.translation;
    let on_core = Vec3::new(0.0, 0.0, center.z.clamp(-a.half_length, a.half_length));
    let between = center - on_core;
    let distance = between.length();
    let normal = if distance > CONCENTRIC { between / distance } else { Vec3::X };
    let feature = feature::pair(height_name(a, center.z), 0);
    Closest { distance, normal, on_a: on_core, on_b: center, feature }.with_skins(a.radius, b)
}

/// Names the end of a capsule's core that is nearest to a point at this height, or what is between the ends.
pub(crate) fn height_name(a: Capsule, z: f32) -> usize {
    end_or_side(segments::nearest_to_point(a.core(), Vec3::Z * z))
}

/// Two capsules at their nearest points.
pub(crate) fn capsules(a: Capsule, b: Capsule, b_in_a: &Isometry) -> Closest {
    nearest_cores(a, b, b_in_a).with_skins(a.radius, b.radius)
}

/// The manifold of two capsules: two points where they lie side by side, else one; or their distance.
pub(crate) fn capsules_manifold(
    a: Capsule,
    b: Capsule,
    b_in_a: &Isometry,
    margin: f32,
) -> Result<Manifold, f32> {
    let cores = nearest_cores(a, b, b_in_a);
    let nearest = cores.with_skins(a.radius, b.radius);
    if nearest.distance > margin {
        return Err(nearest.distance);
    }
    let mut manifold = nearest.manifold();
    let across = b_in_a.rotation.z_axis;
    // Clearly not parallel, or the normal leans along the cores, which then meet end to end.
    if across.z.abs() < 0.99 || nearest.normal.z.abs() > 0.05 {
        return Ok(manifold);
    }
    // The stretch of A's axis that both cores cover; B's point at height z of A is on B's line.
    let [p, q] = b.placed_core(b_in_a);
    let (low, high) = (p.z.min(q.z).max(-a.half_length), p.z.max(q.z).min(a.half_length));
    let radius = a.radius.min(b.radius);
    let aside = (high - low) * across.cross(nearest.normal).cross(nearest.normal).cross(Vec3::Z).length();
    if high - low <= 0.1 * radius || aside > ASIDE * radius {
        return Ok(manifold);
    }
    manifold.count = 0;
    for (z, own_end) in [(low, low == -a.half_length), (high, high == a.half_length)] {
        let on_a = Vec3::new(0.0, 0.0, z);
        let on_b = p + (q - p) * ((z - p.z) / (q.z - p.z));
        let gap = (on_b - on_a).dot(nearest.normal).max(cores.distance);
        let distance = gap - (a.radius + b.radius);
        if distance <= margin {
            let upper = z == high;
            manifold.points[manifold.count as usize] = ContactPoint {
                position: 0.5 * (on_a + on_b + (a.radius - b.radius) * nearest.normal),
                distance,
                feature: feature::pair(4 + 2 * usize::from(upper) + usize::from(own_end), 1),
            };
            manifold.count += 1;
        }
    }
    if manifold.count == 0 || manifold.deepest() > nearest.distance + TOUCH * (a.half_length + b.half_length)
    {
        manifold.points[manifold.count as usize] = nearest.point();
        manifold.count += 1;
    }
    Ok(manifold)
}

fn nearest_cores(a: Capsule, b: Capsule, b_in_a: &Isometry) -> Closest {
    let (core_a, core_b) = (a.core(), b.placed_core(b_in_a));
    let nearest = segments::nearest(core_a, core_b);
    let (on_a, on_b) = nearest.points();
    let between = nearest.on_second - nearest.on_first;
    let distance = between.length() as f32;
    let size = a.half_length + b.half_length + a.radius + b.radius;
    let normal = if distance > TOUCH * size {
        (between / between.length()).as_vec3()
    } else {
        let common = common_perpendicular(b_in_a.rotation.z_axis);
        if common.dot(between.as_vec3()) < 0.0 { -common } else { common }
    };
    let feature = feature::pair(end_or_side(nearest.s as f32), end_or_side(nearest.t as f32));
    Closest { distance, normal, on_a, on_b, feature }
}

/// A unit vector at right angles to z and to `axis`.
fn common_perpendicular(axis: Vec3) -> Vec3 {
    let (x, y) = (-axis.y, axis.x);
    let length = (x * x + y * y).sqrt();
    if length > TOUCH { Vec3::new(x / length, y / length, 0.0) } else { Vec3::X }
}

/// Names the end of a core, or what is between its ends.
pub(crate) fn end_or_side(t: f32) -> usize {
    if t <= 0.0 {
        0
    } else if t >= 1.0 {
        1
    } else {
        2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::{Mat3, Quat, rotation};

    fn at(translation: Vec3, turn: Quat) -> Isometry {
        Isometry { rotation: Mat3::from_quat(turn), translation }
    }

    #[test]
    fn spheres_by_hand() {
        let c = spheres(1.0, 0.5, &at(Vec3::new(0.0, 2.0, 0.0), Quat::IDENTITY));
        assert_eq!((c.distance, c.normal), (0.5, Vec3::Y));
        assert_eq!((c.on_a, c.on_b), (Vec3::Y, 1.5 * Vec3::Y));
        let c = spheres(1.0, 0.5, &Isometry::IDENTITY);
        assert_eq!((c.distance, c.normal.length()), (-1.5, 1.0));
    }

    #[test]
    fn parallel_capsules_touch_at_both_ends_of_their_common_stretch() {
        let capsule = Capsule { half_length: 1.0, radius: 0.25 };
        let m =
            capsules_manifold(capsule, capsule, &at(Vec3::new(0.5, 0.0, 0.5), Quat::IDENTITY), 0.1).unwrap();
        assert_eq!((m.count, m.normal), (2, Vec3::X));
        assert_eq!(m.points[0].position, Vec3::new(0.25, 0.0, -0.5));
        assert_eq!(m.points[1].position, Vec3::new(0.25, 0.0, 1.0));
        assert_ne!(m.points[0].feature, m.points[1].feature);
    }

    #[test]
    fn crossed_cores_part_along_their_common_perpendicular() {
        let capsule = Capsule { half_length: 1.0, radius: 0.25 };
        let quarter = rotation::from_rotation_vector(Vec3::X * std::f32::consts::FRAC_PI_2);
        let m = capsules_manifold(capsule, capsule, &at(Vec3::ZERO, quarter), 0.1).unwrap();
        assert_eq!(m.count, 1);
        assert!((m.normal.x.abs() - 1.0).abs() < 1e-6);
        assert!((m.points[0].distance + 0.5).abs() < 1e-6);
    }

    #[test]
    fn coincident_capsules_have_a_normal() {
        let capsule = Capsule { half_length: 1.0, radius: 0.25 };
        let m = capsules_manifold(capsule, capsule, &Isometry::IDENTITY, 0.1).unwrap();
        assert_eq!((m.count, m.normal.length(), m.deepest()), (2, 1.0, -0.5));
    }
}
