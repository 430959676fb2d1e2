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
    /// J.
    pub kinetic_energy: f64,
    /// J; zero at the world's origin.
    pub potential_energy: f64,
    /// kg m/s.
    pub momentum: [f64; 3],
    /// About the world's origin, kg m²/s.
    pub angular_momentum: [f64; 3],
    /// Bodies that were frozen because their state was not finite, so far.
    pub frozen: usize,
    /// Time of each stage; see [`STAGES`].
    pub times: [Duration; STAGES.len()],
}
