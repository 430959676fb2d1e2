//! Contacts of a pair that are found anew begin with impulses that do to both bodies what those of the old ones did.
//!
//! Reads the old contacts of a pair and the inertia of its bodies; writes impulses of the new ones.
//!
//! A name says which point goes on, not where the load of those goes that are gone. Curved bodies of many triangles touch at other corners and edges whenever they move by a fraction of a millimetre. A load that is lost
//! lets a body fall for a sub-step, by which it moves, and touches elsewhere again: of forty rings in a well, at four sub-steps, 0.03 J were never lost, and with this 1e-10 J are left after three seconds.
//!
//! What is looked for is the least difference from the old impulses in the velocities of both bodies, weighted by their masses. These are the equations of contacts that push and rub, and they are solved as the solver
//! does it, by sweeps over the points.

use crate::bodies::Bodies;
use rockfall_math::Vec3;
use rockfall_solve::line::Line;
use rockfall_solve::{Manifold, Memory};

/// Sweeps over the points of a pair. Three leave twice as much to be made good by the solver as ten, and thirty no less.
const SWEEPS: usize = 10;

/// A manifold that was found.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Heir {
    pub(crate) manifold: Manifold,
    pub(crate) memory: Memory,
    /// In whose place among the old ones it goes on.
    pub(crate) source: Option<usize>,
    /// Its number among all that were found of its pair.
    pub(crate) ordinal: u32,
}

/// The bodies of a pair.
pub(crate) struct Couple<'a> {
    lines: [&'a Line; 2],
    /// From the centre of mass of the first to that of the second, metres.
    offset: Vec3,
    /// Coulomb's coefficient.
    friction: f32,
}

/// By how much velocities differ, m/s and rad/s.
#[derive(Clone, Copy, Debug, Default)]
struct Gain {
    linear: [Vec3; 2],
    angular: [Vec3; 2],
}

impl<'a> Couple<'a> {
    pub(crate) fn new(bodies: &'a Bodies, rows: [usize; 2], offset: Vec3, friction: f32) -> Self {
        Couple { lines: rows.map(|row| &bodies.lines[row]), offset, friction }
    }

    /// Changes the impulses of what was found until they do what the old ones did, as nearly as pushes and friction can.
    pub(crate) fn inherit(&self, olds: &[(Manifold, Memory)], heirs: &mut [Heir]) {
        let mut left = Gain::default();
        olds.iter().for_each(|(manifold, memory)| self.add(&mut left, manifold, memory, 1.0));
        for Heir { manifold, memory, source, .. } in heirs.iter_mut() {
            if source.is_none() {
                // Another one has gone on with these.
                (memory.friction, memory.twist, memory.rolling) = (Vec3::ZERO, 0.0, Vec3::ZERO);
            }
            memory.friction -= memory.friction.dot(manifold.normal) * manifold.normal;
            self.add(&mut left, manifold, memory, -1.0);
        }
        for _ in 0..SWEEPS {
            for Heir { manifold, memory, .. } in heirs.iter_mut() {
                self.press(&mut left, manifold, memory);
                self.rub(&mut left, manifold, memory);
            }
        }
    }

    /// What an impulse on the second body, and against it on the first, at an arm from the first one's centre, makes of their velocities.
    fn push(&self, gain: &mut Gain, arm: Vec3, impulse: Vec3) {
        let sides = [(arm, -impulse), (arm - self.offset, impulse)];
        for (k, (arm, impulse)) in sides.into_iter().enumerate() {
            gain.linear[k] += self.lines[k].inverse_mass() * impulse;
            gain.angular[k] += self.lines[k].inverse_inertia() * arm.cross(impulse);
        }
    }

    /// Adds a share of what a manifold does.
    fn add(&self, gain: &mut Gain, manifold: &Manifold, memory: &Memory, share: f32) {
        for (&arm, normal) in manifold.arms.iter().zip(memory.normals).take(manifold.count as usize) {
            self.push(gain, arm, share * normal * manifold.normal);
        }
        self.push(gain, middle(manifold), share * memory.friction);
        let turn = share * (memory.twist * manifold.normal + memory.rolling);
        gain.angular[0] -= self.lines[0].inverse_inertia() * turn;
        gain.angular[1] += self.lines[1].inverse_inertia() * turn;
    }

    /// How fast the second body goes at a point, seen from the first.
    fn speed(&self, gain: &Gain, arm: Vec3) -> Vec3 {
        let [a, b] = gain.linear;
        let [turn_a, turn_b] = gain.angular;
        b + turn_b.cross(arm - self.offset) - a - turn_a.cross(arm)
    }

    /// The speed that an impulse of one along a direction makes along it, 1/kg.
    fn yielding(&self, arm: Vec3, along: Vec3) -> f32 {
        let mut gain = Gain::default();
        self.push(&mut gain, arm, along);
        self.speed(&gain, arm).dot(along)
    }

    fn press(&self, left: &mut Gain, manifold: &Manifold, memory: &mut Memory) {
        let normal = manifold.normal;
        for (&arm, old) in manifold.arms.iter().zip(&mut memory.normals).take(manifold.count as usize) {
            let wanted = self.speed(left, arm).dot(normal) / self.yielding(arm, normal);
            let new = (*old + wanted).max(0.0);
            if new.is_finite() {
                self.push(left, arm, (*old - new) * normal);
                *old = new;
            }
        }
    }

    fn rub(&self, left: &mut Gain, manifold: &Manifold, memory: &mut Memory) {
        let (at, normal) = (middle(manifold), manifold.normal);
        let speed = self.speed(left, at);
        let slip = speed - speed.dot(normal) * normal;
        let Some(along) = slip.try_normalize() else { return };
        let wanted = slip / self.yielding(at, along);
        let most = self.friction * memory.normals.iter().take(manifold.count as usize).sum::<f32>();
        let new = (memory.friction + wanted).clamp_length_max(most);
        if new.is_finite() {
            self.push(left, at, memory.friction - new);
            memory.friction = new;
        }
    }
}

/// Where friction acts, from the first body's centre.
fn middle(manifold: &Manifold) -> Vec3 {
    let points = &manifold.arms[..manifold.count as usize];
    points.iter().sum::<Vec3>() / points.len() as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::Mat3;

    /// A ball of 1 kg and 0.4 kg m² above one that can't be moved.
    fn lines() -> [Line; 2] {
        let mut ball = Line::default();
        ball.motion[6] = 1.0;
        ball.set_inverse_inertia(&Mat3::from_diagonal(Vec3::splat(2.5)));
        [ball, Line::default()]
    }

    fn couple(lines: &[Line; 2]) -> Couple<'_> {
        Couple { lines: lines.each_ref(), offset: Vec3::Z * -2.0, friction: 0.5 }
    }

    /// Downwards, at so many places, with one impulse for all.
    fn manifold(at: &[Vec3], impulse: f32) -> (Manifold, Memory) {
        let mut manifold = Manifold { normal: Vec3::NEG_Z, count: at.len() as u32, ..Manifold::default() };
        let mut memory = Memory::default();
        for (k, at) in at.iter().enumerate() {
            (manifold.arms[k], memory.normals[k]) = (*at, impulse);
        }
        (manifold, memory)
    }

    fn heir((manifold, memory): (Manifold, Memory), source: Option<usize>) -> Heir {
        Heir { manifold, memory, source, ordinal: 0 }
    }

    /// What is left to be made good.
    fn left(couple: &Couple<'_>, olds: &[(Manifold, Memory)], heirs: &[Heir]) -> f32 {
        let mut left = Gain::default();
        olds.iter().for_each(|(manifold, memory)| couple.add(&mut left, manifold, memory, 1.0));
        heirs.iter().for_each(|heir| couple.add(&mut left, &heir.manifold, &heir.memory, -1.0));
        let [v, w] = [left.linear[0].length(), left.angular[0].length()];
        v + w
    }

    #[test]
    fn two_points_bear_what_one_between_them_bore() {
        let lines = lines();
        let couple = couple(&lines);
        let at = |x: f32| Vec3::new(x, 0.0, -1.0);
        let olds = [manifold(&[at(0.1)], 3.0)];
        let mut heirs = [heir(manifold(&[at(-0.1), at(0.2)], 0.0), None)];
        couple.inherit(&olds, &mut heirs);
        // By the lever: 0.1 of 0.3 at the first, 0.2 at the second.
        let [first, second, ..] = heirs[0].memory.normals;
        assert!((first - 1.0).abs() < 0.05 && (second - 2.0).abs() < 0.05, "{first} {second}");
        assert!(left(&couple, &olds, &heirs) < 0.02);
    }

    #[test]
    fn friction_goes_on_elsewhere_within_its_cone() {
        let lines = lines();
        let couple = couple(&lines);
        let (bed, mut rubbing) = manifold(&[Vec3::NEG_Z], 2.0);
        rubbing.friction = Vec3::X;
        let olds = [(bed, rubbing)];
        // A wall beside which nothing goes on, and a bed that can't rub more than half of what it bears.
        let mut heirs = [heir(manifold(&[Vec3::NEG_Z], 0.0), None)];
        couple.inherit(&olds, &mut heirs);
        let Memory { normals, friction, .. } = heirs[0].memory;
        assert!((normals[0] - 2.0).abs() < 1e-4 && (friction - Vec3::X).length() < 1e-3, "{friction}");
        let slippery = Couple { friction: 0.1, ..couple };
        slippery.inherit(&olds, &mut heirs);
        assert!((heirs[0].memory.friction - 0.2 * Vec3::X).length() < 1e-3);
    }

    #[test]
    fn nothing_pulls_and_nothing_moves_what_is_immovable() {
        let lines = lines();
        let couple = couple(&lines);
        let olds = [manifold(&[Vec3::NEG_Z], 1.0)];
        // The only new point is on the other side: it would have to pull.
        let (mut above, memory) = manifold(&[Vec3::Z], 0.0);
        above.normal = Vec3::Z;
        let mut heirs = [heir((above, memory), Some(0))];
        couple.inherit(&olds, &mut heirs);
        assert_eq!(heirs[0].memory.normals[0], 0.0);
        let still = [Line::default(); 2];
        let mut heirs = [heir(manifold(&[Vec3::NEG_Z], 1.0), Some(0))];
        Couple { lines: still.each_ref(), ..couple }.inherit(&olds, &mut heirs);
        assert_eq!(heirs[0].memory.normals[0], 1.0);
    }
}
