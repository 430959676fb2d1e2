//! What holds for the whole world.

use rockfall_math::Vec3;
use rockfall_solve::WORTH_TILES;
pub use rockfall_solve::drift::Integrator;

/// How contacts are answered.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Solver {
    /// Sub-stepped soft contacts with warm starting: the default, and the one that carries large piles.
    #[default]
    SoftStep,
    /// The report's response B: one impulse per contact point from K, restitution and friction.
    Impulse,
    /// The report's response A: the velocity is mirrored at the normal, without friction.
    Reflect,
}

/// Accuracy against speed, in one word.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// Two sub-steps: for looking at.
    Draft,
    /// Four.
    #[default]
    Default,
    /// Eight, contacts twice as stiff, free flight of second order, and restitution until it is done.
    Fine,
}

/// Settings of a [`World`](crate::World).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// m/s², in the world's frame. z is up.
    pub gravity: Vec3,
    /// Steps per second; a step is one frame.
    pub rate: f32,
    /// Sub-steps in a step, at least 1.
    pub substeps: u32,
    /// How contacts are answered.
    pub solver: Solver,
    /// How positions follow from velocities in free flight. Of second order, velocities gather no rounding either, with any solver; positions of the
    /// simple solvers are semi-implicit all the same.
    pub integrator: Integrator,
    /// Natural frequency of the soft position correction, Hz; never used above a quarter of the sub-step rate.
    pub contact_hertz: f32,
    /// Damping ratio of the soft position correction. Larger is slower; and the less of an impulse leaks with it in a
    /// sub-step, the farther do the impulses of a manifold's points wander from each other, and with them the bodies.
    pub contact_damping: f32,
    /// The fastest that an overlap is pushed apart, m/s.
    pub push_speed: f32,
    /// Restitution acts on contacts that close faster than this, m/s.
    pub restitution_threshold: f32,
    /// Sweeps of restitution, at most; it ends earlier where nothing bounces any more. One is enough for bodies that hit one by one. A heap of
    /// elastic bodies that hits the ground keeps its energy with some forty, and takes three to seven times as long for it as for all sub-steps while it
    /// bounces.
    pub bounce_sweeps: u32,
    /// Bodies at rest fall asleep.
    pub sleeping: bool,
    /// A body is at rest when no point of it moves faster than this, m/s.
    pub sleep_speed: f32,
    /// An island sleeps when all of it has been at rest for so long, s.
    pub sleep_time: f32,
    /// Bodies that move through more than half of their inner radius in a step are stopped at what they would pass
    /// through.
    pub continuous: bool,
    /// Pairs that have hardly moved relative to each other are not looked at again: those that are apart still are, and contacts follow their
    /// bodies. Much slower without, and hardly different: a switch to see by how much.
    pub reuse: bool,
    /// From so many bodies that move on, neighbours are solved in tiles that fit a cache, contacts between tiles after those within. It is
    /// another order of the same contacts; see by how little it matters.
    pub tiles_from: usize,
    /// Threads, 0 for as many as the machine has. Never changes a result.
    pub threads: usize,
    /// SIMD lanes, 1, 4, 8 or 16 but no more than the machine has, 0 for as many. Never changes a result.
    pub lanes: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            gravity: Vec3::new(0.0, 0.0, -9.81),
            rate: 60.0,
            substeps: 4,
            solver: Solver::SoftStep,
            integrator: Integrator::SemiImplicit,
            contact_hertz: 60.0,
            contact_damping: 0.5,
            push_speed: 3.0,
            restitution_threshold: 1.0,
            bounce_sweeps: 1,
            sleeping: true,
            sleep_speed: 0.05,
            sleep_time: 0.5,
            continuous: true,
            reuse: true,
            tiles_from: WORTH_TILES,
            threads: 0,
            lanes: 0,
        }
    }
}

impl Settings {
    /// The defaults at a quality: sub-steps, stiffness of contacts, integrator, sweeps of restitution. `docs/validation.md` has what each buys and
    /// costs, by `rockfall validate --only quality`.
    pub fn of(quality: Quality) -> Self {
        let default = Settings::default();
        match quality {
            Quality::Draft => Settings { substeps: 2, ..default },
            Quality::Default => default,
            Quality::Fine => Settings {
                substeps: 8,
                contact_hertz: 120.0,
                bounce_sweeps: 64,
                integrator: Integrator::SecondOrder,
                ..default
            },
        }
    }
}
