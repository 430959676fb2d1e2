//! Stage 11, **settle**: the drift becomes part of the pose.
//!
//! Reads drift and velocities; writes positions, time at rest, and who is frozen. A state that is not finite is caught here,
//! before anything can read it.

use crate::Settings;
use crate::bodies::{Bodies, State};
use rayon::prelude::*;
use rockfall_math::share::Share;
use rockfall_math::{Quat, Vec3};
use rockfall_solve::line::Role;
use rockfall_solve::slender::{attitude, long_axis, uncarried};

/// No body moves faster than this, m/s or rad/s: beyond it a state counts as broken, long before it overflows.
const LIMIT: f32 = 1e7;

/// Moves the bodies. Returns how many were frozen.
pub(crate) fn settle(bodies: &mut Bodies, starts: &[Quat], settings: &Settings) -> usize {
    let dt = 1.0 / settings.rate;
    let Bodies { roles, drifts, lines, positions, rotations, rests, states, radii, .. } = bodies;
    let (frames, moments, locks) = (&bodies.frames, &bodies.inverse_moments, &bodies.locks);
    let slender = (starts, frames, moments, locks);
    (positions, lines, rests, states, drifts, rotations, roles, radii, slender)
        .into_par_iter()
        .with_min_len(512)
        .shared()
        .map(
            |(position, line, rest, state, drift, rotation, role, radius, (start, frame, moments, locks))| {
                if *role == Role::Still {
                    return 0;
                }
                let (v, w) = (line.velocity(), line.angular_velocity());
                let sound = |x: Vec3| x.is_finite() && x.abs().max_element() < LIMIT;
                if !sound(v) || !sound(w) || !drift.translation().is_finite() || !rotation.is_finite() {
                    *state = State::Frozen;
                    line.set_velocities(Vec3::ZERO, Vec3::ZERO);
                    drift.0 = [0.0; 8];
                    return 1;
                }
                if *role == Role::Free
                    && locks >> 3 == 0
                    && let Some(axis) = long_axis(*moments)
                {
                    let [from, now] = [*start, *rotation].map(|rotation| attitude(rotation, *frame));
                    line.set_velocities(v, uncarried(w, axis, from, now));
                }
                *position += drift.translation().as_dvec3();
                let speed = v.length() + w.length() * *radius;
                *rest = if *role == Role::Free && speed < settings.sleep_speed { *rest + dt } else { 0.0 };
                0
            },
        )
        .sum()
}
