//! Cylinders, cones, ellipsoids and rounded shapes with each other and with all others.
//!
//! The support function h(n) of each shape, how far it reaches along n, is a closed form. It proves distances without another
//! program: along a direction n, A and B are apart by −h_A(n) − h_B(−n), which no distance is less than; and a point of A and
//! one of B are no nearer than the distance. Where shapes overlap, the first is the overlap along n, and no direction may
//! have a smaller one: many are asked. parry3d is asked as well.

use crate::brute_force::size;
use crate::common::Random;
use crate::opinion::second_opinion;
use rockfall_collide::{Cache, Distance, Manifold, collide, distance};
use rockfall_math::{DVec3, Isometry, Vec3};
use rockfall_shape::Shape;

/// Poses for each pair of classes; the same in both orders.
const POSES: usize = 2_000;

/// Distances agree to this share of the size of the pair.
const EXACT: f64 = 1e-6;

/// Share of its radius by which the points of a disc may hide the deepest place of its rim.
const LEVEL: f64 = 1e-4;

/// A shape in a place, in double precision.
struct Body<'a> {
    shape: &'a Shape,
    axes: [DVec3; 3],
    origin: DVec3,
}

impl<'a> Body<'a> {
    fn new(shape: &'a Shape, pose: &Isometry) -> Self {
        let r = &pose.rotation;
        let axes = [r.x_axis, r.y_axis, r.z_axis].map(|axis| axis.as_dvec3());
        Body { shape, axes, origin: pose.translation.as_dvec3() }
    }

    fn own(&self, v: DVec3) -> DVec3 {
        DVec3::new(self.axes[0].dot(v), self.axes[1].dot(v), self.axes[2].dot(v))
    }

    /// The support function: the largest n · p of its points.
    fn reach(&self, n: DVec3) -> f64 {
        let d = self.own(n);
        let disc = |z: f32, r: f32| f64::from(z) * d.z + f64::from(r) * (d.x * d.x + d.y * d.y).sqrt();
        let hull =
            |points: &[Vec3]| points.iter().map(|p| p.as_dvec3().dot(d)).fold(f64::NEG_INFINITY, f64::max);
        let own = match self.shape {
            Shape::Sphere { radius } => f64::from(*radius),
            Shape::Box { half } => half.as_dvec3().dot(d.abs()),
            Shape::RoundedBox { half, radius } => half.as_dvec3().dot(d.abs()) + f64::from(*radius),
            Shape::Capsule { half_length, radius } => {
                f64::from(*half_length) * d.z.abs() + f64::from(*radius)
            }
            Shape::Cylinder { half_length: h, radius } => disc(*h, *radius).max(disc(-*h, *radius)),
            Shape::Cone { half_length: h, lower, upper } => disc(-*h, *lower).max(disc(*h, *upper)),
            Shape::Ellipsoid { half } => (half.as_dvec3() * d).length(),
            Shape::Hull(h) => hull(&h.vertices),
            Shape::RoundedHull { hull: h, radius } => hull(&h.vertices) + f64::from(*radius),
            // Along its own normal; without end elsewhere.
            Shape::HalfSpace { normal, offset } => {
                if d.distance(normal.as_dvec3()) < 1e-5 {
                    f64::from(*offset)
                } else {
                    f64::INFINITY
                }
            }
            Shape::Mesh(_) | Shape::Field(_) | Shape::HeightField(_) | Shape::Compound(_) => f64::INFINITY,
        };
        own + n.dot(self.origin)
    }

    /// How far a point is outside, at least, or above 0 by as much as it is inside: up to a factor near the surface of ellipsoids.
    fn out(&self, p: DVec3) -> f64 {
        let p = self.own(p - self.origin);
        let (across, z) = ((p.x * p.x + p.y * p.y).sqrt(), p.z);
        let beyond = |half: DVec3| (p.abs() - half).max_element();
        let frustum = |h: f32, lower: f32, upper: f32| {
            let (h, lower, upper) = (f64::from(h), f64::from(lower), f64::from(upper));
            let side = across - lower - (upper - lower) * (z + h) / (2.0 * h);
            (z.abs() - h).max(side * 2.0 * h / (4.0 * h * h + (upper - lower) * (upper - lower)).sqrt())
        };
        let hull = |hull: &rockfall_shape::Hull| {
            let over = |(n, &o): (&Vec3, &f32)| n.as_dvec3().dot(p) - f64::from(o);
            hull.normals.iter().zip(&hull.offsets).map(over).fold(f64::NEG_INFINITY, f64::max)
        };
        match self.shape {
            Shape::Sphere { radius } => p.length() - f64::from(*radius),
            Shape::Box { half } => beyond(half.as_dvec3()),
            Shape::RoundedBox { half, radius } => {
                let outside = (p.abs() - half.as_dvec3()).max(DVec3::ZERO).length();
                beyond(half.as_dvec3()).max(outside) - f64::from(*radius)
            }
            Shape::Capsule { half_length, radius } => {
                let h = f64::from(*half_length);
                p.distance(DVec3::Z * z.clamp(-h, h)) - f64::from(*radius)
            }
            Shape::Cylinder { half_length, radius } => frustum(*half_length, *radius, *radius),
            Shape::Cone { half_length, lower, upper } => frustum(*half_length, *lower, *upper),
            Shape::Ellipsoid { half } => {
                let half = half.as_dvec3();
                let level = (p / half).length();
                (level - 1.0) * level / (p / (half * half)).length().max(1e-9)
            }
            Shape::Hull(h) => hull(h),
            Shape::RoundedHull { hull: h, radius } => hull(h) - f64::from(*radius),
            Shape::HalfSpace { normal, offset } => normal.as_dvec3().dot(p) - f64::from(*offset),
            Shape::Mesh(_) | Shape::Field(_) | Shape::HeightField(_) | Shape::Compound(_) => f64::INFINITY,
        }
    }

    /// What its discs may hide.
    fn level(&self) -> f64 {
        LEVEL
            * f64::from(match self.shape {
                Shape::Cylinder { radius, .. } => *radius,
                Shape::Cone { lower, upper, .. } => lower.max(*upper),
                _ => 0.0,
            })
    }
}

fn gap(a: &Body, b: &Body, n: DVec3) -> f64 {
    -b.reach(-n) - a.reach(n)
}

/// The largest gap of many directions, improved step by step from the best few: minus the least overlap.
fn least_overlap(a: &Body, b: &Body) -> f64 {
    let mut found: Vec<(f64, DVec3)> = (0..400)
        .map(|i| {
            let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 400.0;
            let (s, c) = rockfall_math::trig::sin_cos(2.399_963 * i as f32);
            let r = (1.0 - z * z).sqrt();
            let n = DVec3::new(r * f64::from(c), r * f64::from(s), z).normalize();
            (gap(a, b, n), n)
        })
        .collect();
    found.sort_by(|x, y| y.0.total_cmp(&x.0));
    let climb = |&(start, n): &(f64, DVec3)| {
        let (mut best, mut n, mut step) = (start, n, 0.1);
        while step > 1e-7 {
            let u = n.any_orthonormal_vector();
            let v = n.cross(u);
            let tries = [u, v, -u, -v, u + v, u - v, v - u, -u - v];
            let better = tries.map(|d| (n + step * d).normalize()).map(|m| (gap(a, b, m), m));
            let (g, m) = better.into_iter().fold((best, n), |x, y| if y.0 > x.0 { y } else { x });
            if g > best { (best, n) = (g, m) } else { step *= 0.5 }
        }
        best
    };
    found[..6].iter().map(climb).fold(f64::NEG_INFINITY, f64::max)
}

/// Gaps along a direction from −20 % to +50 % of the size, one time in four within ±1 %.
fn pose(random: &mut Random, a: &Shape, b: &Shape) -> Isometry {
    let mut at = Isometry { rotation: random.rotation(), translation: Vec3::ZERO };
    let share =
        if random.word().is_multiple_of(4) { random.between(-0.01, 0.01) } else { random.between(-0.2, 0.5) };
    let along = match (a, random.word() % 3) {
        (Shape::HalfSpace { normal, .. }, _) => *normal,
        (_, 0) => [Vec3::X, Vec3::NEG_Y, Vec3::Z][(random.word() % 3) as usize],
        _ => random.direction(),
    };
    let wanted = f64::from(share * (size(a) + size(b)));
    let apart = gap(&Body::new(a, &Isometry::IDENTITY), &Body::new(b, &at), along.as_dvec3());
    let aside = random.between(0.0, 0.5) * random.direction().cross(along);
    at.translation = (wanted - apart) as f32 * along + aside;
    at
}

fn check(a: &Shape, b: &Shape, b_in_a: &Isometry, sweep: bool) -> Distance {
    let scale = f64::from(size(a) + size(b) + 0.5 * b_in_a.translation.length());
    let exact = EXACT * scale;
    let what = || format!("{a:?}\n{b:?}\n{b_in_a:?}");
    let (body_a, body_b) = (Body::new(a, &Isometry::IDENTITY), Body::new(b, b_in_a));
    let d = distance(a, b, b_in_a).unwrap();
    let (n, truth) = (d.normal.as_dvec3(), f64::from(d.distance));
    assert!((n.length() - 1.0).abs() < 1e-6, "{d:?}\n{}", what());
    let proved = gap(&body_a, &body_b, n);
    // A normal in single precision is off by 3e-8, and with it the gap.
    assert!((proved - truth).abs() < exact, "{d:?} along its normal {proved}\n{}", what());
    assert!((d.on_a + d.distance * d.normal - d.on_b).length() < 3e-6 * scale as f32, "{d:?}\n{}", what());
    let (on_a, on_b) = (body_a.out(d.on_a.as_dvec3()), body_b.out(d.on_b.as_dvec3()));
    // Apart, the two points are the proof from the other side.
    let near = if truth > 0.0 { 3.0 * exact } else { 3.0 * exact + 5e-3 * truth.abs() };
    assert!(on_a < near && on_b < near, "{on_a} {on_b} {d:?}\n{}", what());
    let half_space = matches!(a, Shape::HalfSpace { .. });
    if truth < 0.0 && sweep && !half_space {
        let known = least_overlap(&body_a, &body_b);
        assert!(truth > known * 1.01 - exact, "overlap {truth}, known {known}: {d:?}\n{}", what());
    }

    let margin = 0.05 * scale as f32;
    let back = b_in_a.inverse();
    let swapped = distance(b, a, &back).unwrap();
    // The other order may find another way out that is as short, to half a percent.
    let same = 2e-6 * scale as f32 + 5e-3 * d.distance.min(0.0).abs();
    assert!((swapped.distance - d.distance).abs() < same, "{d:?} {swapped:?}\n{}", what());
    for (a, b, pose) in [(a, b, b_in_a), (b, a, &back)] {
        let mut out = Vec::new();
        let apart = collide(a, b, pose, margin, &mut Cache::default(), &mut out);
        assert!(f64::from(apart) <= truth.max(0.0) + exact, "{apart} apart, of {truth}\n{}", what());
        let Some(m) = out.first() else {
            assert!(truth > f64::from(margin) - exact, "no manifold at {truth}\n{}", what());
            // All of these pairs know their distance, at least so that they need not be asked for a while.
            assert!(f64::from(apart) > f64::from(margin) - exact, "{apart} apart, of {truth}\n{}", what());
            continue;
        };
        assert!(truth < f64::from(margin) + exact, "{m:?}\n{}", what());
        let bodies = (Body::new(a, &Isometry::IDENTITY), Body::new(b, pose));
        check_manifold(m, &bodies, truth, margin, scale, &what);
    }
    d
}

fn check_manifold(
    m: &Manifold,
    (a, b): &(Body, Body),
    truth: f64,
    margin: f32,
    scale: f64,
    what: &dyn Fn() -> String,
) {
    let exact = EXACT * scale;
    let n = m.normal.as_dvec3();
    assert!((1..=4).contains(&m.count) && (n.length() - 1.0).abs() < 1e-6, "{m:?}\n{}", what());
    // Polyhedra that overlap may prefer a face, as in the other tests.
    let deepest = f64::from(m.deepest());
    let preferred = if truth > 0.0 { 0.0 } else { 0.01 * truth.abs() + 2e-3 * scale };
    let allowed = exact + preferred + a.level() + b.level();
    assert!((deepest - truth).abs() < allowed, "deepest {deepest} of {truth}: {m:?}\n{}", what());
    assert!(gap(a, b, n) > truth - exact.max(2e-3 * scale) - preferred, "{truth}: {m:?}\n{}", what());
    for (k, p) in m.points().iter().enumerate() {
        assert!(p.distance <= margin * 1.000_01 && p.position.is_finite(), "{m:?}\n{}", what());
        // The two surfaces are half the distance off to both sides, over a patch whose sides stand back a little.
        let half = 0.5 * f64::from(p.distance);
        let (on_a, on_b) = (p.position.as_dvec3() - half * n, p.position.as_dvec3() + half * n);
        let slack = 5e-3 * scale + preferred;
        assert!(
            a.out(on_a) < slack && b.out(on_b) < slack,
            "point {k}, {} {}: {m:?}\n{}",
            a.out(on_a),
            b.out(on_b),
            what()
        );
        for q in &m.points()[..k] {
            assert_ne!(p.feature, q.feature, "{m:?}\n{}", what());
        }
    }
}

const OLD: [usize; 5] = [0, 1, 2, 3, 4];
const NEW: [usize; 7] = [7, 8, 9, 10, 11, 12, 13];

fn class_against(first: usize, seconds: &[usize], poses: usize) {
    for &second in seconds {
        let mut random = Random((first * 16 + second) as u64);
        let (mut asked, mut apart_of_opinion) = (0, 0);
        for k in 0..poses {
            let (a, b) = (random.shape(second), random.shape(first));
            let at = pose(&mut random, &a, &b);
            let d = check(&a, &b, &at, k % 8 == 0);
            if k % 4 == 0
                && let Some(opinion) = second_opinion(&a, &b, &at)
            {
                asked += 1;
                let scale = size(&a) + size(&b) + 0.5 * at.translation.length();
                let off = opinion - d.distance;
                // Its overlaps are those of some direction: never less than the least.
                let allowed = 2e-3 * scale + 0.01 * d.distance.min(0.0).abs();
                let differs = if d.distance > 0.0 { off.abs() > allowed } else { off > allowed };
                apart_of_opinion += u32::from(differs);
            }
        }
        println!("{first} / {second}: parry3d differs in {apart_of_opinion} of {asked}");
        assert!(25 * apart_of_opinion <= asked, "{first} {second}: {apart_of_opinion} of {asked}");
    }
}

macro_rules! classes {
    ($($name:ident: $class:literal;)*) => {
        $(#[test] fn $name() {
            class_against($class, &OLD, POSES);
            class_against($class, &NEW, POSES);
        })*
    };
}

classes! {
    cylinders: 7;
    cones: 8;
    ellipsoids: 9;
    rounded_boxes: 10;
    rounded_hulls: 11;
    discs_and_rods: 12;
    flat_and_long_ellipsoids: 13;
}

/// The whole protocol, a class at a time: each against all of the others.
macro_rules! all_poses {
    ($($name:ident: $class:literal;)*) => {
        $(#[test]
        #[ignore = "a hundred thousand poses of each pair take a quarter of an hour"]
        fn $name() {
            class_against($class, &OLD, 100_000);
            class_against($class, &NEW, 100_000);
        })*
    };
}

all_poses! {
    all_poses_of_cylinders: 7;
    all_poses_of_cones: 8;
    all_poses_of_ellipsoids: 9;
    all_poses_of_rounded_boxes: 10;
    all_poses_of_rounded_hulls: 11;
    all_poses_of_discs_and_rods: 12;
    all_poses_of_flat_and_long_ellipsoids: 13;
}
