//! Stage 2, **bound**: boxes for the broad phase.
//!
//! Reads poses and shapes; writes each moving body's reach, inverse inertia in world axes, role, and box, and tells which
//! boxes are new. A box has room to move in: it stays until the body, with its reach, leaves it.

use crate::bodies::{Bodies, State};
use crate::{Kind, Settings, Shape};
use rayon::prelude::*;
use rockfall_math::{Aabb, Mat3, Vec3};
use rockfall_solve::line::Role;

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
    let dt = 1.0 / settings.rate;
    let rows = bodies.rows();
    moved.clear();
    moved.resize(rows, false);
    let inertias: Vec<Option<Mat3>> = (0..rows)
        .into_par_iter()
        .with_min_len(256)
        .map(|row| {
            let turns = bodies.kinds[row] == Kind::Dynamic && (all || bodies.states[row] == State::Awake);
            turns.then(|| bodies.world_inverse_inertia(row))
        })
        .collect();
    let renewed: Vec<Option<(f32, Aabb, bool)>> = (1..rows)
        .into_par_iter()
        .with_min_len(256)
        .map(|row| {
            let shape = shapes.get(bodies.shapes[row] as usize)?;
            let mover = bodies.kinds[row] != Kind::Static && bodies.states[row] == State::Awake;
            if !all && !mover {
                return None;
            }
            let pose = bodies.shape_pose(row);
            if !bodies.is_mover(row) {
                return Some((0.0, shape.placed_bounds(&pose), true));
            }
            // A kinematic surface has no inner radius, or an infinite one; its partners reach for it.
            let inner = Some(shape.inner_radius()).filter(|r| r.is_finite()).unwrap_or_default();
            let line = &bodies.lines[row];
            let speed = line.velocity().length() + line.angular_velocity().length() * bodies.radii[row];
            let reach = REACH * inner + (speed * dt).min(FAST_REACH * inner);
            let tight = shape.placed_bounds(&pose).grown(reach);
            let old = bodies.boxes[row];
            if !all && old.contains(&tight) {
                return Some((reach, old, false));
            }
            let way = line.velocity() * (STEPS * dt);
            let mut fat = tight.grown(ROOM * inner);
            fat.min += way.min(Vec3::ZERO);
            fat.max += way.max(Vec3::ZERO);
            Some((reach, fat, true))
        })
        .collect();
    for (row, new) in (1..).zip(renewed) {
        if let Some((reach, fat, is_new)) = new {
            bodies.reaches[row] = reach;
            bodies.boxes[row] = fat;
            moved[row] = is_new;
        }
    }
    for (row, inertia) in inertias.into_iter().enumerate() {
        if let Some(m) = inertia {
            bodies.lines[row].set_inverse_inertia(&m);
        }
        bodies.roles[row] = match (bodies.kinds[row], bodies.states[row]) {
            (Kind::Dynamic, State::Awake) => Role::Free,
            (Kind::Kinematic, State::Awake) => Role::Driven,
            _ => Role::Still,
        };
    }
}
