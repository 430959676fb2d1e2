//! Stage 2, **bound**: boxes for the broad phase.
//!
//! Reads poses and shapes; writes each moving body's way, to which counts what its reach grows by, reach, inverse inertia in world axes, role, and box, and tells which
//! boxes are new. A box has room to move in: it stays until the body, with its reach, leaves it. How much of the room is left is counted
//! down by the way that the body goes, so that bodies that hardly move need not be measured.

use crate::bodies::{Bodies, State};
use crate::index::Turnover;
use crate::recall::{LEAP, count_below, count_of, way};
use crate::{Kind, Settings, Shape};
use rayon::prelude::*;
use rockfall_math::share::Share;
use rockfall_math::{Aabb, Vec3};
use rockfall_solve::line::Role;
use std::collections::BTreeSet;
use std::mem::take;

/// Reach of a body at rest, as a share of its inner radius. Contacts are made before bodies touch, so that a pile's
/// contacts don't come and go with its last tremors.
const REACH: f32 = 0.02;

/// The most that speed adds to the reach, as a share of the inner radius. Faster bodies are stopped by
/// [`crate::sweep`].
const FAST_REACH: f32 = 0.5;

/// Room in a new box, as a share of the inner radius.
const ROOM: f32 = 0.1;

/// Room in a new box for motion, in steps. With three, a ball in a pour had 13 partners instead of 10, and no step was shorter.
const STEPS: f32 = 1.0;

/// Updates what follows from the poses. The result holds, row by row, whether the body has a new box, as new and `stirred` ones always have.
pub(crate) fn bound(
    bodies: &mut Bodies,
    shapes: &[Shape],
    settings: &Settings,
    Turnover { fresh, all }: Turnover,
    stirred: &BTreeSet<u32>,
    moved: &mut Vec<bool>,
) {
    moved.clear();
    moved.resize(bodies.rows(), false);
    // The columns that are written leave the others for so long.
    let (mut boxes, mut reaches) = (take(&mut bodies.boxes), take(&mut bodies.reaches));
    let (mut lines, mut roles) = (take(&mut bodies.lines), take(&mut bodies.roles));
    let (mut ways, mut spares) = (take(&mut bodies.ways), take(&mut bodies.spares));
    let dt = 1.0 / settings.rate;
    let first_fresh = bodies.rows() - fresh;
    (&mut boxes, &mut reaches, &mut lines, &mut roles, &mut ways, &mut spares, moved)
        .into_par_iter()
        .enumerate()
        .with_min_len(256)
        .shared()
        .for_each(|(row, (old, reach, line, role, gone, spare, moved))| {
            let (kind, awake) = (bodies.kinds[row], bodies.states[row] == State::Awake);
            // A plane is infinitely large, and would seem to go any way by not turning at all.
            let all = all || row >= first_fresh || stirred.contains(&(row as u32));
            if kind == Kind::Static && !all {
                return;
            }
            *role = match (kind, awake) {
                (Kind::Dynamic, true) => Role::Free,
                (Kind::Kinematic, true) => Role::Driven,
                _ => Role::Still,
            };
            if kind == Kind::Dynamic && (all || awake) {
                line.set_inverse_inertia(&bodies.inverse_inertia_over(row, line, dt));
            }
            let radius = if bodies.balls[row] { 0.0 } else { bodies.radii[row] };
            let way = way(&bodies.drifts[row], radius);
            *gone = gone.wrapping_add(way);
            if !all && *role == Role::Still {
                return;
            }
            let Some(shape) = shapes.get(bodies.shapes[row] as usize) else { return };
            if kind == Kind::Static {
                (*old, *moved) = (shape.placed_bounds(&bodies.shape_pose(row)), true);
                return;
            }
            // A kinematic surface has none; its partners reach for it.
            let inner = bodies.inners[row];
            let speed = line.velocity().length() + line.angular_velocity().length() * bodies.radii[row];
            let before = *reach;
            *reach = REACH * inner + (speed * dt).min(FAST_REACH * inner);
            let grown = count_of((*reach - before).max(0.0));
            *gone = gone.wrapping_add(grown.min(LEAP - way));
            *spare = spare.saturating_sub(way).saturating_sub(grown);
            if !all && *spare > 0 {
                return;
            }
            let tight = shape.placed_bounds(&bodies.shape_pose(row)).grown(*reach);
            if all || !old.contains(&tight) {
                *moved = true;
                *old = roomy(&tight, inner, line.velocity() * (STEPS * dt));
            }
            *spare = room_in(old, &tight);
        });
    (bodies.boxes, bodies.reaches) = (boxes, reaches);
    (bodies.lines, bodies.roles) = (lines, roles);
    (bodies.ways, bodies.spares) = (ways, spares);
}

/// A box with room to move in, most of it ahead, metres.
fn roomy(tight: &Aabb, inner: f32, ahead: Vec3) -> Aabb {
    let mut fat = tight.grown(ROOM * inner);
    fat.min += ahead.min(Vec3::ZERO);
    fat.max += ahead.max(Vec3::ZERO);
    fat
}

/// How far `tight` may move or grow and be inside of `fat` still, as a count of way. A little less, for what boxes lose to rounding.
fn room_in(fat: &Aabb, tight: &Aabb) -> u32 {
    let room = (tight.min - fat.min).min_element().min((fat.max - tight.max).min_element());
    count_below(0.9 * room)
}
