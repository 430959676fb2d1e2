//! How good a result is, from poses and shapes alone: the same for every engine.

use crate::motion::rotation_vector;
use crate::neighbours;
use crate::scene::{self, Placed, Scene};
use rayon::prelude::*;
use rockfall::math::{Aabb, DVec3, Mat3, Pose, Vec3, rotation};
use rockfall_collide::{Cache, Manifold, collide, distance};
use serde::{Deserialize, Serialize};

/// Figures of a state.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Quality {
    /// Pairs of bodies, or of a body and ground or wall, that share more than a point.
    pub(crate) overlapping: usize,
    /// Mean depth of those pairs, millimetres: the length of the shortest translation that parts the two; for a body and
    /// a mesh the depth of the deepest point at which they touch.
    pub(crate) mean_mm: f64,
    /// Depth that 99 % of those pairs do not exceed, millimetres.
    pub(crate) p99_mm: f64,
    /// The largest depth, millimetres.
    pub(crate) deepest_mm: f64,
    /// Bodies whose centre is under the ground or behind a wall, or whose pose is not finite.
    pub(crate) escaped: usize,
    /// Kinetic energy by the difference of two poses, J.
    pub(crate) kinetic: f64,
    /// √(2 E / M): the speed at which the whole mass would have that energy, m/s.
    pub(crate) rms_speed: f64,
    /// Bodies whose centre of mass is faster than [`MOVING`].
    pub(crate) moving: usize,
    /// How far the top has sunk since the start, millimetres; of several tops the one that sank most.
    pub(crate) top_drop_mm: Option<f64>,
    /// How far the top has gone sideways since the start, millimetres; of several tops the one that went farthest.
    pub(crate) top_drift_mm: Option<f64>,
}

/// m/s. Faster than anything that an engine would let fall asleep.
const MOVING: f64 = 0.05;

/// Judges `after`, the poses after so many steps; `before` are those one step earlier. Both in the order of the
/// scene's bodies.
pub(crate) fn measure(scene: &Scene, steps: u32, before: &[Pose], after: &[Pose]) -> Quality {
    let depths = depths(scene, &scene.immovable(steps), after);
    let Motion { kinetic, mass, moving } = motion(scene, before, after);
    let gone = |i: &usize| after[*i].position - scene.bodies[*i].pose.position;
    let largest = |way: fn(DVec3) -> f64| scene.tops.iter().map(|i| 1e3 * way(gone(i))).reduce(f64::max);
    Quality {
        overlapping: depths.len(),
        // Not `sum`, which of nothing is −0.
        mean_mm: 1e3 * depths.iter().fold(0.0, |a, b| a + b) / depths.len().max(1) as f64,
        p99_mm: 1e3 * percentile(&depths, 99),
        deepest_mm: 1e3 * percentile(&depths, 100),
        escaped: scene.bodies.iter().zip(after).filter(|(body, pose)| has_escaped(scene, body, pose)).count(),
        kinetic,
        rms_speed: if mass > 0.0 { (2.0 * kinetic / mass).sqrt() } else { 0.0 },
        moving,
        top_drop_mm: largest(|gone| -gone.z),
        top_drift_mm: largest(|gone| gone.x.hypot(gone.y)),
    }
}

/// The smallest of `sorted` that at least `percent` % do not exceed.
fn percentile(sorted: &[f64], percent: usize) -> f64 {
    let rank = (sorted.len() * percent).div_ceil(100);
    rank.checked_sub(1).map_or(0.0, |i| sorted[i])
}

fn is_finite(pose: &Pose) -> bool {
    pose.position.is_finite() && pose.rotation.is_finite()
}

fn has_escaped(scene: &Scene, body: &Placed, pose: &Pose) -> bool {
    // The origin of a hull may be at its surface, which dips into the ground; its centre of mass is inside.
    let center = scene.shapes[body.shape].mass_properties(scene.density).map_or(Vec3::ZERO, |m| m.center);
    let p = pose.point(center);
    let outside = p.x.abs() > scene.half_width || p.y.abs() > scene.half_width;
    !is_finite(pose) || outside || scene.ground_at(p.x, p.y).is_none_or(|ground| p.z < ground)
}

/// Depths of all overlapping pairs, metres, ascending.
fn depths(scene: &Scene, immovable: &[Placed], poses: &[Pose]) -> Vec<f64> {
    let placed: Vec<Placed> = scene
        .bodies
        .iter()
        .zip(poses)
        .filter(|(_, pose)| is_finite(pose))
        .map(|(body, &pose)| Placed { pose, ..*body })
        .collect();
    let bounds = |p: &Placed| scene.shapes[p.shape].placed_bounds(&p.pose);
    let boxes: Vec<Aabb> = placed.iter().map(bounds).collect();
    let fixed: Vec<Aabb> = immovable.iter().map(bounds).collect();

    let other = |j: usize| placed.get(j).unwrap_or_else(|| &immovable[j - placed.len()]);
    let mut depths: Vec<f64> = neighbours::pairs(&boxes, &fixed)
        .into_par_iter()
        .filter_map(|(i, j)| depth(scene, &placed[i], other(j)))
        .collect();
    depths.sort_unstable_by(f64::total_cmp);
    depths
}

/// Of a convex body in something, metres; nothing where they don't overlap.
fn depth(scene: &Scene, a: &Placed, b: &Placed) -> Option<f64> {
    let [first, second] = [a, b].map(|placed| &scene.shapes[placed.shape]);
    let place = a.pose.see(&b.pose);
    let signed = if second.is_convex() {
        distance(first, second, &place)?.distance
    } else {
        let mut manifolds = Vec::new();
        collide(first, second, &place, 0.0, &mut Cache::default(), &mut manifolds);
        manifolds.iter().map(Manifold::deepest).reduce(f32::min)?
    };
    (signed < 0.0).then(|| -f64::from(signed))
}

/// Of the bodies with finite poses.
#[derive(Default)]
struct Motion {
    /// J.
    kinetic: f64,
    /// kg.
    mass: f64,
    moving: usize,
}

fn motion(scene: &Scene, before: &[Pose], after: &[Pose]) -> Motion {
    let rate = f64::from(scene::RATE);
    let pairs = scene.bodies.iter().zip(before.iter().zip(after));
    let mut sums = Motion::default();
    for (body, (old, new)) in pairs.filter(|(_, (old, new))| is_finite(old) && is_finite(new)) {
        let Some(solid) = scene.shapes[body.shape].mass_properties(scene.density) else { continue };
        let mass = f64::from(solid.mass);
        let velocity = (new.point(solid.center) - old.point(solid.center)) * rate;
        let turn = rotation::compose(new.rotation, rotation::inverse(old.rotation));
        let spin = rotation_vector(turn) * rate;
        let axes = Mat3::from_quat(new.rotation).as_dmat3();
        let local = axes.transpose() * spin;
        sums.kinetic +=
            0.5 * (mass * velocity.length_squared() + local.dot(solid.inertia.as_dmat3() * local));
        sums.mass += mass;
        sums.moving += usize::from(velocity.length() > MOVING);
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall::Shape;
    use rockfall::math::{Quat, Vec2};
    use rockfall::shape::{HeightField, Hull, Mesh};
    use std::sync::Arc;

    /// A ground, and unit boxes or unit balls at these places.
    fn scene(shape: Shape, places: &[[f64; 3]]) -> (Scene, Vec<Pose>) {
        let ground = Shape::Box { half: Vec3::new(50.0, 50.0, 1.0) };
        let poses: Vec<Pose> = places.iter().map(|&p| Pose::at(DVec3::from_array(p))).collect();
        let fixed = vec![Placed { shape: 0, pose: Pose::at(DVec3::new(0.0, 0.0, -1.0)) }];
        let bodies = poses.iter().map(|&pose| Placed { shape: 1, pose }).collect();
        let shapes = vec![ground, shape];
        let scene = Scene { shapes, fixed, bodies, density: 2600.0, half_width: 10.0, ..Scene::empty() };
        (scene, poses)
    }

    fn unit_box() -> Shape {
        Shape::Box { half: Vec3::splat(0.5) }
    }

    #[test]
    fn depths_of_boxes_are_those_of_the_hand() {
        // 2 mm into the ground; 5 mm into that; apart; 10 mm into each other sideways.
        let (scene, poses) = scene(
            unit_box(),
            &[[0.0, 0.0, 0.498], [0.3, 0.2, 1.493], [5.0, 0.0, 0.51], [-3.0, 0.0, 4.0], [-2.01, 0.4, 4.2]],
        );
        let q = measure(&scene, 0, &poses, &poses);
        assert_eq!(q.overlapping, 3);
        assert!((q.mean_mm - (2.0 + 5.0 + 10.0) / 3.0).abs() < 1e-3, "{q:?}");
        assert!((q.p99_mm - 10.0).abs() < 1e-3 && (q.deepest_mm - 10.0).abs() < 1e-3, "{q:?}");
        assert_eq!((q.escaped, q.kinetic), (0, 0.0));
    }

    #[test]
    fn depths_of_balls_are_those_of_the_hand() {
        let (scene, poses) =
            scene(Shape::Sphere { radius: 1.0 }, &[[0.0, 0.0, 3.0], [1.2, 1.59, 3.0], [0.0, 0.0, 5.1]]);
        // 2 − √(1.44 + 2.5281) = 7.99 mm; the third is 0.1 m above the first.
        let q = measure(&scene, 0, &poses, &poses);
        let depth = 2e3 - 1e3 * (1.2f64 * 1.2 + 1.59 * 1.59).sqrt();
        assert_eq!(q.overlapping, 1);
        assert!((q.mean_mm - depth).abs() < 1e-3, "{q:?} {depth}");
    }

    #[test]
    fn pairs_across_cells_are_found_once() {
        // A row of balls, each 1 mm into the next, that crosses cells in all directions.
        let direction = DVec3::new(0.6, 0.64, 0.48);
        let places: Vec<[f64; 3]> =
            (0..40).map(|i| (direction * (f64::from(i - 20) * 0.999) + DVec3::Z * 20.0).to_array()).collect();
        let (mut scene, poses) = scene(Shape::Sphere { radius: 0.5 }, &places);
        scene.half_width = 100.0;
        let q = measure(&scene, 0, &poses, &poses);
        assert_eq!(q.overlapping, 39);
        assert!((q.mean_mm - 1.0).abs() < 2e-3 && (q.deepest_mm - 1.0).abs() < 5e-3, "{q:?}");
    }

    #[test]
    fn escaped_are_those_under_the_ground_behind_a_wall_or_nowhere() {
        let (scene, mut poses) = scene(
            unit_box(),
            &[[0.0, 0.0, -0.1], [10.1, 0.0, 5.0], [0.0, -10.1, 5.0], [9.9, 9.9, 5.0], [0.0, 0.0, 9.0]],
        );
        poses[4].position.x = f64::NAN;
        assert_eq!(measure(&scene, 0, &poses, &poses).escaped, 4);
    }

    #[test]
    fn where_a_body_is_is_where_its_mass_is() {
        // A box of 1 m whose origin is 1 cm above its lower face.
        let corner = |i: usize| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32 - 0.01);
        let hull = Hull::from_points(&(0..8).map(corner).collect::<Vec<_>>()).expect("a hull");
        let (scene, poses) = scene(Shape::Hull(Arc::new(hull)), &[[0.0, 0.0, -0.1], [3.0, 0.0, -0.5]]);
        assert_eq!(measure(&scene, 0, &poses, &poses).escaped, 1);
    }

    #[test]
    fn kinetic_energy_is_that_of_a_sliding_and_spinning_box() {
        let (scene, before) = scene(unit_box(), &[[0.0, 0.0, 3.0]]);
        let rate = f64::from(scene::RATE);
        let (speed, spin) = (3.0, 2.0);
        let half_angle = 0.5 * spin / rate;
        let turned = Quat::from_xyzw(0.0, 0.0, -half_angle.sin() as f32, -half_angle.cos() as f32);
        let after = Pose { position: before[0].position + DVec3::X * (speed / rate), rotation: turned };
        let q = measure(&scene, 0, &before, &[after]);
        let mass = f64::from(scene.density);
        let expected = 0.5 * mass * (speed * speed + spin * spin / 6.0);
        assert!((q.kinetic / expected - 1.0).abs() < 1e-4, "{q:?} {expected}");
        assert!((q.rms_speed - (2.0 * expected / mass).sqrt()).abs() < 1e-3);
        assert_eq!((q.moving, measure(&scene, 0, &before, &before).moving), (1, 0));
    }

    #[test]
    fn the_top_that_moved_farthest_counts() {
        let (mut scene, mut poses) = scene(unit_box(), &[[0.0, 0.0, 0.5], [0.0, 0.0, 1.5], [4.0, 0.0, 1.5]]);
        assert_eq!(measure(&scene, 0, &poses, &poses).top_drop_mm, None);
        scene.tops = vec![1, 2];
        poses[1].position += DVec3::new(0.3, -0.4, -0.25);
        poses[2].position.z -= 0.125;
        let q = measure(&scene, 0, &poses, &poses);
        assert_eq!((q.top_drop_mm, q.top_drift_mm), (Some(250.0), Some(500.0)));
    }

    #[test]
    fn on_a_terrain_depths_and_escapes_are_by_its_surface() {
        let (mut scene, _) = scene(Shape::Sphere { radius: 1.0 }, &[]);
        // A ramp that rises by 3/4 along x.
        let corners = [[-4.0, -4.0, -3.0], [4.0, -4.0, 3.0], [4.0, 4.0, 3.0], [-4.0, 4.0, -3.0]];
        let ramp = Mesh::from_triangles(&corners.map(Vec3::from), &[[0, 1, 2], [0, 2, 3]]).expect("a mesh");
        scene.shapes[0] = Shape::Mesh(Arc::new(ramp));
        scene.fixed[0].pose = Pose::default();
        let heights = vec![-3.0, 3.0, -3.0, 3.0];
        scene.terrain = Some(HeightField::new(2, 2, Vec2::splat(8.0), heights).expect("a field"));
        // Normal (−0.6, 0, 0.8): the first is 10 mm deep, the second 0.2 m above, the third below, the fourth off the edge.
        let above = |height: f64| DVec3::new(-0.6 * height, 0.5, 0.8 * height);
        let at = [above(0.99), above(1.2) - 3.0 * DVec3::Y, DVec3::new(2.0, -2.0, 1.4), DVec3::X * 4.1];
        let place = |position| Placed { shape: 1, pose: Pose::at(position) };
        scene.bodies = at.into_iter().map(place).collect();
        let judge = |scene: &Scene| {
            let poses: Vec<Pose> = scene.bodies.iter().map(|b| b.pose).collect();
            measure(scene, 0, &poses, &poses)
        };
        assert_eq!(judge(&scene).escaped, 2);
        scene.bodies.truncate(2);
        let q = judge(&scene);
        assert!(q.overlapping == 1 && (q.mean_mm - 10.0).abs() < 1e-2, "{q:?}");
    }

    #[test]
    fn percentiles_are_by_nearest_rank() {
        let hundred: Vec<f64> = (1..=200).map(f64::from).collect();
        assert_eq!(percentile(&hundred, 99), 198.0);
        assert_eq!(percentile(&hundred, 100), 200.0);
        assert_eq!(percentile(&[3.0], 99), 3.0);
        assert_eq!(percentile(&[], 99), 0.0);
    }
}
