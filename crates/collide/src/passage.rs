//! Where a body has to be stopped so that it does not pass through another.
//!
//! Contacts see ahead, and push out what has sunk in. What they can't make good is a body that comes out on the other side.
//! So a pair of solids is stopped only where one of them would reach the *core* of the other, which is that body
//! less a layer of a quarter of its inner radius; the same rule as for the triangles of a surface (see [`time_of_impact`]). Stopped wherever they
//! touch, bodies of a stream would be held back and run into from behind.
//!
//! Both cores count: a bullet may not reach the core of a plate, nor a plate, however thin its own layer is, that of the
//! bullet. What comes from afar is stopped where it touches. Of what was near from the start each may sink in by one layer more
//! than it has, so that nothing is held where it lies.

use crate::time_of_impact::{Core, Cores, Course, LAYERS, NEAR, Other, SUNK};
use crate::{Motion, Sweep, Toi, compound, field, time_of_impact};
use rockfall_shape::Shape;

/// When `a`, which is convex, a compound, a field or a closed mesh, has to be stopped so that it does not pass through `b`, which may be of any kind: at the
/// `target_distance` in metres from what it would go through, or on its way into it; none where it does not.
///
/// For meshes, height fields, and fields that anything but a field comes to, this is [`time_of_impact`]. Of compounds the first part counts. Two fields are stopped as they are, to their errors and the spacing of their samples; elsewhere it is the ball inside of a
/// field or a closed mesh A that is stopped.
///
/// None as well where `a` is none of these, a number is not finite, or one body is in the middle of the other already.
///
/// # Examples
/// ```
/// use rockfall_collide::{Motion, Sweep, passage};
/// use rockfall_math::{Isometry, Vec3};
/// use rockfall_shape::Shape;
///
/// let (bullet, plate) = (Shape::Sphere { radius: 0.005 }, Shape::Box { half: Vec3::new(0.0005, 1.0, 1.0) });
/// let start = Isometry { translation: Vec3::new(-1.0, 0.0, 0.0), ..Isometry::IDENTITY };
/// let shot = |way: f32| Sweep {
///     a: Motion { translation: Vec3::X * way, ..Motion::at_rest(start) },
///     b: Motion::at_rest(Isometry::IDENTITY),
/// };
/// let stop = passage(&bullet, &plate, &shot(2.0), 1e-5).expect("it would fly through");
/// assert!((stop.time - 0.49725).abs() < 1e-4);
/// // Contacts take care of what only touches.
/// assert_eq!(passage(&bullet, &plate, &shot(0.9946), 1e-5), None);
/// ```
pub fn passage(a: &Shape, b: &Shape, sweep: &Sweep, target_distance: f32) -> Option<Toi> {
    if compound::takes_part(a, b) {
        return compound::first_impact(a, b, sweep, target_distance, passage);
    }
    if matches!(a, Shape::Field(_)) && !matches!(b, Shape::Mesh(_) | Shape::HeightField(_)) {
        return field::passage(a, b, sweep, target_distance);
    }
    if !b.is_convex() {
        return time_of_impact(a, b, sweep, target_distance);
    }
    let thin = a.inner_radius().min(b.inner_radius());
    let radii = [a.radius_about(sweep.a.center), b.radius_about(sweep.b.center)];
    if !sweep.is_finite() || target_distance.is_nan() || gone(radii, sweep) < SUNK * thin {
        return None;
    }
    if a.is_convex() && stay_apart(radii, sweep, target_distance) {
        return None;
    }
    let cores = Cores::new(a, &sweep.a)?;
    let course = Course { sweep, inner: 0.0, target: target_distance.max(0.0) };
    if let Shape::HalfSpace { normal, offset } = b {
        // There is no other side to come out on, and no core to reach.
        let ground = || Other::HalfSpace { normal: *normal, offset: *offset };
        return first(&course, thin, [&|layers| Some((cores.less(layers, &sweep.a)?, ground()))]);
    }
    let others = Cores::new(b, &sweep.b)?;
    let of_a = |layers: usize| Some((cores.less(layers, &sweep.a)?, others.whole.as_other()));
    let of_b = |layers: usize| Some((&cores.whole, others.less(layers, &sweep.b)?.as_other()));
    first(&course, thin, [&of_a, &of_b])
}

/// Two bodies, one of them with so many layers less.
type Less<'a> = dyn Fn(usize) -> Option<(&'a Core, Other<'a>)> + 'a;

/// The first time at which two bodies have to be stopped, of which the thinner has the inner radius `thin`; each of `bodies` takes
/// its layers off one of them.
fn first<'a, const N: usize>(course: &Course, thin: f32, bodies: [&Less<'a>; N]) -> Option<Toi> {
    let (a, b) = bodies[0](0)?;
    if course.gap(a, &b, 0.0).is_some_and(|gap| gap.distance > NEAR * thin) {
        let touch = course.advance(a, &b, 0.0, 1.0)?;
        let reaches =
            |less: &&Less<'a>| less(1).and_then(|(a, b)| course.advance(a, &b, touch.time, 1.0)).is_some();
        return bodies.iter().any(reaches).then_some(touch);
    }
    // Near each other from the start: when one sinks into the other by one layer more than it has.
    let into = |less: &&Less<'a>| {
        let apart = |layers: &usize| less(*layers).and_then(|(a, b)| course.gap(a, &b, 0.0)).is_some();
        let (a, b) = less((0..=LAYERS).find(apart)? + 1)?;
        course.advance(a, &b, 0.0, 1.0)
    };
    bodies.iter().filter_map(into).min_by(|p, q| p.time.total_cmp(&q.time))
}

/// How far a point of one body goes relative to the other, at most, metres; `radii` are those of the balls around both, about what they turn around.
pub(crate) fn gone(radii: [f32; 2], sweep: &Sweep) -> f32 {
    let turned = |radius: f32, motion: &Motion| {
        let angle = motion.rotation.length();
        if angle > 0.0 { angle * radius } else { 0.0 }
    };
    (sweep.a.translation - sweep.b.translation).length()
        + turned(radii[0], &sweep.a)
        + turned(radii[1], &sweep.b)
}

/// Whether the balls around two bodies never meet, nor come as near as the target distance: most pairs that are near each other pass by. Bodies turn about the middles of
/// these balls, which so go straight.
pub(crate) fn stay_apart(radii: [f32; 2], sweep: &Sweep, target_distance: f32) -> bool {
    let [middle_a, middle_b] =
        [&sweep.a, &sweep.b].map(|motion| motion.start.point(motion.center).as_dvec3());
    let apart = middle_a - middle_b;
    let way = (sweep.a.translation - sweep.b.translation).as_dvec3();
    // Of the time at which they would be nearest.
    let share = (-apart.dot(way) / way.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    let least = (apart + way * share).length();
    let sum = radii[0] + radii[1] + target_distance.max(0.0);
    // Places are rounded to a share of how far they are from the origin of the frame.
    let rounding = 1e-6 * (middle_a.length() + middle_b.length() + f64::from(sum));
    least > f64::from(sum) + rounding
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distance;
    use rockfall_math::{Isometry, Mat3, Vec3, rotation};

    /// Boxes and capsules that go and turn anyhow: those that are said to stay apart are, at every hundredth of their way; and so are most that do.
    #[test]
    fn what_stays_apart_is_never_near() {
        let mut word = 1_u64;
        let mut random = || {
            word = rockfall_math::hash::mix(word.wrapping_add(0x9e37_79b9_7f4a_7c15));
            (word >> 40) as f32 / (1_u64 << 23) as f32 - 1.0
        };
        let shapes = [
            Shape::Box { half: Vec3::new(0.3, 0.2, 0.1) },
            Shape::Capsule { half_length: 0.4, radius: 0.05 },
        ];
        let mut motion = || {
            let mut vector = |size: f32| Vec3::new(random(), random(), random()) * size;
            let turn = rotation::from_rotation_vector(vector(3.0));
            let start = Isometry { rotation: Mat3::from_quat(turn), translation: vector(1.0) };
            Motion { start, center: vector(0.1), translation: vector(1.5), rotation: vector(2.0) }
        };
        let (mut said, mut were) = (0, 0);
        for _ in 0..400 {
            let sweep = Sweep { a: motion(), b: motion() };
            let [a, b] = [&shapes[0], &shapes[1]];
            let gap = |k: u8| {
                let time = f32::from(k) / 100.0;
                let in_a = sweep.a.at(time).inverse().then_after(&sweep.b.at(time));
                distance(a, b, &in_a).expect("two solids").distance
            };
            let apart = (0..=100).all(|k| gap(k) > 0.01);
            let radii = [a.radius_about(sweep.a.center), b.radius_about(sweep.b.center)];
            let claims = stay_apart(radii, &sweep, 0.01);
            assert!(apart || !claims, "{sweep:?}");
            (said, were) = (said + u32::from(claims), were + u32::from(apart));
        }
        assert!(said > 100 && 2 * said > were, "{said} of {were}");
    }
}
