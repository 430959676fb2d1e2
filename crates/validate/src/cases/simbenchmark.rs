//! SimBenchmark of ETH Zürich (Kang and Hwangbo 2018), which compares RaiSim, Bullet, ODE, MuJoCo and DART. Published figures are the
//! rows of its data files with default solvers and without position correction ("erp0"), on an i7-7700HQ.

mod bouncing;
mod cost;
mod elastic;
mod pile;
mod rolling;
mod sweep;

use crate::Error;
use crate::case::Case;
use crate::engine::{Surface, Terms};
use crate::stage::{Rig, Stage};

pub(super) const CASES: [Case; 6] =
    [rolling::CASES[0], rolling::CASES[1], bouncing::CASE, pile::CASE, elastic::CASE, cost::CASE];

/// Name of the group.
const GROUP: &str = "simbenchmark";

/// The balls of "elastic 666" before they fall.
pub(super) fn elastic_lattice(rig: &Rig, terms: Terms) -> Result<Stage, Error> {
    pile::lattice(rig, terms, Surface::new(0.0, 1.0), 1.101)
}
