//! What a step has to say.

use std::time::Duration;

/// The stages of a step, in their order; the index into [`StepReport::times`].
pub const STAGES: [&str; 14] = [
    "apply", "bound", "index", "pair", "touch", "paint", "prepare", "link", "solve", "bounce", "settle",
    "sweep", "sleep", "report",
];

/// Figures of one step. Sums are over dynamic bodies.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StepReport {
    /// Steps done so far, this one included.
    pub step: u64,
    /// Simulated seconds so far.
    pub time: f64,
    /// Bodies in the world.
    pub bodies: usize,
    /// Dynamic bodies that are awake.
    pub awake: usize,
    /// Pairs of bodies whose fat boxes overlap.
    pub pairs: usize,
    /// Manifolds with a point that touches (signed distance ≤ 0).
    pub touching: usize,
    /// Manifolds, those within the speculative margin included.
    pub manifolds: usize,
    /// Contact points.
    pub contacts: usize,
    /// Colours in use.
    pub colors: usize,
    /// Bodies with so many contacts that they are split into copies for the solver.
    pub split: usize,
    /// Manifolds that found no colour and are solved one after the other, by one thread.
    pub serial: usize,
    /// Bytes of contacts that the solver goes over in a sweep; a step of n sub-steps has 2 n + 1 of them.
    pub swept_bytes: usize,
    /// Largest overlap of a contact point at the start of the step, metres, not negative.
    pub deepest_penetration: f32,
    /// Mean overlap of the overlapping contact points, metres.
    pub mean_penetration: f32,
    /// Overlap that 99 of 100 of them do not exceed, metres, to an eighth of it.
    pub p99_penetration: f32,
    /// J.
    pub kinetic_energy: f64,
    /// J; zero at the world's origin.
    pub potential_energy: f64,
    /// kg m/s.
    pub momentum: [f64; 3],
    /// About the world's origin, kg m²/s.
    pub angular_momentum: [f64; 3],
    /// Force of what contacts can't move on what they can, over the last sub-step, N: of floors, walls, driven bodies. The simple solvers keep
    /// no impulses, so that it is zero with them.
    pub support: [f64; 3],
    /// Gravity's force on all bodies that are awake, N.
    pub weight: [f64; 3],
    /// By how much the momentum that contacts gave to all bodies in the last sub-step differs from what `support` gave: a share of the momentum
    /// that they moved, and of a hundredth of all that there is. Contacts between bodies give none, but for rounding.
    pub momentum_error: f64,
    /// By how much the energy rose in the step, J, without work from outside; zero where it fell, where a driven body moved, or where the caller had
    /// changed something.
    pub energy_gain: f64,
    /// The largest friction of a contact over Coulomb's bound; at most 1.
    pub friction_use: f64,
    /// Bodies that were frozen because their state was not finite, so far.
    pub frozen: usize,
    /// Time of each stage; see [`STAGES`].
    pub times: [Duration; STAGES.len()],
}

/// What holds in each step, whatever the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Invariant {
    /// Contacts between bodies give no momentum to both together: [`StepReport::momentum_error`].
    Momentum,
    /// The energy does not rise without work: [`StepReport::energy_gain`].
    Energy,
    /// Friction stays within its cone: [`StepReport::friction_use`].
    Friction,
}

impl Invariant {
    /// All.
    pub const ALL: [Invariant; 3] = [Invariant::Momentum, Invariant::Energy, Invariant::Friction];

    /// As in files.
    pub fn name(self) -> &'static str {
        match self {
            Invariant::Momentum => "momentum",
            Invariant::Energy => "energy",
            Invariant::Friction => "friction",
        }
    }
}

/// What rounding may take of a balance: impulses of 6e-8 each, in heaps of a million contacts, with what splits and unites large bodies.
const MOMENTUM: f64 = 1e-3;

/// Pushing overlaps apart lifts bodies without asking what it costs: a hundredth of the kinetic energy, and two millimetres for all that there is, are
/// let pass.
const KINETIC: f64 = 0.01;
const LIFT: f64 = 2e-3;

/// The cone is kept by a square root and a division.
const CONE: f64 = 1.0 + 1e-5;

impl StepReport {
    /// By how much an invariant is off in this step, in its own unit: a share, J, a share.
    pub fn error_of(&self, invariant: Invariant) -> f64 {
        match invariant {
            Invariant::Momentum => self.momentum_error,
            Invariant::Energy => self.energy_gain,
            Invariant::Friction => self.friction_use,
        }
    }

    /// Whether this step broke an invariant by more than rounding, and than the soft position correction explains.
    pub fn breaks(&self, invariant: Invariant) -> bool {
        let weight = self.weight.iter().map(|f| f * f).sum::<f64>().sqrt();
        let most = match invariant {
            Invariant::Momentum => MOMENTUM,
            Invariant::Energy => KINETIC * self.kinetic_energy + LIFT * weight,
            Invariant::Friction => CONE,
        };
        self.error_of(invariant) > most
    }
}
