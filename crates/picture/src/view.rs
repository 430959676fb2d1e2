//! A stage seen from an eye: what a beam meets first, and whether anything is in its way.
//!
//! Places are relative to the eye, in double precision until then and in single precision from there: what that is off by grows with the distance as pixels do. The usual shapes have
//! closed forms of their own (`solid`); all others are asked by the engine's ray casts. So a picture shows the surfaces that bodies collide with.

mod hierarchy;
mod solid;
mod tile;

pub(crate) use hierarchy::Beam;
pub(crate) use tile::Tile;

use crate::{Actor, Stage};
use hierarchy::{Hierarchy, Visit};
use rayon::prelude::*;
use rockfall_collide::{Ray, cast_ray};
use rockfall_math::lanes::{Kernel, Lanes, Width};
use rockfall_math::{Aabb, DVec3, Pose, Quat, Vec3, rotation};
use rockfall_shape::Shape;
use solid::{Patch, Planes};

/// Numbers that are worked on side by side: as many as a node of the hierarchy has children.
pub(crate) const LANES: usize = hierarchy::WIDTH;

/// A stage, ready for beams.
pub(crate) struct View<'a> {
    stage: &'a Stage,
    places: Vec<Place>,
    forms: Vec<Form>,
    items: Vec<Item>,
    hierarchy: Hierarchy,
    floors: Vec<Floor>,
    /// Size of the usual actor: half the diagonal of its box, metres; zero where there is none.
    pub(crate) usual: f32,
}

/// Where an actor is, seen from the eye.
#[derive(Clone, Copy)]
struct Place {
    at: DVec3,
    rotation: Quat,
    /// Its axes.
    axes: [Vec3; 3],
}

/// What a shape is made of for beams, apart from what [`Item`] holds.
enum Form {
    Plain,
    Hull(Planes),
    Patches(Vec<Patch>),
}

/// What has a box of its own in the hierarchy: an actor, or a patch of one that is a height field.
#[derive(Clone, Copy)]
struct Item {
    at: Vec3,
    /// A ball around it.
    center: Vec3,
    radius: f32,
    actor: u32,
    kind: Kind,
}

#[derive(Clone, Copy)]
enum Kind {
    Ball(f32),
    Box(Vec3),
    Hull,
    Patch(u32),
    Other,
}

/// A half-space: it has no box.
struct Floor {
    normal: Vec3,
    offset: f32,
    actor: u32,
}

/// Where a beam first meets an actor.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    /// In lengths of the beam's direction.
    pub(crate) t: f32,
    /// Unit vector, on the side where the beam comes from.
    pub(crate) normal: Vec3,
    /// Index of the actor.
    pub(crate) actor: u32,
}

/// What was met, before anybody asks for its normal.
#[derive(Clone, Copy)]
enum Met {
    Item(u32),
    Triangle(u32, usize),
    Faced(Vec3),
}

impl<'a> View<'a> {
    /// Builds the hierarchy, in parallel.
    pub(crate) fn new(stage: &'a Stage, eye: DVec3) -> Self {
        let place = |actor: &Actor| Place::new(actor, eye);
        let places: Vec<Place> = stage.actors.par_iter().map(place).collect();
        let area = |(actor, place): (&Actor, &Place)| match stage.shape_of(actor) {
            Some(shape) if place.at.is_finite() && place.rotation.is_finite() => {
                shape.placed_bounds(&place.pose())
            }
            _ => Aabb::EMPTY,
        };
        let areas: Vec<Aabb> = stage.actors.par_iter().zip(&places).map(area).collect();
        let form = |shape: &Shape| match shape {
            Shape::Hull(hull) => Form::Hull(Planes::new(hull)),
            Shape::HeightField(field) => Form::Patches(solid::patches(field)),
            _ => Form::Plain,
        };
        let forms: Vec<Form> = stage.shapes.par_iter().map(form).collect();
        let usual = usual(stage, &areas);
        let mut view = View {
            stage,
            places,
            forms,
            items: Vec::new(),
            hierarchy: Hierarchy::default(),
            floors: Vec::new(),
            usual,
        };
        let boxes = view.fill(&areas);
        view.hierarchy = Hierarchy::build(&boxes);
        view
    }

    /// Makes items of the actors, and returns their boxes.
    fn fill(&mut self, areas: &[Aabb]) -> Vec<Aabb> {
        let mut boxes = Vec::with_capacity(areas.len());
        for (index, (actor, area)) in self.stage.actors.iter().zip(areas).enumerate() {
            let Some(shape) = self.stage.shape_of(actor).filter(|_| area.is_valid()) else { continue };
            let (place, index) = (&self.places[index], index as u32);
            if let Shape::HalfSpace { normal, offset } = shape {
                let normal = rotation::rotate(place.rotation, *normal);
                let offset = (normal.as_dvec3().dot(place.at) + f64::from(*offset)) as f32;
                self.floors.push(Floor { normal, offset, actor: index });
                continue;
            }
            if let Form::Patches(patches) = &self.forms[actor.shape as usize] {
                for (number, patch) in patches.iter().enumerate() {
                    let at = place.at + place.pose_at_eye().point(patch.corner);
                    let pose = Pose { position: at, rotation: place.rotation };
                    let size = (patch.high - patch.low).max_element();
                    let middle = 0.5 * (patch.low + patch.high);
                    let radius = 0.5 * (patch.high - patch.low).length() + 1e-3 * size;
                    boxes.push(Aabb::new(patch.low, patch.high).grown(1e-5 * size).placed(&pose));
                    let kind = Kind::Patch(number as u32);
                    let (at, center) = (at.as_vec3(), pose.point(middle).as_vec3());
                    self.items.push(Item { at, center, radius, actor: index, kind });
                }
                continue;
            }
            let kind = match shape {
                Shape::Sphere { radius } => Kind::Ball(*radius),
                Shape::Box { half } => Kind::Box(*half),
                Shape::Hull(_) => Kind::Hull,
                _ => Kind::Other,
            };
            boxes.push(*area);
            let middle = shape.bounds().center();
            let center = place.pose().point(middle).as_vec3();
            // A little more than what rounding takes off.
            let radius = 1.000_01 * shape.radius_about(middle);
            self.items.push(Item { at: place.at.as_vec3(), center, radius, actor: index, kind });
        }
        boxes
    }

    /// What the beam, whose origin is relative to the eye, meets first.
    #[cfg(test)]
    #[inline(always)]
    fn first<L: Lanes>(&self, token: L::Token, beam: &Beam) -> Option<Hit> {
        let mut nearest = Nearest::beyond_floors(self, beam);
        let beam = nearest.beam;
        self.hierarchy.walk::<L>(token, &beam, &mut nearest);
        self.hit(&nearest)
    }

    fn hit(&self, nearest: &Nearest<'_>) -> Option<Hit> {
        let (t, actor, met) = nearest.found?;
        let beam = &nearest.beam;
        let normal = self.normal(met, beam, t);
        Some(Hit { t, normal: if normal.dot(beam.direction) > 0.0 { -normal } else { normal }, actor })
    }

    /// Whether the beam meets anything at all.
    #[inline(always)]
    pub(crate) fn blocked<L: Lanes>(&self, token: L::Token, beam: &Beam) -> bool {
        self.blocked_by::<L>(token, beam, false)
    }

    /// Whether the beam meets an actor that does not move.
    pub(crate) fn blocked_by_fixed(&self, beam: &Beam) -> bool {
        Width::new(LANES).run(Fixed { view: self, beam })
    }

    /// Whether the beam meets anything, or anything that does not move.
    #[inline(always)]
    fn blocked_by<L: Lanes>(&self, token: L::Token, beam: &Beam, fixed: bool) -> bool {
        let mut any = Any { view: self, beam, fixed, blocked: false };
        for floor in &self.floors {
            if any.counts(floor.actor) && floor.meet(beam).is_some() {
                return true;
            }
        }
        self.hierarchy.walk::<L>(token, beam, &mut any);
        any.blocked
    }

    /// Where the beam, up to `max`, first meets an item whose box it enters at `entry`.
    #[inline(always)]
    fn meet<L: Lanes>(
        &self,
        token: L::Token,
        item: u32,
        entry: f32,
        max: f32,
        beam: &Beam,
    ) -> Option<(f32, Met)> {
        let Item { at, center, radius, actor, kind } = self.items[item as usize];
        if let Kind::Ball(radius) = kind {
            let t = solid::seen(solid::ball(at, radius, beam)?, max)?;
            return Some((t, Met::Item(item)));
        }
        if !solid::nears(center, radius, beam) {
            return None;
        }
        let place = &self.places[actor as usize];
        let (origin, direction) = (place.turn_back(beam.origin - at), place.turn_back(beam.direction));
        match kind {
            Kind::Box(half) => {
                let t = solid::seen(solid::cuboid(half, origin, direction)?, max)?;
                Some((t, Met::Item(item)))
            }
            Kind::Hull => {
                let Form::Hull(planes) = self.form(actor) else { return None };
                let t = solid::seen(planes.clip::<L>(token, origin, direction)?, max)?;
                Some((t, Met::Item(item)))
            }
            Kind::Patch(number) => {
                let Form::Patches(patches) = self.form(actor) else { return None };
                let patch = &patches[number as usize];
                let distance = entry + beam.origin.length();
                let (t, lane) = patch.meet::<L>(token, origin, direction, [entry, max], distance)?;
                (t <= max).then_some((t, Met::Triangle(item, lane)))
            }
            Kind::Ball(_) | Kind::Other => {
                let (t, normal) = self.ask(actor, max, beam)?;
                Some((t, Met::Faced(normal)))
            }
        }
    }

    /// Asks the engine.
    #[inline(never)]
    fn ask(&self, actor: u32, max: f32, beam: &Beam) -> Option<(f32, Vec3)> {
        let (place, shape) =
            (&self.places[actor as usize], self.stage.shape_of(&self.stage.actors[actor as usize])?);
        let local = Ray {
            origin: rotation::rotate_back_double(place.rotation, beam.origin.as_dvec3() - place.at),
            direction: rotation::rotate_back_double(place.rotation, beam.direction.as_dvec3()),
            max: max.into(),
        };
        let hit = cast_ray(shape, &local, false)?;
        let t = hit.t as f32;
        (t <= max).then(|| (t, rotation::rotate(place.rotation, hit.normal)))
    }

    fn form(&self, actor: u32) -> &Form {
        &self.forms[self.stage.actors[actor as usize].shape as usize]
    }

    /// Unit vector out of what was met at a place of the beam.
    #[inline(never)]
    fn normal(&self, met: Met, beam: &Beam, t: f32) -> Vec3 {
        let (index, lane) = match met {
            Met::Faced(normal) => return normal,
            Met::Item(index) => (index, 0),
            Met::Triangle(index, lane) => (index, lane),
        };
        let item = &self.items[index as usize];
        let place = &self.places[item.actor as usize];
        let away = beam.origin - item.at + t * beam.direction;
        let shape = self.stage.shape_of(&self.stage.actors[item.actor as usize]);
        match (item.kind, self.form(item.actor), shape) {
            (Kind::Box(half), ..) => place.turn(solid::face(half, place.turn_back(away))),
            (Kind::Hull, _, Some(Shape::Hull(hull))) => {
                place.turn(solid::hull_face(hull, place.turn_back(away)))
            }
            (Kind::Patch(number), Form::Patches(patches), _) => {
                place.turn(patches[number as usize].normal(lane))
            }
            _ => away.normalize_or(Vec3::Z),
        }
    }
}

impl Place {
    fn new(actor: &Actor, eye: DVec3) -> Self {
        let rotation = actor.pose.rotation;
        let axes = Vec3::AXES.map(|axis| rotation::rotate(rotation, axis));
        Place { at: actor.pose.position - eye, rotation, axes }
    }

    fn pose(&self) -> Pose {
        Pose { position: self.at, rotation: self.rotation }
    }

    fn pose_at_eye(&self) -> Pose {
        Pose { position: DVec3::ZERO, rotation: self.rotation }
    }

    /// From the actor's frame.
    #[inline(always)]
    fn turn(&self, v: Vec3) -> Vec3 {
        self.axes[0] * v.x + self.axes[1] * v.y + self.axes[2] * v.z
    }

    /// Into the actor's frame.
    #[inline(always)]
    fn turn_back(&self, v: Vec3) -> Vec3 {
        Vec3::new(self.axes[0].dot(v), self.axes[1].dot(v), self.axes[2].dot(v))
    }
}

impl Floor {
    #[inline(always)]
    fn meet(&self, beam: &Beam) -> Option<f32> {
        let (room, slope) = (self.offset - self.normal.dot(beam.origin), self.normal.dot(beam.direction));
        // From above downwards, or from within outwards.
        let t = room / slope;
        let crosses = if room < 0.0 { slope < 0.0 } else { slope > 0.0 };
        (crosses && t <= beam.max).then_some(t)
    }
}

/// Looks for what is met first.
struct Nearest<'a> {
    view: &'a View<'a>,
    beam: Beam,
    found: Option<(f32, u32, Met)>,
}

impl<'a> Nearest<'a> {
    /// Begins with what has no box.
    #[inline(always)]
    fn beyond_floors(view: &'a View<'a>, beam: &Beam) -> Self {
        let mut nearest = Nearest { view, beam: *beam, found: None };
        for floor in &view.floors {
            if let Some(t) = floor.meet(&nearest.beam) {
                nearest.beam.max = t;
                nearest.found = Some((t, floor.actor, Met::Faced(floor.normal)));
            }
        }
        nearest
    }
}

impl Visit for Nearest<'_> {
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, token: L::Token, item: u32, entry: f32, max: f32) -> f32 {
        match self.view.meet::<L>(token, item, entry, max, &self.beam) {
            Some((t, met)) => {
                self.found = Some((t, self.view.items[item as usize].actor, met));
                t
            }
            None => max,
        }
    }
}

/// Looks for whatever is in the way.
struct Any<'a> {
    view: &'a View<'a>,
    beam: &'a Beam,
    /// Whether only what does not move counts.
    fixed: bool,
    blocked: bool,
}

impl Any<'_> {
    #[inline(always)]
    fn counts(&self, actor: u32) -> bool {
        !self.fixed || !self.view.stage.actors[actor as usize].moves
    }
}

impl Visit for Any<'_> {
    #[inline(always)]
    fn visit<L: Lanes>(&mut self, token: L::Token, item: u32, entry: f32, max: f32) -> f32 {
        let counts = self.counts(self.view.items[item as usize].actor);
        self.blocked = counts && self.view.meet::<L>(token, item, entry, max, self.beam).is_some();
        if self.blocked { -1.0 } else { max }
    }
}

/// Whether a beam meets something fixed, at some width.
struct Fixed<'a> {
    view: &'a View<'a>,
    beam: &'a Beam,
}

impl Kernel for Fixed<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::Token) -> bool {
        // At no other width is it ever called.
        L::WIDTH == LANES && self.view.blocked_by::<L>(token, self.beam, true)
    }
}

/// The size of the usual actor.
fn usual(stage: &Stage, areas: &[Aabb]) -> f32 {
    let endless = |k: usize| matches!(stage.shape_of(&stage.actors[k]), Some(Shape::HalfSpace { .. }));
    let bounded = |k: &usize| areas[*k].is_valid() && !endless(*k);
    let size = |k: usize| areas[k].half_extents().length();
    let mut sizes: Vec<f32> = (0..areas.len()).into_par_iter().filter(bounded).map(size).collect();
    let middle = sizes.len() / 2;
    if sizes.is_empty() { 0.0 } else { *sizes.select_nth_unstable_by(middle, f32::total_cmp).1 }
}
