//! Stage 14, **report**: figures of the step, and the hash.
//!
//! Reads everything, writes a [`StepReport`]. Sums are taken over runs of fixed length, in order, so that they don't
//! depend on the number of threads.

use crate::bodies::{Bodies, State};
use crate::{Kind, Settings, Solver, StepReport};
use rayon::prelude::*;
use rockfall_math::share::Share;
use rockfall_math::{DVec3, Mat3, rotation};
use rockfall_solve::Contacts;
use xxhash_rust::xxh3::xxh3_64;

/// Rows in a partial sum.
const RUN: usize = 1024;

/// Of a run of rows.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Sums {
    bodies: usize,
    awake: usize,
    kinetic: f64,
    potential: f64,
    momentum: DVec3,
    angular: DVec3,
    /// Gravity on those that are awake, N.
    weight: DVec3,
    /// Momentum that contacts gave to them in the last sub-step, and the sum of its lengths, N s.
    given: DVec3,
    moved: f64,
    /// Sum of the lengths of their momenta, N s.
    carried: f64,
    /// Bodies that move as they are told.
    driven: usize,
}

impl Sums {
    fn and(self, b: &Sums) -> Sums {
        Sums {
            bodies: self.bodies + b.bodies,
            awake: self.awake + b.awake,
            kinetic: self.kinetic + b.kinetic,
            potential: self.potential + b.potential,
            momentum: self.momentum + b.momentum,
            angular: self.angular + b.angular,
            weight: self.weight + b.weight,
            given: self.given + b.given,
            moved: self.moved + b.moved,
            carried: self.carried + b.carried,
            driven: self.driven + b.driven,
        }
    }

    /// Takes in the body in a row.
    fn add(&mut self, bodies: &Bodies, row: usize, gravity: DVec3) {
        if bodies.states[row] == State::Dead {
            return;
        }
        self.bodies += 1;
        if bodies.kinds[row] != Kind::Dynamic {
            let moves = bodies.lines[row].motion[..6].iter().any(|&x| x != 0.0);
            self.driven += usize::from(bodies.kinds[row] == Kind::Kinematic && moves);
            return;
        }
        let awake = bodies.states[row] == State::Awake;
        self.awake += usize::from(awake);
        let motion = motion(bodies, row);
        let Motion { mass, v, spin, .. } = motion;
        self.kinetic += motion.energy();
        self.potential -=
            mass * f64::from(bodies.lines[row].gravity_scale()) * gravity.dot(bodies.positions[row]);
        self.momentum += v * mass;
        if awake {
            let from = &bodies.references[row];
            // See `rockfall_solve::push`.
            let given = (v - DVec3::new(from[0].into(), from[1].into(), from[2].into())) * mass;
            self.weight += gravity * (mass * f64::from(bodies.lines[row].gravity_scale()));
            self.given += given;
            self.moved += given.length();
            self.carried += v.length() * mass;
        }
        self.angular += bodies.positions[row].cross(v * mass) + spin;
    }
}

/// Parts of the momentum at hand that supports are rounded to.
const PARTS: f64 = 1e12;

/// Fills in everything but times and counts that the caller knows. `sums` is room that is kept from step to step; `handled` tells whether the world
/// was changed from outside since the last one.
pub(crate) fn measure(
    report: &mut StepReport,
    sums: &mut Vec<Sums>,
    bodies: &Bodies,
    contacts: &Contacts,
    settings: &Settings,
    handled: bool,
) {
    let gravity = settings.gravity.as_dvec3();
    (0..bodies.rows().div_ceil(RUN))
        .into_par_iter()
        .shared()
        .map(|run| {
            let rows = (run * RUN).max(1)..((run + 1) * RUN).min(bodies.rows());
            let mut sums = Sums::default();
            rows.for_each(|row| sums.add(bodies, row, gravity));
            sums
        })
        .collect_into_vec(sums);
    let all = sums.iter().fold(Sums::default(), Sums::and);
    let energy = |report: &StepReport| report.kinetic_energy + report.potential_energy;
    let before = energy(report);
    let touch = contacts.tally();
    report.bodies = all.bodies;
    report.awake = all.awake;
    report.kinetic_energy = all.kinetic;
    report.potential_energy = all.potential;
    report.momentum = all.momentum.to_array();
    report.angular_momentum = all.angular.to_array();
    let watched = !handled && all.driven == 0;
    report.energy_gain = if watched { (energy(report) - before).max(0.0) } else { 0.0 };
    report.weight = all.weight.to_array();
    balance(report, &all, bodies, contacts, settings);
    report.swept_bytes = contacts.swept_bytes();
    report.manifolds = touch.manifolds;
    report.touching = touch.touching;
    report.contacts = touch.contacts;
    report.deepest_penetration = touch.deepest;
    report.p99_penetration = touch.percentile_99();
    report.mean_penetration = (1e-9 * touch.overlap as f64 / touch.overlapping.max(1) as f64) as f32;
}

/// What contacts gave in the last sub-step, beside what supports gave.
fn balance(report: &mut StepReport, all: &Sums, bodies: &Bodies, contacts: &Contacts, settings: &Settings) {
    (report.support, report.momentum_error, report.friction_use) = ([0.0; 3], 0.0, 0.0);
    if settings.solver != Solver::SoftStep {
        return;
    }
    let moved = all.moved + 0.01 * all.carried;
    let unit = if moved > 0.0 { moved / PARTS } else { 1.0 };
    let awake = |row: u32| bodies.states[row as usize] == State::Awake;
    let forces = contacts.forces(unit, awake);
    let support = forces.support(unit);
    let rate = f64::from(settings.rate) * f64::from(settings.substeps);
    report.support = (support * rate).to_array();
    report.momentum_error = if moved > 0.0 { (all.given - support).length() / moved } else { 0.0 };
    report.friction_use = forces.friction();
}

/// How a dynamic body moves.
struct Motion {
    /// kg.
    mass: f64,
    /// m/s.
    v: DVec3,
    /// rad/s.
    turning: DVec3,
    /// Angular momentum about the centre of mass, kg m²/s.
    spin: DVec3,
}

impl Motion {
    /// Joule.
    fn energy(&self) -> f64 {
        0.5 * (self.mass * self.v.length_squared() + self.turning.dot(self.spin))
    }
}

#[inline]
fn motion(bodies: &Bodies, row: usize) -> Motion {
    let line = &bodies.lines[row];
    let mass = 1.0 / f64::from(line.inverse_mass());
    let v = line.velocity().as_dvec3();
    let moments = bodies.inverse_moments[row].as_dvec3().map(|x| if x > 0.0 { 1.0 / x } else { 0.0 });
    let turning = line.angular_velocity().as_dvec3();
    let spin = if moments.x == moments.y && moments.y == moments.z {
        turning * moments.x
    } else {
        let axes = Mat3::from_quat(rotation::compose(bodies.rotations[row], bodies.frames[row])).as_dmat3();
        axes * (axes.transpose() * turning * moments)
    };
    Motion { mass, v, turning, spin }
}

/// The kinetic energy of a dynamic body, J.
pub(crate) fn kinetic(bodies: &Bodies, row: usize) -> f64 {
    motion(bodies, row).energy()
}

/// Bytes of a body that its hash is of.
const HASHED: usize = 72;

/// Equal for equal states: the sum, modulo 2⁶⁴, over all bodies of XXH3 of what [`hashed`] says of each. A sum knows no order, so that all threads
/// share it.
pub(crate) fn hash(bodies: &Bodies) -> u64 {
    let one = |row: usize| if bodies.states[row] == State::Dead { 0 } else { xxh3_64(&hashed(bodies, row)) };
    (1..bodies.rows()).into_par_iter().with_min_len(1024).map(one).reduce(|| 0, u64::wrapping_add)
}

/// The id (8 bytes), the centre of mass (three of 8), the rotation x, y, z, w, the linear and the angular velocity (of 4 each), lowest byte first.
fn hashed(bodies: &Bodies, row: usize) -> [u8; HASHED] {
    let (q, [vx, vy, vz, wx, wy, wz, ..]) = (bodies.rotations[row], bodies.lines[row].motion);
    let mut bytes = [0; HASHED];
    let (wide, narrow) = bytes.split_at_mut(32);
    let [x, y, z] = bodies.positions[row].to_array().map(f64::to_bits);
    for (to, word) in wide.as_chunks_mut().0.iter_mut().zip([bodies.ids[row], x, y, z]) {
        *to = word.to_le_bytes();
    }
    let floats = [q.x, q.y, q.z, q.w, vx, vy, vz, wx, wy, wz];
    for (to, float) in narrow.as_chunks_mut().0.iter_mut().zip(floats) {
        *to = float.to_le_bytes();
    }
    bytes
}
