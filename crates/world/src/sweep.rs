//! Stage 12, **sweep**: continuous detection.
//!
//! Reads drift, poses and the trees; writes poses and velocities. A body that moves further in a step than contacts can see ahead is taken along its
//! way from the start of the step, and stopped where it would begin to pass *through* another (see
//! [`rockfall_collide::passage`]): the core of one reaches the other. What is left of its way it goes along that body, so that nothing that
//! is fast stands still; its velocity is left to the contact that the next step finds there, less what `gravity` gave it on the way that it did not
//! go.
//!
//! 1. [`fly`](flight::fly) takes each fast body past those that contacts can't move, beside all others.
//! 2. [`meet`](meet::meet) finds who would pass through a body that contacts move, and settles that in the order of time.
//!
//! Stopped wherever they touch, bodies of a stream were run into by those behind them: boulders of the rock slide
//! overlapped by 50 mm on average, without stops by 2 mm. Bodies in contact hardly ever reach each other's cores.

mod flight;
mod meet;
mod ways;

use crate::bodies::Bodies;
use crate::index::Index;
use crate::{Kind, Shape};
use flight::{Flight, fly, way};
use meet::meet;
use rayon::prelude::*;
use rockfall_math::share::Share;
use rockfall_math::{Aabb, Pose, Quat, Vec3, rotation};
use rockfall_solve::line::Role;
use rockfall_tree::Tree;

/// A body is fast when a point of it moves by more than this share of its inner radius in a step: what its reach, which
/// grows with its speed up to the same share, may not see.
const FAST: f32 = 0.5;

/// Bodies are thin whose inner radius is less than this share of the outer one: rods and plates beyond 1:100.
///
/// Others keep their velocity when they are stopped. Of what is as thin that gives energy, in two ways. Put back to how it was turned before, a rod that spun about its axis turns at that rate
/// across, and has a hundred thousand times the energy: so its angular velocity is turned with it. And contacts of plates that cross each other may let go what is held here; it fell on the spot, and left at 36 m/s. So what is stopped in two steps running, after contacts have had their say, is no faster than it went.
const THIN: f32 = 0.01;

/// What stands in the way.
#[derive(Clone, Copy)]
pub(crate) struct Surroundings<'a> {
    pub(crate) shapes: &'a [Shape],
    pub(crate) trees: &'a Index,
    /// How each row was turned when the step began. Drift does not tell: it adds up turns about axes that change.
    pub(crate) starts: &'a [Quat],
}

/// Stops fast bodies at what they would pass through. `gravity`, m/s², is that whose work is taken back; zero where it is not. `dt` is the length of the step, s, and `step` its number.
pub(crate) fn sweep(bodies: &mut Bodies, around: Surroundings<'_>, gravity: Vec3, dt: f32, step: u32) {
    for flight in stopped(bodies, around) {
        let (row, drift) = (flight.row as usize, flight.drift());
        let inner = bodies.inners[row];
        let thin = bodies.roles[row] == Role::Free && inner > 0.0 && inner < THIN * bodies.radii[row];
        let old = &mut bodies.drifts[row];
        let turn = rotation::from_rotation_vector(drift.rotation());
        let missed = drift.translation() - old.translation();
        bodies.positions[row] += missed.as_dvec3();
        let line = &mut bodies.lines[row];
        let (v, w) = (line.velocity(), line.angular_velocity());
        line.set_velocities(unfallen(v, gravity * line.gravity_scale(), missed), w);
        let before = bodies.rotations[row];
        bodies.rotations[row] = rotation::normalize(rotation::compose(turn, around.starts[row]));
        *old = drift;
        if thin {
            let turned = rotation::compose(bodies.rotations[row], rotation::inverse(before));
            let (mut v, mut w) = (line.velocity(), rotation::rotate(turned, w));
            if bodies.stops[row] == step {
                let slower = no_faster(v, drift.translation() / dt);
                // It is no contact's impulse.
                for (r, lost) in bodies.references[row].iter_mut().zip((slower - v).to_array()) {
                    *r += lost;
                }
                v = slower;
                w = no_faster(w, drift.rotation() / dt);
            }
            bodies.stops[row] = step.wrapping_add(1);
            line.set_velocities(v, w);
        }
    }
}

/// A velocity, but no more than what was gone.
fn no_faster(v: Vec3, went: Vec3) -> Vec3 {
    if went.length_squared() < v.length_squared() { went } else { v }
}

/// The velocity of a body that was put `way` metres away from where it had come: ½ v² along gravity has to be what it is there.
fn unfallen(v: Vec3, gravity: Vec3, way: Vec3) -> Vec3 {
    let Some(down) = gravity.try_normalize() else { return v };
    let along = v.dot(down);
    let squared = (along * along + 2.0 * gravity.dot(way)).max(0.0);
    v + down * (squared.sqrt().copysign(along) - along)
}

/// The flights of those that can't go on as the solver has moved them.
fn stopped(bodies: &Bodies, around: Surroundings<'_>) -> Vec<Flight> {
    let Surroundings { shapes, trees, starts } = around;
    let rows = || (1..bodies.rows() as u32).into_par_iter().with_min_len(512).shared();
    let role = |row: u32| bodies.roles[row as usize];
    let moves = |row: u32| bodies.drifts[row as usize].0 != [0.0; 8];
    let mut movers: Vec<u32> =
        rows().filter(|&row| role(row) == Role::Free && is_fast(bodies, shapes, row as usize)).collect();
    let driven: Vec<u32> = rows().filter(|&row| role(row) == Role::Driven && moves(row)).collect();
    for driven in driven {
        overrun(bodies, around, driven, &mut movers);
    }
    if movers.is_empty() {
        return Vec::new();
    }
    movers.sort_unstable();
    movers.dedup();
    let driven = rows().filter(|&row| bodies.kinds[row as usize] == Kind::Kinematic);
    let (driven, ways): (_, Vec<_>) = driven.map(|row| (row, way_box(bodies, around, row as usize))).unzip();
    let driven = Crowd::new(driven, &ways);
    let scene = Scene { bodies, shapes, trees, starts, driven: &driven };
    let flights: Vec<Flight> =
        movers.into_par_iter().shared().map(|row| fly(&scene, Flight::straight(&scene, row))).collect();
    meet(&scene, flights)
}

/// What flights are flown in: bodies, and where to look for them. The trees' boxes date from the start of the step.
#[derive(Clone, Copy)]
struct Scene<'a> {
    bodies: &'a Bodies,
    shapes: &'a [Shape],
    trees: &'a Index,
    starts: &'a [Quat],
    /// Kinematic bodies, on their way through the step.
    driven: &'a Crowd,
}

/// Some bodies, and where they come in the step.
struct Crowd {
    rows: Vec<u32>,
    /// Over places in `rows`.
    tree: Tree,
}

impl Crowd {
    fn new(rows: Vec<u32>, ways: &[Aabb]) -> Self {
        Crowd { tree: Tree::build(ways), rows }
    }

    /// Those whose way meets an area.
    fn query(&self, area: &Aabb, mut f: impl FnMut(u32)) {
        self.tree.query(area, |place| f(self.rows[place as usize]));
    }
}

impl<'a> Scene<'a> {
    fn shape(&self, row: u32) -> Option<&'a Shape> {
        self.shapes.get(self.bodies.shapes[row as usize] as usize)
    }

    /// Whether two bodies collide.
    fn collide(&self, a: u32, b: u32) -> bool {
        collide(self.bodies, a, b)
    }

    /// Rows of bodies that contacts can't move and that `area` may meet in this step, ascending.
    fn near_fixed(&self, row: u32, area: &Aabb) -> Vec<u32> {
        let mut near = Vec::new();
        let mut meets = |other: u32| near.extend(Some(other).filter(|&other| self.collide(row, other)));
        self.trees.fixed.query(area, &mut meets);
        self.driven.query(area, &mut meets);
        near.sort_unstable();
        near
    }
}

fn collide(bodies: &Bodies, a: u32, b: u32) -> bool {
    let [[group, mask], [others, other_mask]] = [a, b].map(|row| bodies.filters[row as usize]);
    a != b && group & other_mask != 0 && others & mask != 0
}

/// Adds those to `movers` that a kinematic body runs over: it passes the place of each by more than what contacts of that see. Balls in a drum
/// that turns go with it.
fn overrun(bodies: &Bodies, around: Surroundings<'_>, driven: u32, movers: &mut Vec<u32>) {
    let d = driven as usize;
    let (way, turn) = (bodies.drifts[d].translation(), bodies.drifts[d].rotation());
    let mut near = Vec::new();
    around.trees.movers.query(&way_box(bodies, around, d), |row| near.push(row));
    movers.par_extend(near.into_par_iter().with_min_len(512).shared().filter(|&row| {
        let r = row as usize;
        let arm = (bodies.positions[r] - bodies.positions[d]).as_vec3();
        let passes = (way + turn.cross(arm) - bodies.drifts[r].translation()).length();
        passes > FAST * bodies.inners[r] && bodies.roles[r] == Role::Free && collide(bodies, row, driven)
    }));
}

fn is_fast(bodies: &Bodies, shapes: &[Shape], row: usize) -> bool {
    let drift = &bodies.drifts[row];
    let (way, turn) = (drift.translation().length(), drift.rotation());
    let limit = FAST * bodies.inners[row];
    if way + turn.length() * bodies.radii[row] <= limit || bodies.roles[row] == Role::Still {
        return false;
    }
    // A needle that turns about its own axis hardly moves.
    let Some(shape) = shapes.get(bodies.shapes[row] as usize) else { return false };
    let turn = rotation::rotate(rotation::inverse(bodies.rotations[row]), turn).abs();
    let bounds = shape.bounds();
    let half = (bounds.min - bodies.centers[row]).abs().max((bounds.max - bodies.centers[row]).abs());
    let [x, y, z] = [
        turn.y * half.z + turn.z * half.y,
        turn.z * half.x + turn.x * half.z,
        turn.x * half.y + turn.y * half.x,
    ];
    way + Vec3::new(x, y, z).length() > limit
}

/// A box around all of a body on its way through the step.
fn way_box(bodies: &Bodies, around: Surroundings<'_>, row: usize) -> Aabb {
    let end = bodies.shape_pose(row);
    let (center, radius) = (bodies.centers[row], bodies.radii[row]);
    let rotation = if bodies.roles[row] == Role::Still { end.rotation } else { around.starts[row] };
    let way = way(bodies, row as u32).0.as_dvec3();
    let arm = rotation::rotate(rotation, center).as_dvec3();
    let start = Pose { position: bodies.positions[row] - way - arm, rotation };
    match around.shapes.get(bodies.shapes[row] as usize) {
        Some(shape) => swept_bounds(shape, center, radius, [&start, &end]),
        None => Aabb::around(start.position.min(end.position), start.position.max(end.position)),
    }
}

/// Radians above which a body that turns may be anywhere about its centre.
const TURNS: f32 = 1.0;

/// A box around a shape that goes straight from one pose to another, and turns evenly about its `center`, from which no point of it is further than `radius`: around both
/// places, and what arcs bulge out over their chords. Not around all ways in which it could be turned: most of those of a long wall are far from where it is.
fn swept_bounds(shape: &Shape, center: Vec3, radius: f32, [start, end]: [&Pose; 2]) -> Aabb {
    let turn = rotation::compose(end.rotation, rotation::inverse(start.rotation));
    let angle = rotation::to_rotation_vector(turn).length();
    if angle > TURNS {
        let [from, to] = [start, end].map(|pose| pose.point(center));
        return Aabb::around(from.min(to), from.max(to)).grown(radius);
    }
    // 1 - cos x ≤ x² / 2, at half of the turn. Without a turn there is none, however large the body.
    let bulge = if angle > 0.0 { 0.125 * angle * angle * radius } else { 0.0 };
    shape.placed_bounds(start).union(&shape.placed_bounds(end)).grown(bulge)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::DVec3;

    /// Falling at 10 m/s after a step in which it would have gone a metre further than it came; and thrown upwards.
    #[test]
    fn a_way_that_was_not_gone_gave_no_speed() {
        let (gravity, up) = (Vec3::Z * -10.0, Vec3::Z);
        let v = unfallen(Vec3::new(3.0, 0.0, -10.0), gravity, up);
        assert!((v - Vec3::new(3.0, 0.0, -(80.0_f32.sqrt()))).length() < 1e-5, "{v}");
        let v = unfallen(Vec3::Z * 10.0, gravity, -up);
        assert!((v.z - 120.0_f32.sqrt()).abs() < 1e-5, "{v}");
        assert_eq!(unfallen(Vec3::Z * -1.0, gravity, up), Vec3::ZERO);
        assert_eq!(unfallen(Vec3::X, Vec3::ZERO, up), Vec3::X);
    }

    /// A long wall, seen every hundredth of its way; and that its box is not one around all that it could be.
    #[test]
    fn a_body_on_its_way_is_in_its_box() {
        let half = Vec3::new(0.2, 10.0, 3.0);
        let (shape, center) = (Shape::Box { half }, Vec3::new(0.0, -4.0, 1.0));
        let radius = (half + center.abs()).length();
        let axis = Vec3::new(2.0, -1.0, 0.5).normalize();
        let rotation = Quat::from_xyzw(0.1, 0.2, -0.3, 0.9).normalize();
        for angle in [0.0, 0.01, 0.3, 0.9, 2.5_f32] {
            let way = DVec3::new(1.0, -0.5, 2.0) * f64::from(angle);
            let at = |share: f32| {
                let rotation =
                    rotation::compose(rotation::from_rotation_vector(axis * angle * share), rotation);
                let arm = rotation::rotate(rotation, center).as_dvec3();
                Pose { position: DVec3::new(1e3, 2e3, 5.0) + way * f64::from(share) - arm, rotation }
            };
            let bounds = swept_bounds(&shape, center, radius, [&at(0.0), &at(1.0)]);
            for k in 0..=100 {
                let there = shape.placed_bounds(&at(k as f32 / 100.0));
                // A unit in the last place of a kilometre.
                assert!(bounds.grown(1.3e-4).contains(&there), "{angle} {k}: {bounds:?} {there:?}");
            }
            let volume = (bounds.max - bounds.min).element_product();
            assert!(angle > 1.0 || volume < 0.5 * (2.0 * radius).powi(3), "{angle}: {bounds:?} of {radius}");
        }
    }
}
