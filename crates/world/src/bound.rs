//! Stage 2, **bound**: boxes for the broad phase.
//!
//! Reads poses and shapes; writes each moving body's way, reach, inverse inertia in world axes, role, and box, and tells which
//! boxes are new. A box has room to move in: it stays until the body, with its reach, leaves it.

use crate::bodies::{Bodies, State};
use crate::recall::way;
use crate::{Kind, Settings, Shape};
use rayon::prelude::*;
use rockfall_math::Vec3;
use rockfall_solve::line::Role;
use std::mem::take;

/// Reach of a body at rest, as a share of its inner radius. Contacts are made before bodies touch, so that a pile's
/// contacts don't come and go with its last tremors.
const REACH: f32 = 0.02;

/// The most that speed adds to the reach, as a share of the inner radius. Faster bodies are stopped by
/// [`crate::sweep`].
const FAST_REACH: f32 = 0.5;

/// Room in a new box, as a share of the inner radius.
const ROOM: f32 = 0.1;

/// Room in a new box for motion, in steps.
const STEPS: f32 = 3.0;

/// Updates what follows from the poses. The result holds, row by row, whether the body has a new box; `all` renews every
/// box.
pub(crate) fn bound(
    bodies: &mut Bodies,
    shapes: &[Shape],
    settings: &Settings,
    all: bool,
    moved: &mut Vec<bool>,
) {
    moved.clear();
    moved.resize(bodies.rows(), false);
    // The columns that are written leave the others for so long.
    let (mut boxes, mut reaches) = (take(&mut bodies.boxes), take(&mut bodies.reaches));
    let (mut lines, mut roles) = (take(&mut bodies.lines), take(&mut bodies.roles));
    let mut ways = take(&mut bodies.ways);
    let dt = 1.0 / settings.rate;
    (&mut boxes, &mut reaches, &mut lines, &mut roles, &mut ways, moved)
        .into_par_iter()
        .enumerate()
        .with_min_len(256)
        .for_each(|(row, (old, reach, line, role, gone, moved))| {
            let (kind, awake) = (bodies.kinds[row], bodies.states[row] == State::Awake);
            if kind == Kind::Dynamic && (all || awake) {
                line.set_inverse_inertia(&bodies.world_inverse_inertia(row));
            }
            *role = match (kind, awake) {
                (Kind::Dynamic, true) => Role::Free,
                (Kind::Kinematic, true) => Role::Driven,
                _ => Role::Still,
            };
            let radius = if bodies.is_ball(row, shapes) { 0.0 } else { bodies.radii[row] };
            *gone = gone.wrapping_add(way(&bodies.drifts[row], radius));
            let Some(shape) = shapes.get(bodies.shapes[row] as usize) else { return };
            if !all && *role == Role::Still {
                return;
            }
            let bounds = shape.placed_bounds(&bodies.shape_pose(row));
            if kind == Kind::Static {
                (*old, *moved) = (bounds, true);
                return;
            }
            // A kinematic surface has no inner radius, or an infinite one; its partners reach for it.
            let inner = Some(shape.inner_radius()).filter(|r| r.is_finite()).unwrap_or_default();
            let speed = line.velocity().length() + line.angular_velocity().length() * bodies.radii[row];
            *reach = REACH * inner + (speed * dt).min(FAST_REACH * inner);
            let tight = bounds.grown(*reach);
            if !all && old.contains(&tight) {
                return;
            }
            let ahead = line.velocity() * (STEPS * dt);
            let mut fat = tight.grown(ROOM * inner);
            fat.min += ahead.min(Vec3::ZERO);
            fat.max += ahead.max(Vec3::ZERO);
            (*old, *moved) = (fat, true);
        });
    (bodies.boxes, bodies.reaches) = (boxes, reaches);
    (bodies.lines, bodies.roles, bodies.ways) = (lines, roles, ways);
}
