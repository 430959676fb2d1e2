//! When two moving shapes first come near each other: conservative advancement.
//!
//! At any moment the nearest points of two convex sets span a slab that separates them. It closes no faster than
//! the linear motion along its normal plus what rotation adds at the furthest points, so time may advance by the
//! width of the slab over that speed without missing anything, and the steps shrink to nothing at the impact (Mirtich,
//! *Impulse-based Dynamic Simulation of Rigid Body Systems*, 1996, section 2.3). A surface is taken triangle by
//! triangle, along pieces of the path.
//!
//! What slides, rolls or turns on a surface is near its triangles all the time, and its contacts hold it; were it stopped
//! wherever it touches, it would hang in the air with all of its speed. So a triangle stops only what would go *through* it: a
//! body whose core, the body less a quarter of its inner radius, meets the triangle on the way. One that comes from afar is
//! stopped where it touches, one that was near from the start where its core does. A body that is already in the triangle
//! has a smaller core, so that each may sink in by a quarter more and none is held where it lies, but for one whose middle
//! is at the triangle. (Box2D and Box3D stop at the centroid, Jolt where the motion is more than a share of the inner radius.)

use crate::gjk::{self, Placed, Walk, walk};
use crate::poly::BoxPoly;
use crate::surface::Surface;
use crate::{compound, ellipsoid};
use rockfall_math::{Aabb, DVec3, Isometry, Mat3, Vec3, rotation};
use rockfall_shape::{Frustum, Hull, Shape, nearest_on_triangle};
use smallvec::SmallVec;
use std::cell::OnceCell;

/// Where a body is and how it moves over an interval: its centre on a straight line, at constant speed, the rest around
/// the centre at a constant angular velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Place at the start, in a frame that both bodies share and whose origin is near them.
    pub start: Isometry,
    /// What the body turns around, in its own frame: the centre of mass, metres.
    pub center: Vec3,
    /// Way of the centre over the whole interval, metres.
    pub translation: Vec3,
    /// Axis times angle turned over the whole interval, radians, in the shared frame.
    pub rotation: Vec3,
}

/// How two bodies move over the same interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    /// Of the first shape, which is convex, a field or a closed mesh.
    pub a: Motion,
    /// Of the second.
    pub b: Motion,
}

/// The first impact of a [`Sweep`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Toi {
    /// Share of the interval, 0 to 1. Up to here the shapes do not come nearer than the target distance.
    pub time: f32,
    /// Unit vector from A to B at that time, in the shared frame.
    pub normal: Vec3,
    /// Nearest point of A at that time, in the shared frame.
    pub point: Vec3,
    /// Distance at that time, metres; 0 where the shapes overlap from the start.
    pub distance: f32,
}

impl Motion {
    /// A body that stays where it is.
    pub fn at_rest(start: Isometry) -> Self {
        Motion { start, center: Vec3::ZERO, translation: Vec3::ZERO, rotation: Vec3::ZERO }
    }

    /// Place at a time from 0 to 1.
    pub fn at(&self, time: f32) -> Isometry {
        let turn = Mat3::from_quat(rotation::from_rotation_vector(self.rotation * time));
        let rotation = turn * self.start.rotation;
        Isometry { rotation, translation: self.center_at(time) - rotation * self.center }
    }

    /// What is left of the motion after a time from 0 to 1.
    pub fn after(&self, time: f32) -> Motion {
        self.between(time, 1.0)
    }

    /// The motion between two times from 0 to 1, over an interval of its own.
    pub fn between(&self, from: f32, until: f32) -> Motion {
        let share = until - from;
        Motion {
            start: self.at(from),
            center: self.center,
            translation: self.translation * share,
            rotation: self.rotation * share,
        }
    }

    fn center_at(&self, time: f32) -> Vec3 {
        self.start.point(self.center) + self.translation * time
    }
}

impl Sweep {
    pub(crate) fn is_finite(&self) -> bool {
        [self.a, self.b].iter().all(|m| {
            let r = &m.start.rotation;
            let sum = r.x_axis + r.y_axis + r.z_axis + m.start.translation;
            (sum + m.center + m.translation + m.rotation).is_finite()
        })
    }
}

/// The first time at which `a`, a convex shape or a compound of such, comes within `target_distance` metres of `b`; none if it does
/// not. `b` may be of any kind. Of compounds the first impact of a part counts.
///
/// The answer is never late: at no earlier time are the shapes nearer. It may be early, by rounding, and where two
/// shapes slide past each other in a gap that is hardly wider than the target.
///
/// A pair that is nearer than the target at the start is in contact, which is not the business of this function: it gives
/// none, unless A moves towards B by more than its own inner radius, which no contact could make good; then the
/// time is 0. Triangles of a surface stop what comes from their front and would sink into them by more than a quarter
/// of A's inner radius: where it comes near them or, if it was nearer than half of that radius from the start,
/// where it has sunk in by so much.
///
/// Of a field or a closed mesh A it is the ball inside ([`Shape::inner_radius`]) that is stopped. None as well where `a` is neither convex nor one of those, or a number is not finite.
pub fn time_of_impact(a: &Shape, b: &Shape, sweep: &Sweep, target_distance: f32) -> Option<Toi> {
    if !sweep.is_finite() || target_distance.is_nan() {
        return None;
    }
    if compound::takes_part(a, b) {
        return compound::first_impact(a, b, sweep, target_distance, time_of_impact);
    }
    let whole = Core::new(a, &sweep.a, 0.0)?;
    let course = Course { sweep, inner: a.inner_radius(), target: target_distance.max(0.0) };
    match b {
        Shape::HalfSpace { normal, offset } => {
            course.advance(&whole, &Other::HalfSpace { normal: *normal, offset: *offset }, 0.0, 1.0)
        }
        Shape::Mesh(mesh) => course.surface(&Cores::around(a, whole), &**mesh),
        Shape::Field(field) => course.surface(&Cores::around(a, whole), &**field.mesh()),
        Shape::HeightField(field) => course.surface(&Cores::around(a, whole), &**field),
        _ => course.advance(&whole, &Core::new(b, &sweep.b, 0.0)?.as_other(), 0.0, 1.0),
    }
}

/// Steps of one advance. Each lands on the impact where nothing turns; a turning body takes one to two dozen.
pub(crate) const MAX_STEPS: usize = 128;

/// Share of A's inner radius by which it may sink into a triangle, or further into it, without an impact: contacts push it
/// out again.
pub(crate) const SUNK: f32 = 0.25;

/// Layers from A's surface to its middle: four as thick as that, and what is then left of a long or flat body.
pub(crate) const LAYERS: usize = 5;

/// Distance up to which a triangle counts as near from the start, as a share of A's inner radius. Contacts of what is
/// fast enough to need this function reach as far.
pub(crate) const NEAR: f32 = 0.5;

/// Pieces into which the path is cut to look for triangles.
pub(crate) const MAX_PIECES: usize = 64;

/// A convex set without its skin.
pub(crate) enum Set {
    /// The convex hull of points.
    Points(SmallVec<[Vec3; 8]>),
    /// Around a centre on the z axis.
    Frustum(Frustum, f32),
    /// Half axes, around the origin.
    Ellipsoid(Vec3),
}

impl Set {
    /// The points whose distances from anywhere are at least those of the set's points: its corners, or those of a box around it.
    pub(crate) fn corners(&self) -> SmallVec<[Vec3; 8]> {
        let around = |half: Vec3, middle: Vec3| {
            BoxPoly::new(half).poly().vertices.iter().map(|&v| middle + v).collect()
        };
        match self {
            Set::Points(points) => points.clone(),
            Set::Frustum(f, middle) => {
                let wide = f.widest();
                around(Vec3::new(wide, wide, f.half_length), Vec3::Z * *middle)
            }
            Set::Ellipsoid(half) => around(*half, Vec3::ZERO),
        }
    }

    /// The lowest point, seen along a direction.
    pub(crate) fn lowest(&self, up: Vec3) -> Option<Vec3> {
        match self {
            Set::Points(points) => points.iter().copied().min_by(|p, q| up.dot(*p).total_cmp(&up.dot(*q))),
            _ => Some(gjk::Core::support(self, -up.as_dvec3()).as_vec3()),
        }
    }

    /// From where to where the set reaches along a direction, from the origin.
    fn extent(&self, along: Vec3) -> (f32, f32) {
        match self {
            Set::Points(points) => {
                points.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), p| {
                    let at = along.dot(*p);
                    (low.min(at), high.max(at))
                })
            }
            _ => {
                let end = |way: Vec3| gjk::Core::support(self, way.as_dvec3()).as_vec3();
                (along.dot(end(-along)), along.dot(end(along)))
            }
        }
    }

    fn middle(&self) -> Vec3 {
        match self {
            Set::Points(points) => points.iter().sum::<Vec3>() / points.len() as f32,
            Set::Frustum(_, middle) => Vec3::Z * *middle,
            Set::Ellipsoid(_) => Vec3::ZERO,
        }
    }
}

impl gjk::Core for Set {
    type Vertex = DVec3;

    fn support(&self, direction: DVec3) -> DVec3 {
        match self {
            Set::Points(points) => points[points[..].support(direction)].as_dvec3(),
            Set::Frustum(f, middle) => f.support(direction) + DVec3::Z * f64::from(*middle),
            Set::Ellipsoid(half) => ellipsoid::support(*half, direction),
        }
    }

    fn first(&self) -> DVec3 {
        match self {
            Set::Points(points) => points[0].as_dvec3(),
            _ => self.support(DVec3::Z),
        }
    }

    fn point(&self, vertex: DVec3) -> DVec3 {
        vertex
    }

    fn name(_: DVec3) -> usize {
        0
    }
}

/// A convex shape as a set with a skin.
pub(crate) struct Core {
    pub(crate) set: Set,
    pub(crate) radius: f32,
    /// Largest distance of the surface from the centre of rotation, metres.
    pub(crate) reach: f32,
    /// Largest distance of a point from the axis of rotation, metres, or more. A skin looks the same however it turns.
    pub(crate) arm: f32,
    /// A ball around all of it, in the shape's frame: its own where it is one, else around the centre of rotation.
    ball: (Vec3, f32),
}

impl Core {
    /// A shape without its outer layer, which is as thick as `less` times the inner radius or, at the far ends of a hull,
    /// thicker.
    pub(crate) fn new(shape: &Shape, motion: &Motion, less: f32) -> Option<Self> {
        let left = 1.0 - less;
        let cuboid = |half: &Vec3, less: f32| {
            let half = *half - less * half.min_element();
            Set::Points(BoxPoly::new(half).poly().vertices.iter().copied().collect())
        };
        let corners = |hull: &Hull, left: f32| {
            let shrunk = |v: &Vec3| hull.center + left * (*v - hull.center);
            Set::Points(if left < 1.0 {
                hull.vertices.iter().map(shrunk).collect()
            } else {
                hull.vertices.iter().copied().collect()
            })
        };
        let (set, radius) = match shape {
            Shape::Sphere { radius } => (Set::Points([Vec3::ZERO].into_iter().collect()), left * radius),
            Shape::Capsule { half_length, radius } => {
                let end = Vec3::Z * *half_length;
                (Set::Points([-end, end].into_iter().collect()), left * radius)
            }
            Shape::Box { half } => (cuboid(half, less), 0.0),
            Shape::RoundedBox { half, radius } => (cuboid(half, less), left * radius),
            Shape::Hull(hull) => (corners(hull, left), 0.0),
            Shape::RoundedHull { hull, radius } => (corners(hull, left), left * radius),
            // A smaller copy around the centre of the inner ball has the layer around it on all sides.
            Shape::Cylinder { .. } | Shape::Cone { .. } => {
                let f = Frustum::of(shape)?;
                let [half_length, lower, upper] = [f.half_length, f.lower, f.upper].map(|size| left * size);
                (Set::Frustum(Frustum { half_length, lower, upper }, less * f.inner_ball().0), 0.0)
            }
            Shape::Ellipsoid { half } => (Set::Ellipsoid(left * *half), 0.0),
            // A body is stopped by the ball that fits into it.
            Shape::Field(_) | Shape::Mesh(_) if shape.inner_radius() > 0.0 => {
                (Set::Points([shape.inner_center()].into_iter().collect()), left * shape.inner_radius())
            }
            Shape::HalfSpace { .. }
            | Shape::Field(_)
            | Shape::Mesh(_)
            | Shape::HeightField(_)
            | Shape::Compound(_) => {
                return None;
            }
        };
        Some(Core::of(set, radius, motion))
    }

    /// The middle of a shape's inner ball.
    fn middle(shape: &Shape, motion: &Motion) -> Self {
        Core::of(Set::Points([shape.inner_center()].into_iter().collect()), 0.0, motion)
    }

    fn of(set: Set, radius: f32, motion: &Motion) -> Self {
        let corners = set.corners();
        let reach = radius + furthest(&corners, motion.center);
        let axis = motion.start.inverse_vector(motion.rotation).normalize_or_zero();
        let arm = corners.iter().fold(0.0_f32, |far, &p| far.max(axis.cross(p - motion.center).length()));
        let ball = match &set {
            Set::Points(points) if points.len() == 1 => (points[0], radius),
            _ => (motion.center, reach),
        };
        Core { set, radius, reach, arm, ball }
    }

    /// Whether it is a point and its skin.
    fn is_ball(&self) -> bool {
        matches!(&self.set, Set::Points(points) if points.len() == 1)
    }

    /// As what something runs into.
    pub(crate) fn as_other(&self) -> Other<'_> {
        Other::Convex { set: &self.set, radius: self.radius, arm: self.arm, front: None }
    }
}

/// A shape and, made when they are asked for, its cores: each a layer of [`SUNK`] smaller, down to its middle.
pub(crate) struct Cores<'a> {
    shape: &'a Shape,
    pub(crate) whole: Core,
    smaller: [OnceCell<Option<Core>>; LAYERS],
}

impl<'a> Cores<'a> {
    /// None where the shape is not convex and bounded.
    pub(crate) fn new(shape: &'a Shape, motion: &Motion) -> Option<Self> {
        Some(Cores::around(shape, Core::new(shape, motion, 0.0)?))
    }

    fn around(shape: &'a Shape, whole: Core) -> Self {
        Cores { shape, whole, smaller: Default::default() }
    }

    /// The shape without so many layers; at the least its middle.
    pub(crate) fn less(&self, layers: usize, motion: &Motion) -> Option<&Core> {
        let layers = layers.min(LAYERS);
        let Some(place) = layers.checked_sub(1) else { return Some(&self.whole) };
        let core = || match layers {
            LAYERS => Some(Core::middle(self.shape, motion)),
            _ => Core::new(self.shape, motion, SUNK * layers as f32),
        };
        self.smaller[place].get_or_init(core).as_ref()
    }
}

fn furthest(points: &[Vec3], center: Vec3) -> f32 {
    points.iter().fold(0.0, |far, p| far.max(p.distance(center)))
}

/// What A may run into.
pub(crate) enum Other<'a> {
    HalfSpace {
        normal: Vec3,
        offset: f32,
    },
    /// A set with a skin; only from the front where there is a front.
    Convex {
        set: &'a Set,
        radius: f32,
        /// Largest distance of a point from B's axis of rotation, metres, or more.
        arm: f32,
        front: Option<Vec3>,
    },
}

/// The nearest points at some time, in the shared frame.
pub(crate) struct Gap {
    pub(crate) distance: f32,
    normal: Vec3,
    point: Vec3,
}

pub(crate) struct Course<'a> {
    pub(crate) sweep: &'a Sweep,
    /// Inner radius of A, metres.
    pub(crate) inner: f32,
    pub(crate) target: f32,
}

impl Course<'_> {
    /// The first impact of a core of A between `from` and `until`.
    pub(crate) fn advance(&self, core: &Core, other: &Other, from: f32, until: f32) -> Option<Toi> {
        let Sweep { a, b } = self.sweep;
        let approach = a.translation - b.translation;
        let apart = (a.center_at(0.0) - b.center_at(0.0))
            .length()
            .max((a.center_at(1.0) - b.center_at(1.0)).length());
        let arm_b = match other {
            Other::HalfSpace { .. } => apart + core.reach,
            Other::Convex { arm, .. } => *arm,
        };
        // What the places are worth, in single precision.
        let rounding = 1e-6 * (apart + core.reach);
        let target = self.target.max(4.0 * rounding);
        let tolerance = rounding.max(0.05 * target);
        let mut time = from;
        let mut last = None;
        for _ in 0..MAX_STEPS {
            let Some(gap) = self.gap(core, other, time) else {
                // Overlap: possible at the start only, up to rounding.
                return if time > 0.0 { last } else { self.overlapping(other) };
            };
            if let Other::Convex { front: Some(front), .. } = other {
                let front = b.at(time).vector(*front);
                if gap.normal.dot(front) > 1e-3 && gap.distance <= target + tolerance {
                    return None;
                }
            }
            let closing = approach.dot(gap.normal);
            let hit = Toi { time, normal: gap.normal, point: gap.point, distance: gap.distance };
            if gap.distance <= target + tolerance {
                return (time > 0.0 || closing > self.inner).then_some(hit);
            }
            last = Some(hit);
            let speed = closing
                + gap.normal.cross(a.rotation).length() * core.arm
                + gap.normal.cross(b.rotation).length() * arm_b;
            if speed <= 0.0 {
                return None;
            }
            // Rounded down, so that rounding never steps over the target.
            let step = (gap.distance - target) / (speed * (1.0 + 1e-6));
            let next = time + step;
            if next > until {
                return None;
            }
            if next <= time {
                return last;
            }
            time = next;
        }
        last
    }

    /// Nearest points at a time; none where the shapes overlap.
    pub(crate) fn gap(&self, core: &Core, other: &Other, time: f32) -> Option<Gap> {
        let (a, b) = (self.sweep.a.at(time), self.sweep.b.at(time));
        match other {
            Other::HalfSpace { normal, offset } => {
                let normal = b.vector(*normal);
                let height = |p: Vec3| normal.dot(p - b.translation) - offset;
                let lowest = a.point(core.set.lowest(a.inverse_vector(normal))?);
                let distance = height(lowest) - core.radius;
                let point = lowest - core.radius * normal;
                (distance > 0.0).then_some(Gap { distance, normal: -normal, point })
            }
            Other::Convex { set: Set::Points(corners), radius, .. }
                if corners.len() == 3 && core.is_ball() =>
            {
                let middle = a.point(core.ball.0);
                let seen = b.inverse_point(middle).as_dvec3();
                let way = nearest_on_triangle([0, 1, 2].map(|k| corners[k].as_dvec3() - seen)).0;
                let distance = way.length() as f32 - core.radius - radius;
                let normal = b.vector(way.normalize_or_zero().as_vec3());
                (distance > 0.0).then(|| Gap { distance, normal, point: middle + core.radius * normal })
            }
            Other::Convex { set, radius, .. } => {
                let placed = Placed::new(&a.inverse().then_after(&b));
                let Walk::Apart(near) = walk(&core.set, *set, &placed, f64::INFINITY) else {
                    return None;
                };
                let closest = near.closest();
                let distance = closest.distance - core.radius - radius;
                let normal = a.vector(closest.normal);
                let point = a.point(closest.on_a) + core.radius * normal;
                (distance > 0.0).then_some(Gap { distance, normal, point })
            }
        }
    }

    /// Shapes that overlap at the start: an impact only where A goes on through B.
    fn overlapping(&self, other: &Other) -> Option<Toi> {
        let Sweep { a, b } = self.sweep;
        let normal = match other {
            Other::HalfSpace { normal, .. } => -b.start.vector(*normal),
            Other::Convex { front: Some(front), .. } => -b.start.vector(*front),
            Other::Convex { set, .. } => {
                (b.start.point(set.middle()) - a.center_at(0.0)).normalize_or(Vec3::Z)
            }
        };
        let closing = (a.translation - b.translation).dot(normal);
        let point = a.center_at(0.0);
        (closing > self.inner).then_some(Toi { time: 0.0, normal, point, distance: 0.0 })
    }

    /// The first impact with a triangle.
    fn surface<S: Surface>(&self, cores: &Cores, surface: &S) -> Option<Toi> {
        let Sweep { a, b } = self.sweep;
        let whole = &cores.whole;
        let (middle, size) = whole.ball;
        let length = (a.translation - b.translation).length();
        let length = length + a.rotation.length() * middle.distance(a.center);
        let pieces = ((length / (2.0 * size)).ceil() as usize).clamp(1, MAX_PIECES);
        let mut best: Option<Toi> = None;
        let mut triangles = Vec::new();
        for piece in 0..pieces {
            let [from, until] = [piece, piece + 1].map(|k| k as f32 / pieces as f32);
            triangles.clear();
            surface.near(&self.passed(whole, from, until), |triangle| triangles.push(triangle));
            triangles.sort_unstable();
            let places = [from, 1.0].map(|time| b.at(time).inverse().then_after(&a.at(time)));
            for &triangle in &triangles {
                let corners = surface.corners(triangle);
                let front = surface.normal(triangle);
                if self.passes(whole, &corners, front, from, &places) {
                    continue;
                }
                let limit = best.map_or(until, |toi| toi.time);
                if let Some(toi) = self.through(cores, &corners, front, from, limit)
                    && best.is_none_or(|first| toi.time < first.time)
                {
                    best = Some(toi);
                }
            }
            if best.is_some() {
                return best;
            }
        }
        None
    }

    /// When a triangle stops A between two times, if A would go through it.
    fn through(&self, cores: &Cores, corners: &[Vec3; 3], front: Vec3, from: f32, until: f32) -> Option<Toi> {
        let Sweep { a, b } = self.sweep;
        let arm = furthest(corners, b.center);
        let set = Set::Points(corners.iter().copied().collect());
        let other = Other::Convex { set: &set, radius: 0.0, arm, front: Some(front) };
        let start = self.gap(&cores.whole, &other, 0.0);
        if start.is_none_or(|gap| gap.distance <= NEAR * self.inner) {
            // Layers of A that were in the triangle from the start.
            let mut sunk = 0;
            while self.gap(cores.less(sunk, a)?, &other, 0.0).is_none() && sunk < LAYERS {
                sunk += 1;
            }
            return self.advance(cores.less(sunk + 1, a)?, &other, from, until);
        }
        let touch = self.advance(&cores.whole, &other, from, until)?;
        self.advance(cores.less(1, a)?, &other, touch.time, 1.0).map(|_| touch)
    }

    /// Whether a triangle needs no look from here on: A is behind it, or hardly sinks into its plane until the end. `places` are
    /// those of A, seen from B, at the time `from` and at the end.
    fn passes(
        &self,
        whole: &Core,
        corners: &[Vec3; 3],
        front: Vec3,
        from: f32,
        places: &[Isometry; 2],
    ) -> bool {
        let Sweep { a, b } = self.sweep;
        let [(low, high), (low_after, _)] = places.map(|place| {
            let height = front.dot(place.translation - corners[0]);
            let (low, high) = whole.set.extent(place.inverse_vector(front));
            (height + low, height + high)
        });
        // Between two times a turning point dips below its chord by no more than the sagitta of its arc, seen in the plane
        // of the arc and of the normal.
        let dip = if b.rotation == Vec3::ZERO {
            let tilt = b.start.vector(front).cross(a.rotation).length();
            0.125 * tilt * a.rotation.length() * whole.arm
        } else {
            let turn = a.rotation.length() + b.rotation.length();
            0.125 * turn * turn * (whole.reach + furthest(corners, b.center))
        };
        let dip = dip * (1.0 - from) * (1.0 - from);
        high + whole.radius <= 0.0
            || low.min(low_after) - dip - whole.radius > -self.target.max(SUNK * self.inner)
    }

    /// The part of B's frame that A passes through between two times.
    pub(crate) fn passed(&self, whole: &Core, from: f32, until: f32) -> Aabb {
        let Sweep { a, b } = self.sweep;
        let (middle, size) = whole.ball;
        let middle_at = |time: f32| {
            if middle == a.center { a.center_at(time) } else { a.at(time).point(middle) }
        };
        let ends = [from, until]
            .map(|time| b.at(from).inverse_point(middle_at(time) - b.translation * (time - from)));
        // A turn of B moves the middle, seen from B, on an arc around B's centre; one of A moves it off its chord by the sagitta of its own arc.
        let arm = ends[0].distance(b.center).max(ends[1].distance(b.center));
        let turned = b.rotation.length() * (until - from) * arm;
        let angle = a.rotation.length() * (until - from);
        let bent = 0.125 * angle * angle * middle.distance(a.center);
        let far = ends[0].abs().max(ends[1].abs()).max_element();
        Aabb::from_points(ends).grown(size + 1.1 * self.target + turned + bent + 1e-5 * (far + whole.reach))
    }
}
