//! Contacts of a pair that are found anew take over what those of the old ones bore that are gone.
//!
//! Reads the old contacts of a pair and the inertia of its bodies; writes impulses of the new ones.
//!
//! A name says which point goes on, not where the load of those goes that are gone. Curved bodies of many triangles touch at other corners and edges whenever they move by a fraction of a millimetre. A load that is lost
//! lets a body fall for a sub-step, by which it moves, and touches elsewhere again: heaps of rings never came to rest, and do with this.
//!
//! Each lost impulse is taken to act at the nearest new point, and the new impulses are those that differ least from that in the velocities of both bodies, weighted by their masses. These are the equations of contacts that push
//! and rub, and they are solved as the solver does it, by sweeps over the points.
//!
//! What moves takes less over, or nothing: a contact that rolls on turns with the surfaces, and a load that keeps its direction for another step feeds a swing. A chain of ten rings swung at 0.4 m/s with it.

use crate::Shape;
use crate::ahead::{may_hang, passing_speed};
use crate::bodies::Bodies;
use rockfall_math::Vec3;
use rockfall_solve::line::Line;
use rockfall_solve::{Manifold, Memory};

/// Sweeps over the points of a pair.
const SWEEPS: usize = 10;

/// Bodies of which a point goes by the other one in a step by no more than this share of the size that their contacts are measured by take all over, those that go by twice as much nothing.
const CALM: f32 = 0.02;

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

/// Which share of what is lost the new contacts of a pair take over, in a step of `dt` seconds: only bodies that may be concave have contacts that come and go like that.
pub(crate) fn portion(bodies: &Bodies, rows: [usize; 2], shapes: [&Shape; 2], dt: f32) -> f32 {
    if !shapes.into_iter().any(may_hang) {
        return 0.0;
    }
    let scales = shapes.into_iter().map(Shape::contact_scale).filter(|&scale| scale > 0.0);
    let most = CALM * scales.fold(f32::INFINITY, f32::min);
    (2.0 - dt * passing_speed(bodies, rows) / most).clamp(0.0, 1.0)
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
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Gain {
    linear: [Vec3; 2],
    angular: [Vec3; 2],
}

impl<'a> Couple<'a> {
    pub(crate) fn new(bodies: &'a Bodies, rows: [usize; 2], offset: Vec3, friction: f32) -> Self {
        Couple { lines: rows.map(|row| &bodies.lines[row]), offset, friction }
    }

    /// Hands over a share of what [`recognise`](crate::recognise) has left of the impulses of `olds`: those of points that are gone, and friction of manifolds that don't go on.
    pub(crate) fn inherit(&self, share: f32, olds: &[(Manifold, Memory)], heirs: &mut [Heir]) {
        let mut left = Gain::default();
        for (old, (manifold, memory)) in olds.iter().enumerate() {
            for (&arm, &normal) in manifold.arms.iter().zip(&memory.normals).take(manifold.count as usize) {
                if normal > 0.0 {
                    let points = heirs.iter().flat_map(|heir| points(&heir.manifold));
                    self.push(&mut left, nearest(arm, points), share * normal * manifold.normal);
                }
            }
            if !heirs.iter().any(|heir| heir.source == Some(old)) {
                let middles = heirs.iter().map(|heir| middle(&heir.manifold));
                self.push(&mut left, nearest(middle(manifold), middles), share * memory.friction);
            }
        }
        if left == Gain::default() {
            return;
        }
        for Heir { manifold, memory, source, .. } in heirs.iter_mut() {
            if source.is_none() {
                // Another one has gone on with these.
                (memory.friction, memory.twist, memory.rolling) = (Vec3::ZERO, 0.0, Vec3::ZERO);
            }
            memory.friction -= memory.friction.dot(manifold.normal) * manifold.normal;
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

fn points(manifold: &Manifold) -> impl Iterator<Item = Vec3> {
    manifold.arms.into_iter().take(manifold.count as usize)
}

/// The nearest of some places, or the place itself where there is none.
fn nearest(to: Vec3, places: impl Iterator<Item = Vec3>) -> Vec3 {
    places.min_by(|a, b| a.distance_squared(to).total_cmp(&b.distance_squared(to))).unwrap_or(to)
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

    /// Velocities of the ball that the new contacts give it.
    fn given(couple: &Couple<'_>, heirs: &[Heir]) -> [Vec3; 2] {
        let mut gain = Gain::default();
        for Heir { manifold, memory, .. } in heirs {
            points(manifold)
                .zip(memory.normals)
                .for_each(|(arm, normal)| couple.push(&mut gain, arm, normal * manifold.normal));
            couple.push(&mut gain, middle(manifold), memory.friction);
        }
        [gain.linear[0], gain.angular[0]]
    }

    #[test]
    fn what_is_lost_acts_where_the_nearest_point_is() {
        let lines = lines();
        let couple = couple(&lines);
        let at = |y: f32| Vec3::new(0.0, y, -1.0);
        // The point at 0.3 is gone; that at -0.2 goes on with what it had.
        let lost = [manifold(&[at(0.3)], 3.0)];
        let mut kept = manifold(&[at(-0.2), at(0.25), at(0.1)], 0.0);
        kept.1.normals[0] = 1.0;
        for share in [1.0, 0.5] {
            let mut heirs = [heir(kept, Some(0))];
            couple.inherit(share, &lost, &mut heirs);
            let [v, w] = given(&couple, &heirs);
            let (up, turned) = (1.0 + 3.0 * share, 2.5 * (3.0 * share * 0.25 - 0.2));
            // Ten sweeps leave some percent.
            assert!((v - up * Vec3::Z).length() < 0.1 * up, "{v}, wanted {up}");
            assert!((w - turned * Vec3::X).length() < 0.1 * up, "{w}, wanted {turned}");
        }
    }

    #[test]
    fn what_goes_on_by_name_is_left_alone() {
        let lines = lines();
        let taken = manifold(&[Vec3::NEG_Z], 0.0);
        let known = heir(manifold(&[Vec3::new(0.3, 0.2, -1.0), Vec3::NEG_Z], 2.0), Some(0));
        let mut heirs = [known];
        couple(&lines).inherit(1.0, &[taken], &mut heirs);
        assert_eq!((heirs[0].memory, heirs[0].source), (known.memory, known.source));
    }

    #[test]
    fn friction_goes_on_elsewhere_within_its_cone() {
        let lines = lines();
        let (bed, mut rubbing) = manifold(&[Vec3::NEG_Z], 2.0);
        rubbing.friction = Vec3::X;
        // Not that bed, but a new one at its place.
        let mut heirs = [heir(manifold(&[Vec3::NEG_Z], 0.0), None)];
        couple(&lines).inherit(1.0, &[(bed, rubbing)], &mut heirs);
        let Memory { normals, friction, .. } = heirs[0].memory;
        assert!((normals[0] - 2.0).abs() < 1e-4 && (friction - Vec3::X).length() < 1e-3, "{friction}");
        let mut heirs = [heir(manifold(&[Vec3::NEG_Z], 0.0), None)];
        Couple { friction: 0.1, ..couple(&lines) }.inherit(1.0, &[(bed, rubbing)], &mut heirs);
        assert!((heirs[0].memory.friction - 0.2 * Vec3::X).length() < 1e-3);
    }

    #[test]
    fn nothing_pulls_and_nothing_moves_what_is_immovable() {
        let lines = lines();
        let lost = [manifold(&[Vec3::NEG_Z], 1.0)];
        // The only new point is on the other side: it would have to pull.
        let (mut above, memory) = manifold(&[Vec3::Z], 0.0);
        above.normal = Vec3::Z;
        let mut heirs = [heir((above, memory), Some(0))];
        couple(&lines).inherit(1.0, &lost, &mut heirs);
        assert_eq!(heirs[0].memory.normals[0], 0.0);
        let still = [Line::default(); 2];
        let mut heirs = [heir(manifold(&[Vec3::NEG_Z], 1.0), Some(0))];
        Couple { lines: still.each_ref(), ..couple(&lines) }.inherit(1.0, &lost, &mut heirs);
        assert_eq!(heirs[0].memory.normals[0], 1.0);
    }
}
