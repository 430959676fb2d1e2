//! Ray casts.

use super::{BLOCK, Filter, Items, Lists, View, around, collide, up};
use crate::{BodyId, World};
use rayon::prelude::*;
use rockfall_math::{DVec3, Vec3, rotation};

/// From a point along a straight line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Metres.
    pub origin: DVec3,
    /// Of any length but zero.
    pub direction: Vec3,
    /// How far it reaches, metres; may be infinite.
    pub max_distance: f64,
    /// What a ray meets that starts in a convex body: that one at distance 0, or, if not solid, the place where it leaves it. As
    /// in `parry3d`.
    pub solid: bool,
}

/// Where a [`Ray`] meets a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// The body.
    pub body: BodyId,
    /// From the ray's origin, metres.
    pub distance: f64,
    /// Unit vector out of the body's surface, also where the ray comes from within or from behind; zero where it starts inside.
    pub normal: Vec3,
    /// What of the shape was met: a box's face (−x, +x, −y, +y, −z, +z), a hull's face, a capsule's lower end, upper end or side (0, 1, 2), a mesh's
    /// triangle, a height field's triangle: of cell (i, j) 2 (j (columns − 1) + i) is the one towards +x, the next the other. 0 for other shapes;
    /// [`INSIDE`](rockfall_collide::INSIDE), 2⁶⁴ − 1, where the ray starts inside.
    pub part: u64,
}

impl Ray {
    /// A solid ray that goes on for ever.
    pub fn new(origin: DVec3, direction: Vec3) -> Self {
        Ray { origin, direction, max_distance: f64::INFINITY, solid: true }
    }

    /// The straight way between two points.
    pub fn between(from: DVec3, to: DVec3) -> Self {
        let way = to - from;
        let direction = way.normalize_or_zero().as_vec3();
        Ray { max_distance: way.length(), ..Ray::new(from, direction) }
    }

    /// The same, not further than `distance` metres.
    pub fn up_to(self, distance: f64) -> Self {
        Ray { max_distance: distance, ..self }
    }

    /// The same, for which bodies are hollow: from inside it meets the place where it leaves.
    pub fn hollow(self) -> Self {
        Ray { solid: false, ..self }
    }

    /// The point at a distance from the origin, metres.
    pub fn at(&self, distance: f64) -> DVec3 {
        self.origin + distance * self.unit()
    }

    fn unit(&self) -> DVec3 {
        self.direction.as_dvec3().normalize_or_zero()
    }
}

impl World {
    /// The first body that a ray meets, as the last step and all changes since have left them; see [`World::cast_rays`].
    ///
    /// # Examples
    /// ```
    /// use rockfall::math::{DVec3, Pose, Vec3};
    /// use rockfall::{Body, Filter, Material, Ray, Settings, Shape, World};
    ///
    /// let mut world = World::new(Settings::default())?;
    /// let rock = world.add_material(Material::default())?;
    /// let ball = world.add_shape(Shape::Sphere { radius: 0.5 })?;
    /// let near = world.spawn(Body::new(ball, rock, Pose::at(DVec3::new(3.0, 0.0, 0.0))))?;
    /// let far = world.spawn(Body::new(ball, rock, Pose::at(DVec3::new(6.0, 0.0, 0.0))))?;
    ///
    /// let ray = Ray::new(DVec3::ZERO, Vec3::X);
    /// let hit = world.cast_ray(&ray, &Filter::default()).expect("two balls are in the way");
    /// assert_eq!((hit.body, hit.distance, hit.normal), (near, 2.5, -Vec3::X));
    /// let beyond = world.cast_ray(&ray, &Filter::except(near)).expect("one is left");
    /// assert_eq!((beyond.body, beyond.distance), (far, 5.5));
    /// # Ok::<(), rockfall::Error>(())
    /// ```
    pub fn cast_ray(&self, ray: &Ray, filter: &Filter) -> Option<RayHit> {
        self.view(filter).first(ray)
    }

    /// The first body that each ray meets, in the order of the rays; in parallel. Touching counts. Meshes and height fields are surfaces, met from either side.
    ///
    /// A ray meets nothing whose origin or direction is not finite, whose direction is zero, or whose distance is negative or not a number.
    ///
    /// Distances are worked out in double precision from the difference of ray and body: they are as exact far from the world's origin as at it.
    pub fn cast_rays(&self, rays: &[Ray], filter: &Filter) -> Vec<Option<RayHit>> {
        let view = self.view(filter);
        let first = || rays.par_iter().with_min_len(BLOCK).map(|ray| view.first(ray)).collect();
        self.pool.install(first)
    }

    /// Every body that each ray meets, where it first meets it, nearest first; see [`World::cast_rays`].
    pub fn cast_rays_all(&self, rays: &[Ray], filter: &Filter) -> Lists<RayHit> {
        let view = self.view(filter);
        self.pool.install(|| Lists::of(rays, |ray, out| view.all(ray, out)))
    }

    /// Whether each ray meets anything: cheaper than to ask for what it meets first. See [`World::cast_rays`].
    pub fn test_rays(&self, rays: &[Ray], filter: &Filter) -> Vec<bool> {
        let view = self.view(filter);
        let any = || rays.par_iter().with_min_len(BLOCK).map(|ray| view.any(ray)).collect();
        self.pool.install(any)
    }
}

/// A body's row and how it is met, the normal in the world's frame.
type Met = (u32, collide::RayHit);

impl View<'_> {
    fn first(&self, ray: &Ray) -> Option<RayHit> {
        let mut best: Option<Met> = None;
        self.follow(ray, |row, hit| {
            let nearer =
                |known: &Met| hit.t < known.1.t || (hit.t == known.1.t && self.id(row) < self.id(known.0));
            if best.as_ref().is_none_or(nearer) {
                best = Some((row, hit));
            }
            best.map_or(ray.max_distance, |(_, hit)| hit.t)
        });
        best.map(|(row, hit)| self.told(row, &hit))
    }

    fn any(&self, ray: &Ray) -> bool {
        let mut met = false;
        self.follow(ray, |_, _| {
            met = true;
            -1.0
        });
        met
    }

    fn all(&self, ray: &Ray, out: &mut Vec<RayHit>) {
        let first = out.len();
        self.follow(ray, |row, hit| {
            out.push(self.told(row, &hit));
            ray.max_distance
        });
        out[first..].sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.body.cmp(&b.body)));
    }

    fn told(&self, row: u32, hit: &collide::RayHit) -> RayHit {
        RayHit { body: self.id(row), distance: hit.t, normal: hit.normal, part: hit.part }
    }

    /// Calls `f` with every body that the ray meets; `f` returns how far it is to be followed from then on, a negative distance to stop.
    #[inline]
    fn follow(&self, ray: &Ray, mut f: impl FnMut(u32, collide::RayHit) -> f64) {
        let (origin, unit) = (around(ray.origin), ray.unit());
        if unit == DVec3::ZERO || !ray.direction.is_finite() || ray.max_distance.is_nan() {
            return;
        }
        let direction = unit.as_vec3();
        let mut max = ray.max_distance;
        for (tree, items) in self.trees() {
            tree.cast_box(&origin, direction, up(max), |item, _| {
                if let Some(hit) = self.meets(items, item, ray, unit, max) {
                    max = f(hit.0, hit.1);
                }
                up(max)
            });
        }
    }

    #[inline]
    fn meets(&self, items: Items, item: u32, ray: &Ray, unit: DVec3, max: f64) -> Option<Met> {
        let (row, shape) = self.body(items, item)?;
        let i = row as usize;
        if self.bodies.balls[i] {
            // It looks the same however it is turned.
            let local = collide::Ray { origin: ray.origin - self.bodies.positions[i], direction: unit, max };
            return Some((row, collide::cast_ray(shape, &local, ray.solid)?));
        }
        let rotation = self.bodies.rotations[i];
        let direction = rotation::rotate_back_double(rotation, unit);
        let local = collide::Ray { origin: self.local(i, ray.origin), direction, max };
        let hit = collide::cast_ray(shape, &local, ray.solid)?;
        Some((row, collide::RayHit { normal: rotation::rotate(rotation, hit.normal), ..hit }))
    }
}
