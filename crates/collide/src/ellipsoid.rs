//! Ellipsoids: the furthest point, and the point nearest to another.
//!
//! The point x of the surface nearest to p lies where p − x is along the normal: x = a² p / (t + a²) for each axis of
//! half length a, with one t for all three. What is left is to find the t for which x is on the surface (Eberly,
//! "Distance from a point to an ellipse, an ellipsoid, or a hyperellipsoid", 2013, section 3). We start Newton's method at
//! the t that would do for one axis alone, the largest of the three: the function is convex and falls, is between 0 and 2
//! there, and every step stays on the near side of the root.

use crate::closest::Closest;
use crate::feature;
use rockfall_math::{DVec3, Vec3};

/// The point of an ellipsoid with half axes `half` that is furthest along a direction of any length.
pub(crate) fn support(half: Vec3, direction: DVec3) -> DVec3 {
    let half = half.as_dvec3();
    let stretched = half * direction;
    let length = stretched.length();
    if length > 0.0 { half * stretched / length } else { DVec3::Z * half.z }
}

/// The ellipsoid around the origin with half axes `half`, and a point.
pub(crate) fn point(half: Vec3, p: Vec3) -> Closest {
    let (a, p) = (half.as_dvec3(), p.as_dvec3());
    let x = nearest(a, p.abs());
    let x = DVec3::select(p.cmplt(DVec3::ZERO), -x, x);
    let normal = (x / (a * a)).normalize_or(DVec3::Z);
    Closest {
        distance: normal.dot(p - x) as f32,
        normal: normal.as_vec3(),
        on_a: x.as_vec3(),
        on_b: p.as_vec3(),
        feature: feature::pair(0, 0),
    }
}

/// The nearest point of the surface to a point whose coordinates are not negative.
fn nearest(a: DVec3, p: DVec3) -> DVec3 {
    // What is smaller than this share of its axis drowns beside 1 where Newton's method starts.
    let p = DVec3::select((p / a).cmpgt(DVec3::splat(1e-12)), p, DVec3::ZERO);
    let least = a.min_element();
    // In units of the shortest axis: r = (a / least)², y = p / a and s = t / least².
    let (r, y) = ((a / least) * (a / least), p / a);
    let short = r.to_array().map(|r| r <= 1.0);
    let on_short = (0..3).any(|k| short[k] && y[k] > 0.0);
    if !on_short {
        // In the plane through the centre across the shortest axis: near the centre two points are nearest, off the plane.
        let long = |k: usize| if short[k] { 0.0 } else { r[k] * p[k] / (r[k] - 1.0) };
        let x = DVec3::new(long(0), long(1), long(2));
        let rest = 1.0 - (x / a).length_squared();
        if rest >= 0.0 {
            let mut x = x;
            let k = (0..3).find(|&k| short[k]).unwrap_or(0);
            x[k] = a[k] * rest.sqrt();
            return x;
        }
    }
    // g(s) = Σ (r y / (s + r))² − 1.
    let start = |k: usize| if y[k] > 0.0 { r[k] * (y[k] - 1.0) } else { -1.0 };
    let mut s = start(0).max(start(1)).max(start(2));
    for _ in 0..MOST_STEPS {
        // Axes along which p has no part count for nothing, also where s + r is 0.
        let below = DVec3::select(y.cmpgt(DVec3::ZERO), DVec3::splat(s) + r, DVec3::ONE);
        let terms = r * y / below;
        let g = terms.length_squared() - 1.0;
        let slope = -2.0 * (terms * terms / below).element_sum();
        let next = s - g / slope;
        if g <= 0.0 || next <= s || next.is_nan() {
            break;
        }
        s = next;
    }
    let x = r * p / (DVec3::splat(s) + r);
    DVec3::select(p.cmpgt(DVec3::ZERO), x, DVec3::ZERO)
}

/// Newton's method needs five to ten.
const MOST_STEPS: usize = 100;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
        let half = Vec3::new(1.0, 2.0, 3.0);
        let c = point(half, Vec3::new(4.0, 0.0, 0.0));
        assert_eq!((c.distance, c.normal, c.on_a), (3.0, Vec3::X, Vec3::X));
        let c = point(half, Vec3::new(0.0, 0.0, -2.75));
        assert_eq!((c.distance, c.normal), (-0.25, -Vec3::Z));
        // The centre is nearest to the ends of the shortest axis, and a ball is one from all sides.
        assert_eq!(point(half, Vec3::ZERO).distance, -1.0);
        assert_eq!(point(Vec3::splat(2.0), Vec3::ZERO).distance, -2.0);
        let c = point(Vec3::splat(2.0), Vec3::new(3.0, 4.0, 0.0));
        assert_eq!((c.distance, c.normal), (3.0, Vec3::new(0.6, 0.8, 0.0)));
        // Next to nothing is nothing.
        let c = point(half, Vec3::new(f32::MIN_POSITIVE, 1.0, 0.0));
        assert!(c.distance < -0.5 && c.on_a.is_finite(), "{c:?}");
    }

    #[test]
    fn the_way_is_along_the_normal_and_none_is_shorter() {
        let f = |k: u32| rockfall_math::trig::sin(k as f32 * 1.7);
        for k in 0..500 {
            let half = Vec3::new(1.01 + f(k), 1.01 + f(k + 1), 1.01 + f(k + 2));
            let p = 2.0
                * Vec3::new(f(k + 3), f(k + 4), f(k + 5))
                * Vec3::from(((k & 1) as f32, 1.0, (k & 2) as f32));
            let c = point(half, p);
            let on = (c.on_a / half).as_dvec3().length_squared();
            assert!(
                (on - 1.0).abs() < 1e-5 && (c.on_a + c.distance * c.normal - p).length() < 2e-6,
                "{half} {p} {c:?}"
            );
            let inside = (p / half).length_squared() < 1.0;
            assert_eq!(c.distance < 0.0, inside);
            for j in 0..200_u32 {
                let q = Vec3::new(f(7 * j), f(11 * j + 1), f(13 * j + 2)).normalize_or(Vec3::X);
                let q = support(half, q.as_dvec3()).as_vec3();
                assert!(q.distance(p) > c.distance.abs() - 1e-5, "{half} {p} {c:?} {q}");
            }
        }
    }
}
