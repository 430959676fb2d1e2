//! Takes a picture of a stage.
//!
//! 1. One ray through the middle of each pixel finds what is there.
//! 2. A few rays from there look for the sun and the sky ([`Skies`], [`Suns`]); where neighbours don't agree about the sun, at the border of a shadow, more look for it.
//! 3. What they saw is shared by neighbours on the same surface (`smooth`).
//! 4. Pixels at edges are looked at again at several places. What lies on a surface next to it that has been lit takes the light from there, since light
//!    changes slowly where edges don't.
//!
//! Each pixel depends on the stage and on pixels of earlier passes alone; so threads change nothing.

mod smooth;

use crate::camera::Frame;
use crate::light::{self, Air, SUN_RADIUS};
use crate::sample::{Skies, Suns, across, hammersley};
use crate::view::{Hit, View};
use crate::{Camera, Image, Stage};
use rayon::prelude::*;
use rockfall_collide::Ray;
use rockfall_math::{DVec3, Vec2, Vec3};
use smooth::smooth;

/// How much work goes into a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Quality {
    /// To see what is there: edges are not smoothed, shadows and sky are coarse.
    Draft,
    /// For the eye.
    #[default]
    Standard,
    /// For the wall.
    Fine,
}

impl Quality {
    /// Rays to the sun from each pixel at the border of a shadow, and rays to the sky from each pixel.
    fn rays(self) -> [u32; 2] {
        match self {
            Quality::Draft => [1, 1],
            Quality::Standard => [4, 2],
            Quality::Fine => [16, 8],
        }
    }

    /// Places at which pixels at edges are looked at.
    fn places(self) -> u32 {
        match self {
            Quality::Draft => 0,
            Quality::Standard => 4,
            Quality::Fine => 16,
        }
    }
}

/// How a picture is taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shot {
    /// Pixels in a row, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// How much work goes into it.
    pub quality: Quality,
    /// The air between.
    pub air: Air,
}

/// What the middle of a pixel shows.
#[derive(Clone, Copy)]
struct Spot {
    /// Distance from the eye; infinite where there is sky.
    t: f64,
    normal: Vec3,
    actor: u32,
}

impl Spot {
    const SKY: Spot = Spot { t: f64::INFINITY, normal: Vec3::ZERO, actor: u32::MAX };

    fn of(hit: Option<Hit>) -> Self {
        hit.map_or(Spot::SKY, |Hit { t, normal, actor }| Spot { t, normal, actor })
    }

    fn is_sky(&self) -> bool {
        self.t == f64::INFINITY
    }
}

/// Shares of sun and sky that a spot sees, from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seen {
    sun: f32,
    sky: f32,
}

/// Pixels that one task takes at least.
const GRAIN: usize = 256;

/// How far a ray to the sky looks for what is in its way, in sizes of the usual actor, and at least as a share of the distance from the eye.
const NEAR: f64 = 24.0;
const NEAR_SHARE: f64 = 0.05;

/// Neighbours whose normals have at least this cosine between them lie on one surface.
const SAME: f32 = 0.9;

/// At edges, a part of the same body whose normal has at least this cosine lends its light.
const ALIKE: f32 = 0.6;

/// A picture of a stage through a camera.
pub fn render(stage: &Stage, camera: &Camera, shot: &Shot) -> Image {
    let (width, height) = (shot.width.max(1), shot.height.max(1));
    let view = View::new(stage, camera.eye);
    let [suns, skies] = shot.quality.rays();
    let pass = Pass {
        view: &view,
        stage,
        frame: camera.frame(width, height),
        width,
        height,
        air: shot.air,
        suns: Suns::new(suns),
        skies: Skies::new(skies),
        places: shot.quality.places(),
    };
    let spots = pass.each(|x, y| pass.spot(f64::from(x) + 0.5, f64::from(y) + 0.5));
    let first = pass.each(|x, y| pass.look(&spots[pass.index(x, y)], pass.middle(x, y), x, y));
    let raw = pass.each(|x, y| pass.look_again(&spots, &first, x, y));
    let seen = pass.each(|x, y| smooth(&pass, &spots, &raw, x, y));
    let light = pass.each(|x, y| pass.pixel(&spots, &seen, x, y).to_array());
    Image { width, height, light, depth: spots.iter().map(|spot| spot.t as f32).collect() }
}

/// What all passes over the pixels know.
struct Pass<'a> {
    view: &'a View<'a>,
    stage: &'a Stage,
    frame: Frame,
    width: u32,
    height: u32,
    air: Air,
    suns: Suns,
    skies: Skies,
    places: u32,
}

impl Pass<'_> {
    /// Something of each pixel, row by row.
    fn each<T: Send>(&self, f: impl Fn(u32, u32) -> T + Sync) -> Vec<T> {
        let width = self.width as usize;
        let pixels = (0..width * self.height as usize).into_par_iter();
        pixels.with_min_len(GRAIN).map(|k| f((k % width) as u32, (k / width) as u32)).collect()
    }

    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }

    /// The direction through the middle of a pixel.
    fn middle(&self, x: u32, y: u32) -> DVec3 {
        self.frame.direction(f64::from(x) + 0.5, f64::from(y) + 0.5)
    }

    fn spot(&self, x: f64, y: f64) -> Spot {
        let ray = Ray { origin: DVec3::ZERO, direction: self.frame.direction(x, y), max: f64::INFINITY };
        Spot::of(self.view.first(&ray))
    }

    /// What a spot in a direction sees of the sky, and whether it sees the sun, by the rays of the pixel (x, y).
    fn look(&self, spot: &Spot, direction: DVec3, x: u32, y: u32) -> Seen {
        if spot.is_sky() {
            return Seen { sun: 1.0, sky: 1.0 };
        }
        let origin = self.off(spot, direction);
        let normal = spot.normal.as_dvec3();
        let [side, other] = across(normal);
        let max = (NEAR * f64::from(self.view.usual)).max(NEAR_SHARE * spot.t);
        let mut open = 0;
        for d in self.skies.of(x, y) {
            let direction = f64::from(d.x) * side + f64::from(d.y) * other + f64::from(d.z) * normal;
            open += u32::from(!self.view.blocked(&Ray { origin, direction, max }));
        }
        Seen {
            sun: self.sun(spot, origin, &self.suns.of(x, y)[..1]),
            sky: open as f32 / self.skies.each() as f32,
        }
    }

    /// The same with more rays to the sun, where a neighbour sees more of it or less.
    fn look_again(&self, spots: &[Spot], first: &[Seen], x: u32, y: u32) -> Seen {
        let here = self.index(x, y);
        let (spot, seen) = (&spots[here], first[here]);
        let points = self.suns.of(x, y);
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
        let mut beside = around.filter_map(|(dx, dy)| self.beside(x, y, dx, dy));
        // The sky is no surface: what is before it need not be at the border of a shadow.
        let differs = |(x, y): (u32, u32)| {
            let index = self.index(x, y);
            !spots[index].is_sky() && first[index].sun != seen.sun
        };
        if spot.is_sky() || points.len() == 1 || !beside.any(differs) {
            return seen;
        }
        Seen { sun: self.sun(spot, self.off(spot, self.middle(x, y)), points), ..seen }
    }

    /// A little off the surface at a spot, by more than the place is known to, so that it is not in its own shadow.
    fn off(&self, spot: &Spot, direction: DVec3) -> DVec3 {
        let slack = 2e-6 * spot.t + 1e-5 * f64::from(self.view.usual);
        spot.t * direction + slack * spot.normal.as_dvec3()
    }

    /// The share of the sun that a spot sees, by these points of its disc.
    fn sun(&self, spot: &Spot, origin: DVec3, points: &[Vec2]) -> f32 {
        let sun = light::sun();
        if spot.normal.as_dvec3().dot(sun) <= 0.0 {
            return 0.0;
        }
        let [side, other] = across(sun);
        let free = points.iter().filter(|point| {
            let [a, b] = [point.x, point.y].map(|v| SUN_RADIUS * f64::from(v));
            let ray = Ray { origin, direction: sun + a * side + b * other, max: f64::INFINITY };
            !self.view.blocked(&ray)
        });
        free.count() as f32 / points.len() as f32
    }

    /// The light that comes from a spot.
    fn light(&self, spot: &Spot, direction: DVec3, seen: Seen) -> Vec3 {
        if spot.is_sky() {
            return light::sky(direction);
        }
        let color = Vec3::from_array(self.stage.actors[spot.actor as usize].color);
        let light = light::shade(color, spot.normal, -direction.as_vec3(), seen.sun, seen.sky);
        self.air.veil(light, direction, spot.t)
    }

    /// The light of a pixel: that of its middle, or, at edges, of several places.
    fn pixel(&self, spots: &[Spot], seen: &[Seen], x: u32, y: u32) -> Vec3 {
        let here = self.index(x, y);
        if self.places == 0 || !self.is_edge(spots, x, y) {
            return self.light(&spots[here], self.middle(x, y), seen[here]);
        }
        let mut sum = Vec3::ZERO;
        for k in 0..self.places {
            let (a, b) = hammersley(k, self.places);
            let (px, py) = (f64::from(x) + f64::from(a), f64::from(y) + f64::from(b));
            let direction = self.frame.direction(px, py);
            let spot = self.spot(px, py);
            let near = self.lit_alike(spots, seen, &spot, x, y);
            let seen = near.unwrap_or_else(|| self.look(&spot, direction, x + k, y + 2 * k));
            sum += self.light(&spot, direction, seen);
        }
        sum / self.places as f32
    }

    /// Whether a pixel shows another surface than one beside it.
    fn is_edge(&self, spots: &[Spot], x: u32, y: u32) -> bool {
        let here = &spots[self.index(x, y)];
        let direction = self.middle(x, y);
        let beside = [(-1, 0), (1, 0), (0, -1), (0, 1)].map(|(dx, dy)| self.beside(x, y, dx, dy));
        beside.into_iter().flatten().any(|(x, y)| {
            let there = &spots[self.index(x, y)];
            there.actor != here.actor || !(here.is_sky() || self.one_surface(here, direction, there, x, y))
        })
    }

    /// The pixel at an offset, if it is in the picture.
    fn beside(&self, x: u32, y: u32, dx: i32, dy: i32) -> Option<(u32, u32)> {
        let (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
        (x < self.width && y < self.height).then_some((x, y))
    }

    /// Whether the spot in a direction lies on the surface that the middle of the pixel (x, y) shows.
    fn one_surface(&self, spot: &Spot, direction: DVec3, there: &Spot, x: u32, y: u32) -> bool {
        if there.is_sky() || spot.is_sky() || spot.normal.dot(there.normal) < SAME {
            return false;
        }
        let between = there.t * self.middle(x, y) - spot.t * direction;
        // Out of the plane of either by no more than a few pixels.
        let off = |normal: Vec3| between.dot(normal.as_dvec3()).abs();
        off(spot.normal).max(off(there.normal)) <= 2.0 * self.frame.pixel * spot.t
    }

    /// What was seen from the surface of a spot by the pixel or one beside it, if one of them shows it, or a side of the body that faces nearly the same way.
    fn lit_alike(&self, spots: &[Spot], seen: &[Seen], spot: &Spot, x: u32, y: u32) -> Option<Seen> {
        if spot.is_sky() {
            return Some(Seen { sun: 1.0, sky: 1.0 });
        }
        // The one that faces most nearly the same way; as many as face quite another way see something else.
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
        let alike = around.filter_map(|(dx, dy)| self.beside(x, y, dx, dy)).filter_map(|(x, y)| {
            let index = self.index(x, y);
            let there = &spots[index];
            let cosine = if there.is_sky() { -1.0 } else { there.normal.dot(spot.normal) };
            (there.actor == spot.actor && cosine > ALIKE).then_some((cosine, index))
        });
        let best = alike.reduce(|best, one| if one.0 > best.0 { one } else { best });
        best.map(|(_, index)| seen[index])
    }
}
