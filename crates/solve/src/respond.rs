//! Stages 9 and 10: collision response, sub-step by sub-step, for each of the three solvers.

use crate::advance::{Stay, advance};
use crate::block::{Block, LANES, get3};
use crate::bounce::bounce;
use crate::contacts::Contacts;
use crate::drift::{Integrator, Transform};
use crate::impulse::{contact_matrix, response};
use crate::iterate::{relax, solve};
use crate::line::{Columns, Drift, Line};
use crate::plan::Span;
use crate::push::Push;
use crate::reflect::reflect_pair;
use crate::retrace::Starts;
use crate::soft::{Softness, SubStep};
use crate::sweep::{Beside, Rows, Visit, sweep};
use crate::warm::warm;
use rockfall_math::lanes::{Lanes, Width};
use rockfall_math::{Mat3, Vec3};
use std::time::{Duration, Instant};

/// What the solvers are told of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Length of the step, s.
    pub dt: f32,
    /// Sub-steps, at least 1.
    pub substeps: u32,
    /// m/s².
    pub gravity: Vec3,
    /// Natural frequency of the position correction, Hz.
    pub hertz: f32,
    /// Its damping ratio.
    pub damping: f32,
    /// Fastest correction of an overlap, m/s.
    pub push_speed: f32,
    /// Contacts that close faster than this bounce, m/s.
    pub restitution_threshold: f32,
    /// Sweeps of restitution, at most.
    pub bounces: u32,
    /// How positions follow from velocities in free flight.
    pub integrator: Integrator,
    /// Number of the step, from any start.
    pub step: u64,
}

impl Plan {
    /// Length of a sub-step, s.
    pub fn h(&self) -> f32 {
        self.dt / self.substeps as f32
    }

    /// Pushes before sub-step `i`, with so many in each. The count may start again: it matters from one push to the next only.
    fn pushes(&self, i: u32, each: u32) -> u32 {
        let substeps = self.step.wrapping_mul(u64::from(self.substeps)).wrapping_add(u64::from(i));
        (substeps.wrapping_mul(u64::from(each)) % (1 << 20)) as u32
    }
}

/// The default solver: in each sub-step push, (warm,) solve, drift, relax; restitution once at the end. Returns the time
/// that went into the sub-steps and into restitution.
pub fn soft_step(
    contacts: &mut Contacts,
    columns: &mut Columns<'_>,
    width: Width,
    plan: &Plan,
) -> [Duration; 2] {
    let start = Instant::now();
    let h = plan.h();
    // A spring faster than a quarter of the sub-steps would overshoot.
    let hertz = plan.hertz.min(0.25 / h);
    let step = SubStep {
        h,
        push_speed: plan.push_speed,
        two_sided: Softness::new(hertz, plan.damping, h),
        one_sided: Softness::new(2.0 * hertz, plan.damping, h),
    };
    let transform = Transform::new(h, plan.gravity, plan.integrator);
    let exact = plan.integrator == Integrator::SecondOrder;
    contacts.clear_totals();
    let starts = Starts::new(contacts, columns, plan);
    for i in 0..plan.substeps {
        let push = Push { gravity: plan.gravity, h, first: i == 0, count: plan.pushes(i, 1), exact };
        if push.first {
            warm(contacts, columns, width, &push);
            solve(contacts, columns, width, &Stay, &step);
        } else {
            solve(contacts, columns, width, &push, &step);
        }
        relax(contacts, columns, width, &transform, &step);
        // The last one's impulses are those after the bounce.
        if i + 1 < plan.substeps {
            contacts.add_up();
        }
    }
    let solved = Instant::now();
    bounce(contacts, columns, width, plan, starts.is_some());
    if let Some(starts) = starts {
        starts.retrace(contacts, columns, width, plan);
    }
    contacts.add_up();
    [solved - start, solved.elapsed()]
}

/// Sweeps over the contacts in a sub-step of the two simple solvers.
const ITERATIONS: u32 = 4;

/// Share of an overlap that a sub-step of the two simple solvers takes away.
const SEPARATION: f32 = 0.3;

/// The report's response B on every contact point: each sub-step is transformation over time, impulses, separation.
pub fn impulse_step(contacts: &mut Contacts, columns: &mut Columns<'_>, plan: &Plan) -> [Duration; 2] {
    simple_step(contacts, columns, plan, &RespondImpulse)
}

/// The report's response A on every contact point. An object slower than gravity makes it in two sub-steps is stopped.
pub fn reflect_step(contacts: &mut Contacts, columns: &mut Columns<'_>, plan: &Plan) -> [Duration; 2] {
    let rest_speed = 2.0 * plan.gravity.length() * plan.h();
    simple_step(contacts, columns, plan, &RespondReflect { rest_speed })
}

fn simple_step<R: Respond>(
    contacts: &mut Contacts,
    columns: &mut Columns<'_>,
    plan: &Plan,
    respond: &R,
) -> [Duration; 2] {
    let start = Instant::now();
    // Half of gravity before the response and half after it: so the velocities that respond belong to the same time as the
    // places, and a perfectly elastic bounce neither gains nor loses height (see `bounce`).
    let half = Push {
        gravity: plan.gravity,
        h: 0.5 * plan.h(),
        first: false,
        count: 0,
        exact: plan.integrator == Integrator::SecondOrder,
    };
    let transform = Transform::new(plan.h(), plan.gravity, Integrator::SemiImplicit);
    for i in 0..plan.substeps {
        let count = plan.pushes(i, 2);
        advance(columns, &Push { first: i == 0, count, ..half });
        forget(columns);
        for iteration in 0..ITERATIONS {
            let visit = Simple { respond, separate: iteration == 0 };
            sweep(contacts, columns, Width::Scalar, &Stay, &visit);
        }
        forget(columns);
        advance(columns, &Push { count: count + 1, ..half });
        advance(columns, &transform);
        forget(columns);
    }
    [start.elapsed(), Duration::ZERO]
}

/// No warm start: what contacts gave is not given again, and velocities go on from where they are.
fn forget(columns: &mut Columns<'_>) {
    for (reference, line) in columns.references.iter_mut().zip(columns.lines.iter()) {
        *reference = line.motion;
    }
}

/// A contact point that touches, one body hitting another.
struct Touch {
    /// From the centres of mass, metres.
    arms: [Vec3; 2],
    /// Out of the body that was hit, the second one.
    n: Vec3,
    friction: f32,
    restitution: f32,
}

/// Changes the velocities of the bodies at one contact point.
trait Respond: Sync {
    fn respond(&self, touch: &Touch, a: &mut Line, b: &mut Line);
}

struct RespondImpulse;

impl Respond for RespondImpulse {
    fn respond(&self, touch: &Touch, a: &mut Line, b: &mut Line) {
        let [ra, rb] = touch.arms;
        let k = matrix(a, ra) + matrix(b, rb);
        let v = point_velocity(a, ra) - point_velocity(b, rb);
        if let Some(j) = response(&k, v, touch.n, touch.restitution, touch.friction) {
            apply(a, ra, j);
            apply(b, rb, -j);
        }
    }
}

struct RespondReflect {
    rest_speed: f32,
}

impl Respond for RespondReflect {
    fn respond(&self, touch: &Touch, a: &mut Line, b: &mut Line) {
        let masses = [a.inverse_mass(), b.inverse_mass()];
        let (v_a, v_b) = reflect_pair(a.velocity(), b.velocity(), masses, touch.n);
        for (line, v) in [(a, v_a), (b, v_b)] {
            if line.inverse_mass() == 0.0 {
                continue;
            }
            if v.length() < self.rest_speed {
                line.set_velocities(Vec3::ZERO, Vec3::ZERO);
            } else {
                line.set_velocities(v, line.angular_velocity());
            }
        }
    }
}

fn matrix(line: &Line, arm: Vec3) -> Mat3 {
    if line.inverse_mass() > 0.0 {
        contact_matrix(line.inverse_mass(), &line.inverse_inertia(), arm)
    } else {
        Mat3::ZERO
    }
}

fn point_velocity(line: &Line, arm: Vec3) -> Vec3 {
    line.velocity() + line.angular_velocity().cross(arm)
}

/// Step 4 of the report: v ← v + j / M, ω ← ω + I⁻¹ (R r × j).
fn apply(line: &mut Line, arm: Vec3, j: Vec3) {
    let v = line.velocity() + j * line.inverse_mass();
    let w = line.angular_velocity() + line.inverse_inertia() * arm.cross(j);
    line.set_velocities(v, w);
}

/// Response and separation at every point that touches, one lane after the other.
struct Simple<'a, R> {
    respond: &'a R,
    separate: bool,
}

impl<R: Respond> Visit for Simple<'_, R> {
    #[inline(always)]
    fn visit<L: Lanes, const P: usize, const T: usize>(
        &self,
        _: L::Token,
        rows: &Rows<'_>,
        block: &mut Block<P, T>,
        Beside { cold, .. }: Beside<'_>,
        k: usize,
        &Span { one_sided, .. }: &Span,
    ) {
        for lane in k..(k + L::WIDTH).min(LANES) {
            if block.a[lane] != 0 {
                let restitution = cold.as_deref().map_or(0.0, |cold| cold.restitution[lane]);
                self.lane(rows, block, lane, restitution, one_sided);
            }
        }
    }
}

impl<R: Respond> Simple<'_, R> {
    fn lane<const P: usize, const T: usize>(
        &self,
        rows: &Rows<'_>,
        block: &Block<P, T>,
        lane: usize,
        restitution: f32,
        one_sided: bool,
    ) {
        let (row_a, row_b) = (block.a[lane] as usize, block.b[lane] as usize);
        let (n, offset) = (get3(&block.normal, lane), get3(&block.offset, lane));
        // SAFETY: within a layer no two lanes and no two threads hold the same movable body, and bodies that can't be
        // moved are only read.
        let (mut a, mut b) = unsafe { (*rows.lines.get(row_a), *rows.lines.get(row_b)) };
        // SAFETY: as above.
        let (mut drift_a, mut drift_b) = unsafe { (*rows.drifts.get(row_a), *rows.drifts.get(row_b)) };
        if one_sided {
            (b.motion[6], b.inertia) = (0.0, [0.0; 8]);
        }
        for p in 0..P {
            if block.masses[p][lane] == 0.0 {
                continue;
            }
            let arm_a = get3(&block.arms[p], lane);
            let arm_b = arm_a - offset;
            let moved = |d: &Drift, arm: Vec3| d.translation() + d.rotation().cross(arm);
            let distance = block.distances[p][lane] + n.dot(moved(&drift_b, arm_b) - moved(&drift_a, arm_a));
            if distance > 0.0 {
                continue;
            }
            let touch = Touch { arms: [arm_a, arm_b], n: -n, friction: block.friction[lane], restitution };
            self.respond.respond(&touch, &mut a, &mut b);
            if self.separate {
                let way = n * (SEPARATION * distance / (a.inverse_mass() + b.inverse_mass()));
                drift_a.set(drift_a.translation() + way * a.inverse_mass(), drift_a.rotation());
                drift_b.set(drift_b.translation() - way * b.inverse_mass(), drift_b.rotation());
            }
        }
        // SAFETY: as above.
        unsafe {
            rows.lines.row(row_a).motion = a.motion;
            *rows.drifts.row(row_a) = drift_a;
            if !one_sided {
                rows.lines.row(row_b).motion = b.motion;
                *rows.drifts.row(row_b) = drift_b;
            }
        }
    }
}
