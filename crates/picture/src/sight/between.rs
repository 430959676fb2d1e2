//! Moments between two that are known.

use super::{Seen, Sight};
use rockfall_math::{Pose, Quat, rotation};

impl Sight {
    /// The bodies of this moment where they were at a share of the time since `before`, 0 being then and 1 now: on the straight way, and by the shorter turn. Those that were not there
    /// yet are where they are now.
    pub fn since(&self, before: &Sight, share: f64) -> Sight {
        let moved = |body: &Seen| {
            let Some(row) = before.row(body.id) else { return *body };
            let then = &before.bodies[row];
            let pose = between(&then.pose, &body.pose, share);
            Seen { pose, center: then.center.lerp(body.center, share), ..*body }
        };
        Sight {
            time: before.time + share * (self.time - before.time),
            bodies: self.bodies.iter().map(moved).collect(),
            ..self.clone()
        }
    }
}

/// A pose between two. The mean of two quaternions, made a unit again, turns as evenly as a picture can show: between frames bodies turn by little.
fn between(a: &Pose, b: &Pose, share: f64) -> Pose {
    let [p, q] = [a.rotation, b.rotation].map(|q| q.to_array());
    let same = p.iter().zip(&q).map(|(p, q)| p * q).sum::<f32>() >= 0.0;
    let share_now = share as f32;
    let mix = |k: usize| (1.0 - share_now) * p[k] + if same { share_now } else { -share_now } * q[k];
    let rotation = rotation::normalize(Quat::from_xyzw(mix(0), mix(1), mix(2), mix(3)));
    Pose { position: a.position.lerp(b.position, share), rotation }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::{DVec3, Vec3};

    #[test]
    fn half_way_is_half_the_way_and_half_the_turn() {
        let a = Pose { position: DVec3::new(1.0, 0.0, 0.0), rotation: Quat::IDENTITY };
        let turn = rotation::from_rotation_vector(Vec3::new(0.0, 0.0, 0.6));
        // The same turn with the other sign.
        for rotation in [turn, Quat::from_xyzw(-turn.x, -turn.y, -turn.z, -turn.w)] {
            let half = between(&a, &Pose { position: DVec3::new(3.0, 2.0, 0.0), rotation }, 0.5);
            assert_eq!(half.position, DVec3::new(2.0, 1.0, 0.0));
            let way = rotation::to_rotation_vector(half.rotation);
            assert!((way - Vec3::new(0.0, 0.0, 0.3)).length() < 1e-6, "{way}");
        }
    }
}
