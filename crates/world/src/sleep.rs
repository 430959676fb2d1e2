//! Stage 13, **sleep**: islands at rest stop, and wake as one.
//!
//! Reads islands and times at rest; writes states. The least rested body of an island speaks for all of it.

use crate::bodies::{Bodies, State};
use crate::link::Islands;
use crate::{Kind, Settings};
use rayon::prelude::*;
use rockfall_math::Vec3;
use rockfall_math::share::Share;
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// Puts islands to sleep that have been at rest for long enough, and wakes the others.
pub(crate) fn sleep(bodies: &mut Bodies, islands: &Islands, settings: &Settings) {
    let rows = bodies.rows();
    // Times are not negative, so that their bits order as they do.
    let least: Vec<AtomicU32> = (0..rows).map(|_| AtomicU32::new(f32::INFINITY.to_bits())).collect();
    let sleeps = |row: usize| {
        bodies.kinds[row] == Kind::Dynamic && matches!(bodies.states[row], State::Awake | State::Asleep)
    };
    (1..rows).into_par_iter().with_min_len(1024).shared().filter(|&row| sleeps(row)).for_each(|row| {
        least[islands.root(row as u32) as usize].fetch_min(bodies.rests[row].to_bits(), Relaxed);
    });
    let new: Vec<State> = (0..rows)
        .into_par_iter()
        .with_min_len(1024)
        .shared()
        .map(|row| {
            if !sleeps(row) {
                return bodies.states[row];
            }
            let rest = f32::from_bits(least[islands.root(row as u32) as usize].load(Relaxed));
            if rest >= settings.sleep_time { State::Asleep } else { State::Awake }
        })
        .collect();
    for (row, state) in new.into_iter().enumerate() {
        if state == State::Asleep {
            bodies.lines[row].set_velocities(Vec3::ZERO, Vec3::ZERO);
        } else if bodies.states[row] == State::Asleep {
            bodies.rests[row] = 0.0;
        }
        bodies.states[row] = state;
    }
}
