//! Takes a picture of a stage.
//!
//! 1. One ray through the middle of each pixel finds what is there.
//! 2. A few rays from there look for the sun and the sky ([`Skies`], [`Suns`]); where neighbours don't agree about the sun, at the border of a shadow, more look for it.
//! 3. What they saw is shared by neighbours on the same surface (`smooth`).
//! 4. Pixels at edges are looked at again at several places. What lies on a surface next to it that has been lit takes the light from there, since light
//!    changes slowly where edges don't.
//!
//! Each pixel depends on the stage and on pixels of earlier passes alone; so threads change nothing.

mod bands;
mod smooth;

use crate::camera::Frame;
use crate::light::{self, Air, SUN_RADIUS};
use crate::sample::{Skies, Suns, across, hammersley};
use crate::view::{Beam, Hit, Tile, View};
use crate::{Camera, Image, Stage};
use bands::{Step, each};
use rockfall_math::lanes::Lanes;
use rockfall_math::{DVec3, Vec2, Vec3};

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

    /// Of so many pixels in a row and so many rows one looks for sun and sky; the others take what it saw.
    fn stride(self) -> u32 {
        match self {
            Quality::Draft => 2,
            Quality::Standard | Quality::Fine => 1,
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
#[derive(Clone, Copy, Debug, PartialEq)]
struct Spot {
    /// Relative to the eye, metres.
    place: Vec3,
    /// Distance from the eye; infinite where there is sky.
    t: f32,
    normal: Vec3,
    actor: u32,
}

impl Spot {
    const SKY: Spot = Spot { place: Vec3::ZERO, t: f32::INFINITY, normal: Vec3::ZERO, actor: u32::MAX };

    fn is_sky(&self) -> bool {
        self.t == f32::INFINITY
    }
}

/// Shares of sun and sky that a spot sees, from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Seen {
    sun: f32,
    sky: f32,
}

impl Seen {
    const ALL: Seen = Seen { sun: 1.0, sky: 1.0 };
}

/// How far a beam to the sky looks for what is in its way, in sizes of the usual actor, and at least as a share of the distance from the eye.
const NEAR: f32 = 24.0;
const NEAR_SHARE: f32 = 0.05;

/// Neighbours whose normals have at least this cosine between them lie on one surface.
const SAME: f32 = 0.9;

/// At edges, a part of the same body whose normal has at least this cosine lends its light.
const ALIKE: f32 = 0.6;

/// A picture of a stage through a camera.
pub fn render(stage: &Stage, camera: &Camera, shot: &Shot) -> Image {
    render_at(stage, camera, shot, [0.0; 2])
}

/// The same with pixels moved to the right and downwards by parts of one.
pub(crate) fn render_at(stage: &Stage, camera: &Camera, shot: &Shot, shift: [f64; 2]) -> Image {
    let (width, height) = (shot.width.max(1), shot.height.max(1));
    let view = View::new(stage, camera.eye);
    let [suns, skies] = shot.quality.rays();
    let pass = Pass {
        view: &view,
        stage,
        frame: camera.shifted(width, height, shift),
        width,
        height,
        air: shot.air,
        stride: shot.quality.stride(),
        suns: Suns::new(suns),
        skies: Skies::new(skies),
        places: shot.quality.places(),
    };
    let spots = each(width, height, Spot::SKY, &First(&pass));
    let mut raw = each(width, height, Seen::ALL, &Look { pass: &pass, spots: &spots });
    if suns > 1 {
        raw = each(width, height, Seen::ALL, &LookAgain { pass: &pass, spots: &spots, first: &raw });
    }
    let seen = each(width, height, Seen::ALL, &smooth::Smooth { pass: &pass, spots: &spots, raw: &raw });
    let light = each(width, height, [0.0; 3], &Light { pass: &pass, spots: &spots, seen: &seen });
    Image { width, height, light, depth: spots.iter().map(|spot| spot.t).collect() }
}

/// What all passes over the pixels know.
struct Pass<'a> {
    view: &'a View<'a>,
    stage: &'a Stage,
    frame: Frame,
    width: u32,
    height: u32,
    air: Air,
    stride: u32,
    suns: Suns,
    skies: Skies,
    places: u32,
}

/// What is in the middle of each pixel.
struct First<'a>(&'a Pass<'a>);

impl Step for First<'_> {
    type Out = Spot;
    type Tile = Tile;

    #[inline(always)]
    fn tile<L: Lanes>(&self, token: L::Token, low: [u32; 2], high: [u32; 2]) -> Tile {
        self.0.tile::<L>(token, low, high)
    }

    #[inline(always)]
    fn at<L: Lanes>(&self, token: L::Token, tile: &Tile, x: u32, y: u32) -> Spot {
        self.0.spot::<L>(token, tile, f64::from(x) + 0.5, f64::from(y) + 0.5)
    }
}

/// What pixels see of sun and sky.
struct Look<'a> {
    pass: &'a Pass<'a>,
    spots: &'a [Spot],
}

impl Step for Look<'_> {
    type Out = Seen;
    type Tile = ();

    #[inline(always)]
    fn tile<L: Lanes>(&self, _: L::Token, _: [u32; 2], _: [u32; 2]) {}

    #[inline(always)]
    fn at<L: Lanes>(&self, token: L::Token, (): &(), x: u32, y: u32) -> Seen {
        let stride = self.pass.stride;
        if !x.is_multiple_of(stride) || !y.is_multiple_of(stride) {
            return Seen::ALL;
        }
        self.pass.look::<L>(token, &self.spots[self.pass.index(x, y)], x / stride, y / stride)
    }
}

/// The same with more beams to the sun, where a neighbour sees more of it or less.
struct LookAgain<'a> {
    pass: &'a Pass<'a>,
    spots: &'a [Spot],
    first: &'a [Seen],
}

impl Step for LookAgain<'_> {
    type Out = Seen;
    type Tile = ();

    #[inline(always)]
    fn tile<L: Lanes>(&self, _: L::Token, _: [u32; 2], _: [u32; 2]) {}

    #[inline(always)]
    fn at<L: Lanes>(&self, token: L::Token, (): &(), x: u32, y: u32) -> Seen {
        let LookAgain { pass, spots, first } = self;
        let here = pass.index(x, y);
        let (spot, seen) = (&spots[here], first[here]);
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
        let mut beside = around.filter_map(|(dx, dy)| pass.beside(x, y, dx, dy));
        // The sky is no surface: what is before it need not be at the border of a shadow.
        let differs = |(x, y): (u32, u32)| {
            let index = pass.index(x, y);
            !spots[index].is_sky() && first[index].sun != seen.sun
        };
        if spot.is_sky() || !beside.any(differs) {
            return seen;
        }
        Seen { sun: pass.sun::<L>(token, spot, pass.suns.of(x, y)), ..seen }
    }
}

/// The light of a pixel: that of its middle, or, at edges, of several places.
struct Light<'a> {
    pass: &'a Pass<'a>,
    spots: &'a [Spot],
    seen: &'a [Seen],
}

impl Step for Light<'_> {
    type Out = [f32; 3];
    type Tile = Tile;

    #[inline(always)]
    fn tile<L: Lanes>(&self, token: L::Token, low: [u32; 2], high: [u32; 2]) -> Tile {
        self.pass.tile::<L>(token, low, high)
    }

    #[inline(always)]
    fn at<L: Lanes>(&self, token: L::Token, tile: &Tile, x: u32, y: u32) -> [f32; 3] {
        let Light { pass, spots, seen } = self;
        let here = pass.index(x, y);
        if pass.places == 0 || !pass.is_edge(spots, x, y) {
            return pass.light(&spots[here], pass.middle(x, y), seen[here]).to_array();
        }
        let mut sum = Vec3::ZERO;
        for k in 0..pass.places {
            let (a, b) = hammersley(k, pass.places);
            let (px, py) = (f64::from(x) + f64::from(a), f64::from(y) + f64::from(b));
            let spot = pass.spot::<L>(token, tile, px, py);
            let near = pass.lit_alike(spots, seen, &spot, x, y);
            let seen = match near {
                Some(seen) => seen,
                None => pass.look::<L>(token, &spot, x + k, y + 2 * k),
            };
            sum += pass.light(&spot, pass.frame.direction(px, py), seen);
        }
        (sum / pass.places as f32).to_array()
    }
}

impl Pass<'_> {
    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }

    /// The direction through the middle of a pixel.
    fn middle(&self, x: u32, y: u32) -> DVec3 {
        self.frame.direction(f64::from(x) + 0.5, f64::from(y) + 0.5)
    }

    /// What pixels from `low` up to `high` can show.
    #[inline(always)]
    fn tile<L: Lanes>(&self, token: L::Token, low: [u32; 2], high: [u32; 2]) -> Tile {
        // A little wider than they are, so that rounding leaves nothing out.
        let ([left, top], [right, bottom]) =
            (low.map(|x| f64::from(x) - 0.02), high.map(|x| f64::from(x) + 0.02));
        let edge = |x: f64, y: f64| self.frame.direction(x, y).as_vec3();
        self.view
            .tile::<L>(token, [edge(left, top), edge(right, top), edge(right, bottom), edge(left, bottom)])
    }

    #[inline(always)]
    fn spot<L: Lanes>(&self, token: L::Token, tile: &Tile, x: f64, y: f64) -> Spot {
        let direction = self.frame.direction(x, y).as_vec3();
        let beam = Beam::new(Vec3::ZERO, direction, f32::INFINITY);
        match self.view.first_of::<L>(token, &beam, tile) {
            Some(Hit { t, normal, actor }) => Spot { place: t * direction, t, normal, actor },
            None => Spot::SKY,
        }
    }

    /// What a spot sees of the sky, and whether it sees the sun, by the beams of the pixel (x, y).
    #[inline(always)]
    fn look<L: Lanes>(&self, token: L::Token, spot: &Spot, x: u32, y: u32) -> Seen {
        if spot.is_sky() {
            return Seen::ALL;
        }
        let origin = self.off(spot);
        let [side, other] = across(spot.normal);
        let max = (NEAR * self.view.usual).max(NEAR_SHARE * spot.t);
        let mut open = 0;
        for d in self.skies.of(x, y) {
            let direction = d.x * side + d.y * other + d.z * spot.normal;
            open += u32::from(!self.view.blocked::<L>(token, &Beam::new(origin, direction, max)));
        }
        Seen {
            sun: self.sun::<L>(token, spot, &self.suns.of(x, y)[..1]),
            sky: open as f32 / self.skies.each() as f32,
        }
    }

    /// A little off the surface at a spot, by more than the place is known to, so that it is not in its own shadow.
    fn off(&self, spot: &Spot) -> Vec3 {
        let slack = 2e-6 * spot.t + 1e-5 * self.view.usual;
        spot.place + slack * spot.normal
    }

    /// The share of the sun that a spot sees, by these points of its disc.
    #[inline(always)]
    fn sun<L: Lanes>(&self, token: L::Token, spot: &Spot, points: &[Vec2]) -> f32 {
        let sun = light::sun();
        if spot.normal.dot(sun) <= 0.0 {
            return 0.0;
        }
        let (origin, [side, other]) = (self.off(spot), across(sun));
        let mut free = 0;
        for point in points {
            let direction = sun + SUN_RADIUS * (point.x * side + point.y * other);
            free += u32::from(!self.view.blocked::<L>(token, &Beam::new(origin, direction, f32::INFINITY)));
        }
        free as f32 / points.len() as f32
    }

    /// The light that comes from a spot.
    fn light(&self, spot: &Spot, direction: DVec3, seen: Seen) -> Vec3 {
        if spot.is_sky() {
            return light::sky(direction);
        }
        let color = Vec3::from_array(self.stage.actors[spot.actor as usize].color);
        let light = light::shade(color, spot.normal, -direction.as_vec3(), seen.sun, seen.sky);
        self.air.veil(light, direction, spot.t.into())
    }

    /// Whether a pixel shows another surface than one beside it.
    fn is_edge(&self, spots: &[Spot], x: u32, y: u32) -> bool {
        let here = &spots[self.index(x, y)];
        let beside = [(-1, 0), (1, 0), (0, -1), (0, 1)].map(|(dx, dy)| self.beside(x, y, dx, dy));
        beside.into_iter().flatten().any(|(x, y)| {
            let there = &spots[self.index(x, y)];
            there.actor != here.actor || !(here.is_sky() || self.one_surface(here, there))
        })
    }

    /// The pixel at an offset, if it is in the picture.
    fn beside(&self, x: u32, y: u32, dx: i32, dy: i32) -> Option<(u32, u32)> {
        let (x, y) = (x.checked_add_signed(dx)?, y.checked_add_signed(dy)?);
        (x < self.width && y < self.height).then_some((x, y))
    }

    /// Whether two spots lie on one surface.
    fn one_surface(&self, here: &Spot, there: &Spot) -> bool {
        if there.is_sky() || here.is_sky() || here.normal.dot(there.normal) < SAME {
            return false;
        }
        let between = there.place - here.place;
        // Out of the plane of either by no more than a few pixels.
        let off = |normal: Vec3| between.dot(normal).abs();
        off(here.normal).max(off(there.normal)) <= 2.0 * self.frame.pixel as f32 * here.t
    }

    /// What was seen from the surface of a spot by the pixel or one beside it, if one of them shows it, or a side of the body that faces nearly the same way.
    fn lit_alike(&self, spots: &[Spot], seen: &[Seen], spot: &Spot, x: u32, y: u32) -> Option<Seen> {
        if spot.is_sky() {
            return Some(Seen::ALL);
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
