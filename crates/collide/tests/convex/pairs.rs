//! Every ordered pair of convex shapes over random poses: the signed distance and the manifold against brute force
//! in double precision, and the brute force against parry3d.
//!
//! parry3d works in single precision with tolerances of its own: it errs by up to a thousandth of the size where our
//! brute force is exact, so brute force decides and parry3d checks that both mean the same thing.

use crate::brute_force::{Solid, gap, judge, manifold, size};
use crate::common::Random;
use crate::opinion::second_opinion;
use rockfall_collide::{Cache, Manifold, collide, distance};
use rockfall_math::{DVec3, Isometry, Vec3};
use rockfall_shape::Shape;

const NAMES: [&str; 7] = ["sphere", "box", "capsule", "hull", "half-space", "plate", "large hull"];

/// Poses for each unordered pair of classes; every pose is asked in both orders.
const POSES: usize = 100_000;

/// Distances agree to this share of the size of the pair: half extents of both and half of the way between them.
const EXACT: f32 = 1e-6;

fn poses(first: usize, second: usize, count: usize) -> impl Iterator<Item = (Shape, Shape, Isometry)> {
    let mut random = Random((first * 8 + second) as u64);
    let (mut a, mut b) = (random.shape(first), random.shape(second));
    (0..count).map(move |k| {
        if k % 16 == 0 {
            (a, b) = (random.shape(first), random.shape(second));
        }
        (a.clone(), b.clone(), pose(&mut random, &a, &b))
    })
}

/// Gaps along a direction from −20 % to +50 % of the size, one time in four within ±1 %: the distance is that gap or,
/// where another direction separates more, a larger one.
fn pose(random: &mut Random, a: &Shape, b: &Shape) -> Isometry {
    let rotation = random.rotation();
    let mut at = Isometry { rotation, translation: Vec3::ZERO };
    let share =
        if random.word().is_multiple_of(4) { random.between(-0.01, 0.01) } else { random.between(-0.2, 0.5) };
    let along = match random.word() % 3 {
        0 => [Vec3::X, Vec3::NEG_Y, Vec3::Z][(random.word() % 3) as usize],
        _ => random.direction(),
    };
    let wanted = f64::from(share * (size(a) + size(b)));
    if let Shape::HalfSpace { normal, offset } = a {
        let b = Solid::new(b, &at).unwrap();
        let n = normal.as_dvec3();
        let lift = (wanted + f64::from(*offset) + b.furthest(-n)) as f32;
        let aside = random.direction().cross(*normal);
        at.translation = lift * *normal + 3.0 * aside;
    } else {
        let (a, b) = (Solid::new(a, &Isometry::IDENTITY).unwrap(), Solid::new(b, &at).unwrap());
        let shift = (wanted - gap(&a, &b, along.as_dvec3())) as f32;
        at.translation = shift * along + random.between(0.0, 0.5) * random.direction().cross(along);
    }
    at
}

/// The signed distance by brute force, and the height of B along a unit direction over A.
struct Judge {
    a: Option<Solid>,
    b: Solid,
    half_space: Option<(DVec3, f64)>,
}

impl Judge {
    fn new(a: &Shape, b: &Shape, b_in_a: &Isometry) -> Judge {
        let half_space = match a {
            Shape::HalfSpace { normal, offset } => Some((normal.as_dvec3(), f64::from(*offset))),
            _ => None,
        };
        Judge { a: Solid::new(a, &Isometry::IDENTITY), b: Solid::new(b, b_in_a).unwrap(), half_space }
    }

    fn distance(&self) -> f64 {
        match (&self.a, self.half_space) {
            (Some(a), _) => judge(a, &self.b),
            (None, Some((n, offset))) => -self.b.furthest(-n) - offset,
            _ => unreachable!(),
        }
    }

    fn gap(&self, n: DVec3) -> f64 {
        match (&self.a, self.half_space) {
            (Some(a), _) => gap(a, &self.b, n),
            (None, Some((normal, offset))) => {
                assert!(normal.distance(n) < 1e-6);
                -self.b.furthest(-n) - offset
            }
            _ => unreachable!(),
        }
    }

    /// How far a point is out of A and of B.
    fn heights(&self, p: DVec3) -> (f64, f64) {
        let of_a = match (&self.a, self.half_space) {
            (Some(a), _) => a.height(p),
            (None, Some((n, offset))) => n.dot(p) - offset,
            _ => unreachable!(),
        };
        (of_a, self.b.height(p))
    }
}

fn check(a: &Shape, b: &Shape, b_in_a: &Isometry, judge: &Judge, truth: f64, scale: f32) {
    let what = || format!("{a:?}\n{b:?}\n{b_in_a:?}\nbrute force {truth}");
    let exact = f64::from(EXACT * scale);

    let d = distance(a, b, b_in_a).unwrap();
    assert!((f64::from(d.distance) - truth).abs() < exact, "{d:?}\n{}", what());
    assert!((d.normal.length() - 1.0).abs() < 1e-5, "{d:?}\n{}", what());
    // The normal proves the distance: along it the shapes are that far apart.
    assert!(judge.gap(d.normal.as_dvec3()) > truth - 3.0 * exact, "{d:?}\n{}", what());
    assert!((d.on_a + d.distance * d.normal - d.on_b).length() < 3.0 * EXACT * scale, "{d:?}\n{}", what());
    let ((on_a, _), (_, on_b)) = (judge.heights(d.on_a.as_dvec3()), judge.heights(d.on_b.as_dvec3()));
    assert!(on_a.abs() < 3.0 * exact && on_b.abs() < 3.0 * exact, "{on_a} {on_b} {d:?}\n{}", what());

    let margin = 0.05 * scale;
    let Some(m) = manifold(a, b, b_in_a, margin) else {
        assert!(truth > f64::from(margin) - exact, "no manifold\n{}", what());
        return;
    };
    assert!(truth < f64::from(margin) + exact, "{m:?}\n{}", what());
    check_manifold(&m, judge, truth, margin, scale, &what);
}

fn check_manifold(
    m: &Manifold,
    judge: &Judge,
    truth: f64,
    margin: f32,
    scale: f32,
    what: &dyn Fn() -> String,
) {
    let exact = f64::from(EXACT * scale);
    assert!((1..=4).contains(&m.count), "{m:?}\n{}", what());
    assert!((m.normal.length() - 1.0).abs() < 1e-5, "{m:?}\n{}", what());
    let deepest = f64::from(m.deepest());
    // While the shapes overlap the manifold may prefer a face: 1 % of the depth and 0.2 % of the size.
    let allowed = if truth > 0.0 { exact } else { exact + 0.01 * truth.abs() + 2e-3 * f64::from(scale) };
    assert!((deepest - truth).abs() < allowed, "deepest {deepest}: {m:?}\n{}", what());
    // Boxes that are apart may prefer a face as well, though with the exact distance.
    let leaning = allowed.max(2e-3 * f64::from(scale));
    assert!(judge.gap(m.normal.as_dvec3()) > truth - leaning, "{m:?}\n{}", what());
    // Half-way between the surfaces, over a face with its sides moved out a little.
    let slack = 3e-3 * f64::from(scale);
    for (k, p) in m.points().iter().enumerate() {
        assert!(p.distance <= margin && p.position.is_finite(), "{m:?}\n{}", what());
        let (of_a, of_b) = judge.heights(p.position.as_dvec3());
        let half = 0.5 * f64::from(p.distance.abs());
        assert!(of_a < half + slack && of_b < half + slack, "point {k}, {of_a} {of_b}: {m:?}\n{}", what());
        for q in &m.points()[..k] {
            assert_ne!(p.feature, q.feature, "{m:?}\n{}", what());
        }
    }
}

fn class_against_class(first: usize, second: usize, count: usize) {
    let (mut asked, mut apart_of_opinion, mut ties) = (0, 0, 0);
    for (k, (a, b, b_in_a)) in poses(first, second, count).enumerate() {
        let scale = size(&a) + size(&b) + 0.5 * b_in_a.translation.length();
        let judge = Judge::new(&a, &b, &b_in_a);
        let truth = judge.distance();
        check(&a, &b, &b_in_a, &judge, truth, scale);
        ties += u32::from(!swapped_is_mirrored(&a, &b, &b_in_a, scale));
        if k % 10 == 0
            && let Some(opinion) = second_opinion(&a, &b, &b_in_a)
        {
            asked += 1;
            let off = f64::from(opinion) - truth;
            // Penetrations of parry3d are those of some direction: never less than the least, up to its rounding.
            let allowed = 2e-3 * f64::from(scale) + 0.01 * truth.min(0.0).abs();
            let differs = if truth > 0.0 { off.abs() > allowed } else { off > allowed };
            apart_of_opinion += u32::from(differs);
        }
    }
    println!("{} / {}: parry3d differs in {apart_of_opinion} of {asked}", NAMES[first], NAMES[second]);
    assert!(ties <= count as u32 / 100, "{ties} manifolds differ by the order");
    // The most are nearly parallel capsules: parry3d takes their nearest points to a hundredth only.
    assert!(25 * apart_of_opinion <= asked, "parry3d differs in {apart_of_opinion} of {asked}");
}

/// The same pair in the other order: the same distance. Whether the manifold is the mirrored one as well.
fn swapped_is_mirrored(a: &Shape, b: &Shape, b_in_a: &Isometry, scale: f32) -> bool {
    let back = b_in_a.inverse();
    let (d, e) = (distance(a, b, b_in_a).unwrap(), distance(b, a, &back).unwrap());
    assert!((d.distance - e.distance).abs() < 2.0 * EXACT * scale, "{a:?}\n{b:?}\n{b_in_a:?}\n{d:?}\n{e:?}");
    let margin = 0.05 * scale;
    if (d.distance - margin).abs() < 2.0 * EXACT * scale {
        return true;
    }
    let (m, n) = (manifold(a, b, b_in_a, margin), manifold(b, a, &back, margin));
    assert_eq!(m.is_some(), n.is_some(), "{a:?}\n{b:?}\n{b_in_a:?}");
    let same_class = std::mem::discriminant(a) == std::mem::discriminant(b);
    if let (Some(m), Some(n)) = (m, n)
        && !same_class
    {
        // One of the two orders is the other one, seen from the other side: up to ties that rounding decides.
        assert!((m.deepest() - n.deepest()).abs() < 1e-3 * scale, "{a:?}\n{b:?}\n{b_in_a:?}\n{m:?}\n{n:?}");
        if m.count != n.count || (m.normal + b_in_a.vector(n.normal)).length() > 1e-3 {
            return false;
        }
        return m.points().iter().zip(n.points()).all(|(p, q)| {
            (p.distance - q.distance).abs() < 1e-4 * scale
                && (p.position - b_in_a.point(q.position)).length() < 1e-3 * scale
        });
    }
    true
}

macro_rules! pairs {
    ($($name:ident: $first:literal, $second:literal, $count:expr;)*) => {
        $(#[test] fn $name() { class_against_class($first, $second, $count); })*
    };
}

pairs! {
    sphere_sphere: 0, 0, POSES;
    box_box: 1, 1, POSES;
    capsule_capsule: 2, 2, POSES;
    hull_hull: 3, 3, POSES;
    sphere_box: 0, 1, POSES;
    sphere_capsule: 0, 2, POSES;
    sphere_hull: 0, 3, POSES;
    box_capsule: 1, 2, POSES;
    box_hull: 1, 3, POSES;
    capsule_hull: 2, 3, POSES;
    half_space_sphere: 4, 0, POSES;
    half_space_box: 4, 1, POSES;
    half_space_capsule: 4, 2, POSES;
    half_space_hull: 4, 3, POSES;
    plate_plate: 5, 5, 20_000;
    plate_box: 5, 1, 20_000;
    plate_hull: 5, 3, 20_000;
    plate_capsule: 5, 2, 20_000;
    large_hulls: 6, 6, 2_000;
}

/// MuJoCo's box fuzz: its six pairs of half edges, down to 1:60, in random poses, against brute force.
#[test]
fn cubes_slabs_and_needles_agree_with_brute_force() {
    let mut random = Random(31);
    let boxes = |half: [f32; 3]| Shape::Box { half: Vec3::from(half) };
    for (a, b) in [
        ([0.05, 0.05, 0.05], [0.05, 0.05, 0.05]),
        ([0.05, 0.05, 0.05], [0.013, 0.013, 0.013]),
        ([0.08, 0.08, 0.004], [0.06, 0.06, 0.006]),
        ([0.002, 0.002, 0.09], [0.04, 0.04, 0.04]),
        ([0.07, 0.05, 0.003], [0.0015, 0.0015, 0.06]),
        ([0.018, 0.038, 0.047], [0.026, 0.0014, 0.008]),
    ] {
        let [a, b] = [a, b].map(boxes);
        let reach = |shape: &Shape| shape.bounds().max.max_element();
        for _ in 0..3000 {
            let b_in_a = Isometry {
                rotation: random.rotation(),
                translation: random.point(1.15 * (reach(&a) + reach(&b))),
            };
            let scale = size(&a) + size(&b) + 0.5 * b_in_a.translation.length();
            let judge = Judge::new(&a, &b, &b_in_a);
            check(&a, &b, &b_in_a, &judge, judge.distance(), scale);
        }
    }
}

/// MuJoCo's known distance of two ellipsoids along the axes, to the digits that it gives.
#[test]
fn two_ellipsoids_are_as_far_apart_as_mujoco_says() {
    let ellipsoid = |x, y, z| Shape::Ellipsoid { half: Vec3::new(x, y, z) };
    let b_in_a = Isometry { translation: Vec3::new(0.0, 0.5, 1.0), ..Isometry::IDENTITY };
    let found = distance(&ellipsoid(0.15, 0.3, 0.2), &ellipsoid(0.1, 0.1, 0.15), &b_in_a).unwrap();
    assert!((found.distance - 0.7542).abs() < 1e-4, "{found:?}");
}

#[test]
fn two_half_spaces_have_nothing_to_say() {
    let ground = Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 };
    assert!(manifold(&ground, &ground, &Isometry::IDENTITY, 1.0).is_none());
    assert!(distance(&ground, &ground, &Isometry::IDENTITY).is_none());
}

#[test]
fn a_place_that_is_not_finite_has_no_contact() {
    let mut random = Random(1);
    for first in 0..5 {
        for second in 0..5 {
            let (a, b) = (random.shape(first), random.shape(second));
            for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
                let pose = Isometry { translation: Vec3::new(0.0, bad, 0.0), ..Isometry::IDENTITY };
                assert!(manifold(&a, &b, &pose, 1.0).is_none());
                assert!(distance(&a, &b, &pose).is_none());
            }
        }
    }
}

/// Calls `check` with what a cache that has seen the pair before and a fresh one find, along a walk that comes and goes around contact.
fn walk(
    random: &mut Random,
    (a, b): (&Shape, &Shape),
    step: f32,
    mut check: impl FnMut(Option<Manifold>, Option<Manifold>),
) {
    let (mut at, mut cache) =
        (Isometry { rotation: random.rotation(), translation: Vec3::ZERO }, Cache::default());
    let reach = size(a) + size(b);
    let mut out = Vec::new();
    for _ in 0..200 {
        at.translation += step * reach * random.direction();
        at.translation *= (reach / at.translation.length()).min(1.0);
        out.clear();
        collide(a, b, &at, 0.05, &mut cache, &mut out);
        check(out.first().copied(), manifold(a, b, &at, 0.05));
    }
}

/// Manifolds are the same, but for which points are taken of an overlap that is below `deep`: a deepest one always.
fn same_but_for_deep_points(used: Option<Manifold>, fresh: Option<Manifold>, deep: f32) {
    let (Some(one), Some(two)) = (used, fresh) else { return assert_eq!(used, fresh) };
    if two.deepest() >= deep {
        return assert_eq!(one, two);
    }
    assert_eq!(one.normal, two.normal);
    let span = [one, two]
        .iter()
        .flat_map(|m| m.points())
        .fold(0.0_f32, |span, p| span.max(p.position.distance(two.points[0].position)));
    let hidden = 0.01 * -two.deepest() + 1e-3 * span;
    assert!((one.deepest() - two.deepest()).abs() <= hidden, "{one:?} {two:?}");
}

#[test]
fn a_used_cache_changes_no_bit_but_of_two_boxes_and_deep_overlaps() {
    let mut random = Random(7);
    for first in 0..5 {
        for second in 0..5 {
            for _ in 0..20 {
                let (a, b) = (random.shape(first), random.shape(second));
                let boxes = matches!((&a, &b), (Shape::Box { .. }, Shape::Box { .. }));
                let planes = matches!((&a, &b), (Shape::HalfSpace { .. }, Shape::HalfSpace { .. }));
                if !boxes && !planes {
                    let angular = |shape: &Shape| matches!(shape, Shape::Box { .. } | Shape::Hull(_));
                    let deep = match angular(&a) && angular(&b) {
                        true => -0.05 * a.inner_radius().min(b.inner_radius()),
                        false => f32::NEG_INFINITY,
                    };
                    walk(&mut random, (&a, &b), 0.1, |used, fresh| {
                        same_but_for_deep_points(used, fresh, deep)
                    });
                }
            }
        }
    }
}

/// Two boxes keep their face and corners where these are as good: 0.2 % of the inner radius and 0.5 % of the overlap, as the choice between
/// faces and edges is anyway, and a fourth of a thousandth of the span of the corners.
#[test]
fn of_two_boxes_a_used_cache_finds_what_is_as_good() {
    let mut random = Random(8);
    let mut kept = 0;
    for _ in 0..500 {
        let (a, b) = (random.shape(1), random.shape(1));
        let half = |shape: &Shape| match shape {
            Shape::Box { half } => half.min_element(),
            _ => unreachable!("boxes only"),
        };
        let inner = half(&a).min(half(&b));
        let span = 2.0 * (size(&a) + size(&b));
        walk(&mut random, (&a, &b), 1e-3, |used, fresh| {
            let (Some(used), Some(fresh)) = (used, fresh) else {
                assert_eq!(used, fresh);
                return;
            };
            let tie = 2e-3 * inner + 5e-3 * fresh.deepest().abs().max(used.deepest().abs()) + 2.5e-4 * span;
            assert!((used.deepest() - fresh.deepest()).abs() <= 2.0 * tie, "{used:?} {fresh:?}");
            kept += usize::from(used != fresh);
        });
    }
    assert!(kept > 100, "{kept}");
}

/// What the caller relies on when it does not ask again for a while.
#[test]
fn what_is_apart_says_so_and_never_by_too_much() {
    let margin = 0.05;
    for first in [0, 1, 2, 3, 4, 5] {
        for second in [0, 1, 2, 3, 5] {
            for (a, b, b_in_a) in poses(first, second, 2_000) {
                let exact = EXACT * (size(&a) + size(&b) + 0.5 * b_in_a.translation.length());
                let truth = distance(&a, &b, &b_in_a).unwrap().distance;
                for (a, b, pose) in [(&a, &b, b_in_a), (&b, &a, b_in_a.inverse())] {
                    let (mut cache, mut out) = (Cache::default(), Vec::new());
                    // With an empty cache and with what it learnt.
                    for _ in 0..2 {
                        let apart = collide(a, b, &pose, margin, &mut cache, &mut out);
                        assert!(apart <= truth.max(0.0) + exact, "{apart} of {truth}: {a:?} {b:?} {pose:?}");
                        let known = truth <= margin + exact || apart >= margin - exact;
                        assert!(known, "{apart} of {truth}: {a:?} {b:?} {pose:?}");
                    }
                }
            }
        }
    }
}
