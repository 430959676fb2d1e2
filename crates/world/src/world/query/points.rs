//! The nearest body to a point, and its signed distance.

use super::{BLOCK, Filter, View, around, collide};
use crate::{BodyId, World};
use rayon::prelude::*;
use rockfall_math::{DVec3, Vec3, rotation};

/// The body nearest to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointHit {
    /// The body.
    pub body: BodyId,
    /// Metres; negative where the point is inside of the body.
    pub distance: f32,
    /// The nearest point of its surface.
    pub point: DVec3,
    /// Unit vector out of the body, along which the distance grows.
    pub normal: Vec3,
}

impl World {
    /// The body whose surface is nearest to a point; see [`World::nearest_points`].
    ///
    /// # Examples
    /// ```
    /// use rockfall::math::{DVec3, Pose, Vec3};
    /// use rockfall::{Body, Filter, Material, Settings, Shape, World};
    ///
    /// let mut world = World::new(Settings::default())?;
    /// let rock = world.add_material(Material::default())?;
    /// let ground = world.add_shape(Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 })?;
    /// let ground = world.spawn(Body::fixed(ground, rock, Pose::default()))?;
    /// let near = world.nearest_point(DVec3::new(1.0, 2.0, 3.0), f32::INFINITY, &Filter::default());
    /// let near = near.expect("there is no limit");
    /// assert_eq!((near.body, near.distance, near.point), (ground, 3.0, DVec3::new(1.0, 2.0, 0.0)));
    /// # Ok::<(), rockfall::Error>(())
    /// ```
    pub fn nearest_point(&self, point: DVec3, max_distance: f32, filter: &Filter) -> Option<PointHit> {
        self.view(filter).nearest(point, max_distance)
    }

    /// The body with the least signed distance from each point, if that is at most `max_distance` metres, which may be infinite; in the order
    /// of the points, in parallel. Where bodies overlap, that is the one that the point is deepest in. What is solid: see [`rockfall_collide::nearest_point`].
    ///
    /// Nothing is near a point that is not finite, or where the distance is negative or not a number.
    pub fn nearest_points(
        &self,
        points: &[DVec3],
        max_distance: f32,
        filter: &Filter,
    ) -> Vec<Option<PointHit>> {
        let view = self.view(filter);
        let nearest = |&point: &DVec3| view.nearest(point, max_distance);
        self.pool.install(|| points.par_iter().with_min_len(BLOCK).map(nearest).collect())
    }
}

impl View<'_> {
    fn nearest(&self, point: DVec3, max_distance: f32) -> Option<PointHit> {
        let mut best: Option<(u32, collide::Nearest)> = None;
        let mut max = max_distance;
        for (tree, items) in self.trees() {
            // Boxes hold the point whatever the depth in a body.
            tree.nearest(&around(point), max.max(0.0), |item, _| {
                if let Some((row, shape)) = self.body(items, item)
                    && let Some(near) = collide::nearest_point(shape, self.local(row as usize, point), max)
                {
                    let nearer = |(known, by): &(u32, collide::Nearest)| {
                        near.distance < by.distance
                            || (near.distance == by.distance && self.id(row) < self.id(*known))
                    };
                    if best.as_ref().is_none_or(nearer) {
                        best = Some((row, near));
                        max = near.distance;
                    }
                }
                max.max(0.0)
            });
        }
        let (row, near) = best.filter(|_| max_distance >= 0.0)?;
        let i = row as usize;
        let turn = |v: Vec3| rotation::rotate(self.bodies.rotations[i], v);
        Some(PointHit {
            body: self.id(row),
            distance: near.distance,
            point: self.bodies.positions[i] + turn(near.point - self.bodies.centers[i]).as_dvec3(),
            normal: turn(near.normal),
        })
    }
}
