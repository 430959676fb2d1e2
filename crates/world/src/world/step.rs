//! `step()`: the table of contents of the engine.

use super::World;
use crate::apply::apply;
use crate::bodies::State;
use crate::bound::bound;
use crate::index::index;
use crate::link::link;
use crate::measure::measure;
use crate::pair::pair;
use crate::seam::Ground;
use crate::settle::settle;
use crate::sleep::sleep;
use crate::sweep::{Surroundings, sweep};
use crate::touch::{Changes, color, settle_in, touch};
use crate::{Integrator, Material, STAGES, Settings, Solver, StepReport};
use rayon::prelude::*;
use rockfall_math::Vec3;
use rockfall_math::share::{Share, alone};
use rockfall_solve::Surface;
use rockfall_solve::follow::follow;
use rockfall_solve::line::Role;
use rockfall_solve::respond::{Plan, impulse_step, reflect_step, soft_step};
use std::time::{Duration, Instant};

/// A world of no more rows is not worth waking other threads for: a step takes a tenth of a millisecond. Results don't depend on it.
const FEW: usize = 512;

impl World {
    /// Advances the world by one step of `1 / rate` seconds.
    pub fn step(&mut self) -> &StepReport {
        if self.pool.current_num_threads() == 1 || self.bodies.rows() <= FEW {
            alone(|| self.stages());
        } else {
            let pool = std::sync::Arc::clone(&self.pool);
            pool.install(|| self.stages());
        }
        &self.report
    }

    fn stages(&mut self) {
        self.late.take();
        self.drifted.take();
        let World { settings, width, shapes, materials, bodies, index: trees, touches, .. } = self;
        let World { islands, contacts, rooms, moved, starts, sums, report, .. } = self;
        let mut clock = Clock::new();

        let (fresh, stirred) = (self.fresh, &self.stirred);
        let turnover = apply(bodies, touches, contacts, fresh, stirred, report.step, settings.tiles_from);
        let renamed = if turnover.all { 1 } else { bodies.rows() - turnover.fresh };
        for (&slot, row) in bodies.slots.iter().zip(0..).skip(renamed) {
            self.rows[slot as usize] = row;
        }
        if renamed < bodies.rows() {
            self.sorted.take();
        }
        clock.lap();

        bound(bodies, shapes, settings, turnover, &self.stirred, moved);
        self.stirred.clear();
        self.fresh = 0;
        clock.lap();
        index(trees, bodies, moved, turnover);
        clock.lap();
        pair(touches, bodies, trees, moved);
        clock.lap();
        starts.clear();
        starts.par_extend(bodies.rotations.par_iter().shared());
        follow(contacts, &mut bodies.solver_columns(starts), *width);
        let material = |row: usize| &materials[bodies.materials[row] as usize];
        let surface = |a: usize, b: usize| surface(material(a), material(b));
        let ground = Ground { bodies, shapes, tree: &trees.fixed };
        let mut changes = touch(rooms, touches, contacts, ground, &surface, settings, *width);
        report.frozen += freeze(bodies, &Changes::broken(&changes));
        clock.lap();
        color(&mut changes, contacts, bodies.rows());
        clock.lap();
        settle_in(changes, touches, contacts);
        contacts.prepare(&bodies.lines);
        clock.lap();
        if settings.sleeping {
            link(islands, bodies, contacts);
        }
        clock.lap();
        let plan = plan(settings, report.step);
        let mut columns = bodies.solver_columns(starts);
        let [solve_time, bounce_time] = match settings.solver {
            Solver::SoftStep => soft_step(contacts, &mut columns, *width, &plan),
            Solver::Impulse => impulse_step(contacts, &mut columns, &plan),
            Solver::Reflect => reflect_step(contacts, &mut columns, &plan),
        };
        clock.add(solve_time);
        clock.add(bounce_time);
        report.frozen += settle(bodies, starts, settings);
        clock.lap();
        if settings.continuous {
            let fallen = match settings.integrator {
                Integrator::SemiImplicit => Vec3::ZERO,
                Integrator::SecondOrder => settings.gravity,
            };
            sweep(
                bodies,
                Surroundings { shapes, trees, starts },
                fallen,
                1.0 / settings.rate,
                report.step as u32,
            );
        }
        clock.lap();
        if settings.sleeping {
            sleep(bodies, islands, settings);
        }
        clock.lap();

        report.step += 1;
        report.time = report.step as f64 / f64::from(settings.rate);
        report.pairs = touches.pairs();
        report.colors = contacts.colors();
        report.split = contacts.split_bodies();
        report.serial = contacts.serial();
        measure(report, sums, bodies, contacts, settings, self.handled);
        self.handled = false;
        self.tell();
        clock.lap();
        self.report.times = clock.times();
    }
}

/// Freezes bodies whose contacts were not finite.
fn freeze(bodies: &mut crate::bodies::Bodies, rows: &[usize]) -> usize {
    let mut frozen = 0;
    for &row in rows {
        if bodies.states[row] != State::Frozen {
            bodies.states[row] = State::Frozen;
            bodies.roles[row] = Role::Still;
            bodies.lines[row].set_velocities(Vec3::ZERO, Vec3::ZERO);
            frozen += 1;
        }
    }
    frozen
}

/// How two materials rub and bounce.
fn surface(a: &Material, b: &Material) -> Surface {
    Surface {
        friction: a.friction_mix.mix(b.friction_mix, a.friction, b.friction),
        restitution: a.restitution_mix.mix(b.restitution_mix, a.restitution, b.restitution),
        rolling: a.rolling_friction.max(b.rolling_friction),
        twisting: a.twisting_friction.max(b.twisting_friction),
    }
}

fn plan(settings: &Settings, step: u64) -> Plan {
    Plan {
        step,
        dt: 1.0 / settings.rate,
        substeps: settings.substeps,
        gravity: settings.gravity,
        hertz: settings.contact_hertz,
        damping: settings.contact_damping,
        push_speed: settings.push_speed,
        restitution_threshold: settings.restitution_threshold,
        bounces: settings.bounce_sweeps,
        integrator: settings.integrator,
    }
}

/// Times the stages one after the other.
struct Clock {
    times: [Duration; STAGES.len()],
    next: usize,
    last: Instant,
}

impl Clock {
    fn new() -> Self {
        Clock { times: Default::default(), next: 0, last: Instant::now() }
    }

    /// The stage that ran since the last lap is over.
    fn lap(&mut self) {
        let now = Instant::now();
        self.note(now - self.last);
        self.last = now;
    }

    /// A stage that timed itself took `time`.
    fn add(&mut self, time: Duration) {
        self.note(time);
        self.last = Instant::now();
    }

    fn note(&mut self, time: Duration) {
        self.times[self.next] = time;
        self.next += 1;
    }

    fn times(&self) -> [Duration; STAGES.len()] {
        self.times
    }
}
