//! A stage seen from an eye: what a ray meets first, and whether anything is in its way.
//!
//! Places are relative to the eye, in double precision; the tree over their boxes is the engine's broad phase, and what a ray meets in a box is decided by
//! the engine's ray casts. So a picture shows the surfaces that bodies collide with.

mod quilt;

use crate::{Actor, Stage};
use quilt::Quilt;
use rayon::prelude::*;
use rockfall_collide::{Ray, cast_ray};
use rockfall_math::{Aabb, DVec3, Pose, Quat, Vec3, rotation};
use rockfall_shape::Shape;
use rockfall_tree::Tree;

/// Actors this many times as large as the usual one are asked after the tree, when the rays that meet something smaller are short: their boxes are
/// met by nearly every ray.
const LARGE: f32 = 64.0;

/// Of these, at most so many; more would cost more than they save.
const MOST_LARGE: usize = 16;

/// A stage, ready for rays.
pub(crate) struct View<'a> {
    stage: &'a Stage,
    places: Vec<Place>,
    /// Of each shape that is a height field.
    quilts: Vec<Option<Quilt>>,
    tree: Tree,
    large: Vec<u32>,
    /// Size of the usual actor: half the diagonal of its box, metres; zero where there is none.
    pub(crate) usual: f32,
}

/// Where an actor is, seen from the eye.
#[derive(Clone, Copy)]
struct Place {
    at: DVec3,
    rotation: Quat,
}

/// Where a ray first meets an actor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    /// In lengths of the ray's direction.
    pub(crate) t: f64,
    /// Unit vector, on the side where the ray comes from.
    pub(crate) normal: Vec3,
    /// Index of the actor.
    pub(crate) actor: u32,
}

impl<'a> View<'a> {
    /// Builds the tree, in parallel.
    pub(crate) fn new(stage: &'a Stage, eye: DVec3) -> Self {
        let place = |actor: &Actor| Place { at: actor.pose.position - eye, rotation: actor.pose.rotation };
        let places: Vec<Place> = stage.actors.par_iter().map(place).collect();
        let area = |(actor, place): (&Actor, &Place)| match stage.shape_of(actor) {
            Some(shape) if place.at.is_finite() && place.rotation.is_finite() => {
                shape.placed_bounds(&Pose { position: place.at, rotation: place.rotation })
            }
            _ => Aabb::EMPTY,
        };
        let mut boxes: Vec<Aabb> = stage.actors.par_iter().zip(&places).map(area).collect();
        let (usual, large) = large(stage, &boxes);
        large.iter().for_each(|&actor| boxes[actor as usize] = Aabb::EMPTY);
        let quilt = |shape: &Shape| {
            if let Shape::HeightField(field) = shape { Some(Quilt::new(field)) } else { None }
        };
        let quilts = stage.shapes.par_iter().map(quilt).collect();
        View { stage, places, quilts, tree: Tree::build(&boxes), large, usual }
    }

    /// What the ray, whose origin is relative to the eye, meets first.
    pub(crate) fn first(&self, ray: &Ray) -> Option<Hit> {
        let mut ray = *ray;
        let mut found: Option<Hit> = None;
        let origin = Aabb::around(ray.origin, ray.origin);
        self.tree.cast_box(&origin, ray.direction.as_vec3(), up(ray.max), |actor, _| {
            self.meet(actor, &mut ray, &mut found);
            up(ray.max)
        });
        self.large.iter().for_each(|&actor| self.meet(actor, &mut ray, &mut found));
        found
    }

    /// Whether the ray meets anything at all.
    pub(crate) fn blocked(&self, ray: &Ray) -> bool {
        self.blocked_by(ray, |_| true)
    }

    /// Whether the ray meets an actor that does not move.
    pub(crate) fn blocked_by_fixed(&self, ray: &Ray) -> bool {
        self.blocked_by(ray, |actor| !self.stage.actors[actor as usize].moves)
    }

    /// Whether the ray meets one of the actors that count.
    #[inline]
    fn blocked_by(&self, ray: &Ray, counts: impl Fn(u32) -> bool) -> bool {
        let meets = |actor: u32| counts(actor) && self.cast(actor, ray).is_some();
        let mut blocked = false;
        let origin = Aabb::around(ray.origin, ray.origin);
        self.tree.cast_box(&origin, ray.direction.as_vec3(), up(ray.max), |actor, max| {
            blocked = meets(actor);
            if blocked { -1.0 } else { max }
        });
        blocked || self.large.iter().any(|&actor| meets(actor))
    }

    /// Cuts the ray where it meets an actor.
    #[inline]
    fn meet(&self, actor: u32, ray: &mut Ray, found: &mut Option<Hit>) {
        if let Some((t, normal)) = self.cast(actor, ray)
            && found.is_none_or(|known| t < known.t)
        {
            let normal = if normal.as_dvec3().dot(ray.direction) > 0.0 { -normal } else { normal };
            ray.max = t;
            *found = Some(Hit { t, normal, actor });
        }
    }

    #[inline]
    fn cast(&self, actor: u32, ray: &Ray) -> Option<(f64, Vec3)> {
        let place = &self.places[actor as usize];
        let index = self.stage.actors[actor as usize].shape as usize;
        let shape = self.stage.shapes.get(index)?;
        let origin = ray.origin - place.at;
        if let Shape::Sphere { .. } = shape {
            // However it is turned.
            let hit = cast_ray(shape, &Ray { origin, ..*ray }, false)?;
            return Some((hit.t, hit.normal));
        }
        let local = Ray {
            origin: rotation::rotate_back_double(place.rotation, origin),
            direction: rotation::rotate_back_double(place.rotation, ray.direction),
            max: ray.max,
        };
        let hit = match &self.quilts[index] {
            Some(quilt) => quilt.cast(shape, &local),
            None => cast_ray(shape, &local, false),
        }?;
        Some((hit.t, rotation::rotate(place.rotation, hit.normal)))
    }
}

/// The size of the usual actor, and who is much larger.
fn large(stage: &Stage, boxes: &[Aabb]) -> (f32, Vec<u32>) {
    let endless = |k: usize| matches!(stage.shape_of(&stage.actors[k]), Some(Shape::HalfSpace { .. }));
    let size = |k: usize| boxes[k].half_extents().length();
    let bounded = |k: &usize| boxes[*k].is_valid() && !endless(*k);
    let mut sizes: Vec<f32> = (0..boxes.len()).into_par_iter().filter(bounded).map(size).collect();
    let middle = sizes.len() / 2;
    let usual = if sizes.is_empty() { 0.0 } else { *sizes.select_nth_unstable_by(middle, f32::total_cmp).1 };
    let is_large = |k: &usize| boxes[*k].is_valid() && (endless(*k) || size(*k) > LARGE * usual);
    let mut large: Vec<usize> = (0..boxes.len()).into_par_iter().filter(is_large).collect();
    large.sort_by(|&a, &b| endless(b).cmp(&endless(a)).then(size(b).total_cmp(&size(a))).then(a.cmp(&b)));
    large.truncate(MOST_LARGE);
    // Those without an end last, so that they are asked when the ray is shortest.
    large.reverse();
    (usual, large.into_iter().map(|k| k as u32).collect())
}

/// In single precision, not less.
fn up(x: f64) -> f32 {
    let single = x as f32;
    if f64::from(single) < x { single.next_up() } else { single }
}
