//! Shape casts, overlaps and penetrations.

use super::{BLOCK, Filter, Lists, View, collide, up};
use crate::{Body, BodyId, Error, Shape, World};
use rayon::prelude::*;
use rockfall_math::{DVec3, Isometry, Mat3, Pose, Vec3};

/// A shape on its way: where it starts, and where to, without turning.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cast {
    /// At the start.
    pub pose: Pose,
    /// Metres.
    pub translation: Vec3,
}

/// Where a shape on its way first touches a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CastHit {
    /// The body.
    pub body: BodyId,
    /// Share of the way, 0 to 1. Up to there the shape touches nothing.
    pub time: f64,
    /// Unit vector out of the body.
    pub normal: Vec3,
    /// Where they touch.
    pub point: DVec3,
    /// Signed distance at that time, metres: negative where the shape overlaps the body from the start, else nearly 0.
    pub distance: f32,
}

/// How a placed shape overlaps a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penetration {
    /// The body.
    pub body: BodyId,
    /// How far the shape must at least move along `normal` to leave the body, metres. Out of meshes and height fields it is the deepest contact,
    /// out of compounds the way out of the part that overlaps most.
    pub depth: f32,
    /// Unit vector out of the body.
    pub normal: Vec3,
    /// The deepest point of the shape.
    pub point: DVec3,
}

impl World {
    /// The first body that a shape touches on its way; see [`World::cast_shapes`].
    ///
    /// # Errors
    /// As there.
    pub fn cast_shape(&self, shape: &Shape, cast: &Cast, filter: &Filter) -> Result<Option<CastHit>, Error> {
        let probe = Probe::new(shape)?;
        check(std::slice::from_ref(cast), |cast| (cast.pose, cast.translation))?;
        Ok(self.view(filter).cast(&probe, cast))
    }

    /// The first body that a bounded convex shape, or a compound of such, touches on each of many ways, in their order; in parallel. What it overlaps at the start it
    /// touches at time 0; what it merely touches there only if it moves towards it. Triangles of meshes and height fields are touched from either side.
    ///
    /// A time is never late; it may be early by some millionths of the sizes of shape and body.
    ///
    /// # Errors
    /// [`Error::Shape`] and [`Error::Value`] where the shape makes no sense or is not as said, a pose is not one that a body can have, or a
    /// translation is not finite.
    ///
    /// # Examples
    /// ```
    /// use rockfall::math::{DVec3, Pose, Vec3};
    /// use rockfall::{Body, Cast, Filter, Material, Settings, Shape, World};
    ///
    /// let mut world = World::new(Settings::default())?;
    /// let rock = world.add_material(Material::default())?;
    /// let ground = world.add_shape(Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 })?;
    /// let ground = world.spawn(Body::fixed(ground, rock, Pose::default()))?;
    /// let down = Cast { pose: Pose::at(DVec3::new(0.0, 0.0, 10.5)), translation: Vec3::new(0.0, 0.0, -20.0) };
    /// let hits = world.cast_shapes(&Shape::Sphere { radius: 0.5 }, &[down], &Filter::default())?;
    /// let hit = hits[0].expect("it comes down on the ground");
    /// assert!(hit.body == ground && (hit.time - 0.5).abs() < 1e-5);
    /// # Ok::<(), rockfall::Error>(())
    /// ```
    pub fn cast_shapes(
        &self,
        shape: &Shape,
        casts: &[Cast],
        filter: &Filter,
    ) -> Result<Vec<Option<CastHit>>, Error> {
        let probe = Probe::new(shape)?;
        check(casts, |cast| (cast.pose, cast.translation))?;
        let view = self.view(filter);
        let first = |cast| view.cast(&probe, cast);
        Ok(self.pool.install(|| casts.par_iter().with_min_len(BLOCK).map(first).collect()))
    }

    /// The bodies that share a point with a bounded convex shape, or a compound of such, at each of many poses, by id; in parallel. A mesh is its triangles, a height field is solid all the
    /// way down.
    ///
    /// # Errors
    /// As [`World::cast_shapes`].
    ///
    /// # Examples
    /// ```
    /// use rockfall::math::{DVec3, Pose};
    /// use rockfall::{Body, Filter, Material, Settings, Shape, World};
    ///
    /// let mut world = World::new(Settings::default())?;
    /// let rock = world.add_material(Material::default())?;
    /// let ball = world.add_shape(Shape::Sphere { radius: 0.5 })?;
    /// let at = |x: f64| Pose::at(DVec3::new(x, 0.0, 0.0));
    /// let ids = world.spawn_all((0..10).map(|i| Body::new(ball, rock, at(2.0 * f64::from(i)))))?;
    /// let found = world.overlaps(&Shape::Sphere { radius: 1.0 }, &[at(3.0), at(-9.0)], &Filter::default())?;
    /// assert_eq!(found.get(0), &ids[1..3]);
    /// assert!(found.get(1).is_empty());
    /// # Ok::<(), rockfall::Error>(())
    /// ```
    pub fn overlaps(&self, shape: &Shape, poses: &[Pose], filter: &Filter) -> Result<Lists<BodyId>, Error> {
        let probe = Probe::new(shape)?;
        check(poses, |pose| (*pose, Vec3::ZERO))?;
        let view = self.view(filter);
        Ok(self.pool.install(|| {
            Lists::of(poses, |pose, out| {
                let first = out.len();
                view.around(&probe, pose, |row, body, there| {
                    if collide::overlaps(shape, body, there) {
                        out.push(view.id(row));
                    }
                });
                out[first..].sort_unstable();
            })
        }))
    }

    /// How a bounded convex shape, or a compound of such, at each of many poses overlaps bodies, by id; in parallel. See [`World::overlaps`].
    ///
    /// # Errors
    /// As [`World::cast_shapes`].
    pub fn penetrations(
        &self,
        shape: &Shape,
        poses: &[Pose],
        filter: &Filter,
    ) -> Result<Lists<Penetration>, Error> {
        let probe = Probe::new(shape)?;
        check(poses, |pose| (*pose, Vec3::ZERO))?;
        let view = self.view(filter);
        Ok(self.pool.install(|| {
            Lists::of(poses, |pose, out| {
                let first = out.len();
                view.around(&probe, pose, |row, body, there| {
                    let Some(deep) = collide::penetration(shape, body, there) else { return };
                    let turned = Mat3::from_quat(pose.rotation);
                    out.push(Penetration {
                        body: view.id(row),
                        depth: -deep.distance,
                        normal: turned * -deep.normal,
                        point: pose.position + (turned * deep.on_a).as_dvec3(),
                    });
                });
                out[first..].sort_unstable_by_key(|penetration| penetration.body);
            })
        }))
    }
}

/// How early a touch may be told, as a share of both sizes: twice what [`collide::cast_shape`] needs.
const EARLY: f32 = 1e-5;

/// A shape to ask with.
struct Probe<'a> {
    shape: &'a Shape,
    /// Of a ball around it.
    center: Vec3,
    radius: f32,
}

impl<'a> Probe<'a> {
    fn new(shape: &'a Shape) -> Result<Self, Error> {
        shape.validate()?;
        let center = shape.bounds().center();
        let radius = shape.radius_about(center);
        let bounded = |shape: &Shape| shape.is_convex() && !matches!(shape, Shape::HalfSpace { .. });
        let usable = match shape {
            Shape::Compound(compound) => compound.parts().iter().all(|part| bounded(&part.shape)),
            _ => bounded(shape),
        };
        if usable {
            return Ok(Probe { shape, center, radius });
        }
        let (value, expected) = (shape.name().to_string(), "a bounded convex one, or a compound of such");
        Err(Error::Value { what: "shape of a query", value, expected })
    }
}

/// Refuses the first placement that makes no sense.
fn check<T>(placements: &[T], read: impl Fn(&T) -> (Pose, Vec3)) -> Result<(), Error> {
    for (pose, translation) in placements.iter().map(read) {
        Body::check_pose(&pose)?;
        if !translation.is_finite() {
            let value = translation.to_string();
            return Err(Error::Value { what: "translation", value, expected: "three finite numbers" });
        }
    }
    Ok(())
}

impl View<'_> {
    /// Calls `f` with the row, the shape and the place, seen from the probe, of all bodies whose boxes the placed probe's box meets.
    fn around(&self, probe: &Probe, pose: &Pose, mut f: impl FnMut(u32, &Shape, &Isometry)) {
        let area = probe.shape.placed_bounds(pose);
        self.within(&area, |row, shape| f(row as u32, shape, &pose.see(&self.bodies.shape_pose(row))));
    }

    fn cast(&self, probe: &Probe, cast: &Cast) -> Option<CastHit> {
        let mut best: Option<CastHit> = None;
        let mut limit = 1.0;
        let area = probe.shape.placed_bounds(&cast.pose);
        for (tree, items) in self.trees() {
            tree.cast_box(&area, cast.translation, limit, |item, _| {
                if let Some((row, shape)) = self.body(items, item)
                    && let Some(hit) = self.touch(probe, cast, row, shape)
                {
                    let nearer = |known: &CastHit| {
                        hit.time < known.time || (hit.time == known.time && hit.body < known.body)
                    };
                    if best.as_ref().is_none_or(nearer) {
                        limit = self.limit(probe, cast, row, &hit);
                        best = Some(hit);
                    }
                }
                limit
            });
        }
        best
    }

    /// Up to what time another body may be touched at the time of a hit: that is early by a gap, which is wider along the way than along the normal.
    fn limit(&self, probe: &Probe, cast: &Cast, row: u32, hit: &CastHit) -> f32 {
        let length = cast.translation.length();
        let radius = self.bodies.radii[row as usize];
        let size = probe.radius + if radius.is_finite() { radius } else { length };
        let closing = -cast.translation.dot(hit.normal);
        let late = if closing > 0.0 { EARLY * size / closing } else { 1.0 };
        up(hit.time + f64::from(late)).min(1.0)
    }

    /// Where the probe first touches a body. Looked for only where it comes near, and seen from the body there, so that a long way costs no digits.
    fn touch(&self, probe: &Probe, cast: &Cast, row: u32, shape: &Shape) -> Option<CastHit> {
        let body = self.bodies.shape_pose(row as usize);
        let way = cast.translation.as_dvec3();
        let length = way.length();
        let along = way.normalize_or_zero();
        let between = self.bodies.positions[row as usize] - cast.pose.point(probe.center);
        let reach = 1.01 * f64::from(self.bodies.radii[row as usize] + probe.radius);
        let (mut from, mut until) = (0.0_f64, length);
        if reach.is_finite() {
            let middle = between.dot(along);
            (from, until) = (from.max(middle - reach), until.min(middle + reach));
        }
        if from > until {
            return None;
        }
        let start = Pose { position: cast.pose.position + from * along, ..cast.pose };
        let left = ((until - from) * along).as_vec3();
        let turned = Mat3::from_quat(body.rotation);
        let toi = collide::cast_shape(probe.shape, shape, &body.see(&start), turned.transpose() * left)?;
        let gone = from + f64::from(toi.time) * (until - from);
        Some(CastHit {
            body: self.id(row),
            time: if length > 0.0 { (gone / length).min(1.0) } else { 0.0 },
            normal: turned * -toi.normal,
            point: body.position + (turned * toi.point).as_dvec3(),
            distance: toi.distance,
        })
    }
}
