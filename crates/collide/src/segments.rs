//! The nearest points of two segments.
//!
//! In double precision: where the segments are nearly parallel the place of the nearest points hangs on a small
//! difference, and with it the clamping to the ends (Ericson, *Real-Time Collision Detection*, section 5.1.9).

use rockfall_math::{DVec3, Vec3};

/// Nearest points of two segments; a parameter is 0 at a segment's first end and 1 at its second.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Nearest {
    pub(crate) s: f64,
    pub(crate) t: f64,
    pub(crate) on_first: DVec3,
    pub(crate) on_second: DVec3,
}

impl Nearest {
    /// Both points in single precision.
    pub(crate) fn points(&self) -> (Vec3, Vec3) {
        (self.on_first.as_vec3(), self.on_second.as_vec3())
    }
}

/// The nearest points of two segments; either may have no length. One pair of many where they are parallel.
pub(crate) fn nearest(first: [Vec3; 2], second: [Vec3; 2]) -> Nearest {
    let (p, q) = (first[0].as_dvec3(), second[0].as_dvec3());
    let (d, e) = (first[1].as_dvec3() - p, second[1].as_dvec3() - q);
    let r = p - q;
    let (dd, ee, de) = (d.length_squared(), e.length_squared(), d.dot(e));
    let (dr, er) = (d.dot(r), e.dot(r));
    let along = |x: f64, squared: f64| if squared > 0.0 { (x / squared).clamp(0.0, 1.0) } else { 0.0 };
    let determinant = dd * ee - de * de;
    let mut s =
        if determinant > 1e-12 * dd * ee { along(de * er - dr * ee, determinant) } else { along(-dr, dd) };
    // The nearest point of the second line to that one; where it leaves the segment, back again from its end.
    let reach = de * s + er;
    let t = if reach <= 0.0 || ee == 0.0 {
        s = along(-dr, dd);
        0.0
    } else if reach >= ee {
        s = along(de - dr, dd);
        1.0
    } else {
        reach / ee
    };
    Nearest { s, t, on_first: p + s * d, on_second: q + t * e }
}

/// The parameter of the point of a segment nearest to `p`.
pub(crate) fn nearest_to_point(segment: [Vec3; 2], p: Vec3) -> f32 {
    let d = segment[1] - segment[0];
    let squared = d.length_squared();
    if squared > 0.0 { ((p - segment[0]).dot(d) / squared).clamp(0.0, 1.0) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distance(first: [Vec3; 2], second: [Vec3; 2]) -> f64 {
        let n = nearest(first, second);
        (n.on_first - n.on_second).length()
    }

    #[test]
    fn crossed_parallel_and_collapsed_segments() {
        let x = [-Vec3::X, Vec3::X];
        assert_eq!(distance(x, [Vec3::new(0.0, -1.0, 2.0), Vec3::new(0.0, 1.0, 2.0)]), 2.0);
        assert_eq!(distance(x, [Vec3::new(-5.0, 1.0, 0.0), Vec3::new(5.0, 1.0, 0.0)]), 1.0);
        assert_eq!(distance(x, [Vec3::new(4.0, 0.0, 0.0), Vec3::new(9.0, 0.0, 0.0)]), 3.0);
        assert_eq!(distance(x, [Vec3::Y * 3.0; 2]), 3.0);
        assert_eq!(distance([Vec3::Y * 3.0; 2], x), 3.0);
        assert_eq!(distance([Vec3::ZERO; 2], [Vec3::Z; 2]), 1.0);
    }

    #[test]
    fn no_sampled_pair_of_points_is_nearer() {
        for k in 0..200_u32 {
            let f = |j: u32| rockfall_math::trig::sin((k * 31 + j * 17) as f32);
            let point = |j: u32| Vec3::new(f(j), f(j + 1), f(j + 2));
            let (first, second) = ([point(0), point(3)], [point(6), point(9)]);
            let least = distance(first, second);
            for i in 0..=20 {
                for j in 0..=20 {
                    let p = first[0].lerp(first[1], i as f32 / 20.0);
                    let q = second[0].lerp(second[1], j as f32 / 20.0);
                    assert!(f64::from(p.distance(q)) >= least - 1e-6);
                }
            }
        }
    }
}
