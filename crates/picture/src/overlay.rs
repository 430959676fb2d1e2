//! What is drawn over a picture: contacts, boxes, ways. Things that are behind something shine through it faintly.

use crate::camera::Frame;
use crate::draw::{Ink, text_size};
use crate::{Camera, Error, Image, Picture, Sight};
use rockfall::Kind;
use rockfall_math::{Aabb, DVec3, Vec3};

/// What can be drawn over a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Overlay {
    /// A dot at each point of contact.
    Contacts,
    /// The normal of each contact, as long as half of the usual body.
    Normals,
    /// The normal force of each contact: the larger the longer, the largest as long as two usual bodies.
    Impulses,
    /// The box around each body that can move.
    Bounds,
    /// The centre of mass of each body that can move.
    Centres,
    /// The way in the last frame of the centre of each body that moved by more than its inner radius.
    Paths,
}

const CONTACT: [f32; 3] = [255.0, 214.0, 64.0];
const NORMAL: [f32; 3] = [96.0, 214.0, 255.0];
const IMPULSE: [f32; 3] = [255.0, 92.0, 72.0];
const BOUNDS: [f32; 3] = [240.0, 244.0, 248.0];
const CENTRE: [f32; 3] = [255.0, 120.0, 220.0];
const PATH: [f32; 3] = [150.0, 255.0, 130.0];

/// How much of what is behind something shines through.
const BEHIND: f32 = 0.28;

/// A straight line of an overlay; a dot where both ends are one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    /// Metres.
    pub from: DVec3,
    /// Metres.
    pub to: DVec3,
    /// In the pixels of a small picture; the diameter of a dot.
    pub width: f64,
    /// sRGB, each from 0 to 255.
    pub color: [f32; 3],
}

impl Stroke {
    fn line(from: DVec3, to: DVec3, width: f64, color: [f32; 3]) -> Self {
        Stroke { from, to, width, color }
    }

    fn dot(at: DVec3, radius: f64, color: [f32; 3]) -> Self {
        Stroke::line(at, at, 2.0 * radius, color)
    }
}

impl Overlay {
    /// All of them with their words, for people who ask for one.
    pub const WORDS: [(&'static str, Overlay); 6] = [
        ("contacts", Overlay::Contacts),
        ("normals", Overlay::Normals),
        ("impulses", Overlay::Impulses),
        ("bounds", Overlay::Bounds),
        ("centres", Overlay::Centres),
        ("paths", Overlay::Paths),
    ];

    /// Draws it over the picture of `sight` that `camera` took.
    ///
    /// # Errors
    /// [`Error::Unknown`] where what is seen has no contacts.
    pub fn draw(
        self,
        picture: &mut Picture,
        image: &Image,
        camera: &Camera,
        sight: &Sight,
    ) -> Result<(), Error> {
        let mut pen = Pen {
            depth: &image.depth,
            frame: camera.frame(picture.width, picture.height),
            size: text_size(picture.height) as f64,
            picture,
        };
        self.strokes(sight)?.iter().for_each(|stroke| pen.draw(stroke));
        Ok(())
    }

    /// What is drawn.
    ///
    /// # Errors
    /// [`Error::Unknown`] where what is seen has no contacts.
    pub fn strokes(self, sight: &Sight) -> Result<Vec<Stroke>, Error> {
        let mut strokes = Vec::new();
        match self {
            Overlay::Contacts | Overlay::Normals | Overlay::Impulses => return self.contacts(sight),
            Overlay::Bounds => {
                for body in sight.bodies.iter().filter(|body| body.kind != Kind::Static) {
                    let Some(shape) = sight.shapes.get(body.shape as usize) else { continue };
                    // Far from the origin single precision is too coarse for a box.
                    let near = rockfall_math::Pose { position: DVec3::ZERO, ..body.pose };
                    bounds(body.pose.position, &shape.placed_bounds(&near), &mut strokes);
                }
            }
            Overlay::Centres => {
                for body in sight.bodies.iter().filter(|body| body.kind == Kind::Dynamic) {
                    strokes.push(Stroke::dot(body.center, 2.5, CENTRE));
                }
            }
            Overlay::Paths => {
                for body in sight.bodies.iter().filter(|body| body.kind != Kind::Static) {
                    let Some(shape) = sight.shapes.get(body.shape as usize) else { continue };
                    let way = body.velocity.as_dvec3() * sight.step;
                    if way.length() > f64::from(shape.inner_radius()) {
                        strokes.push(Stroke::line(body.center - way, body.center, 1.5, PATH));
                        strokes.push(Stroke::dot(body.center, 2.0, PATH));
                    }
                }
            }
        }
        Ok(strokes)
    }

    fn contacts(self, sight: &Sight) -> Result<Vec<Stroke>, Error> {
        let contacts = match &sight.contacts {
            Ok(contacts) => contacts,
            Err(why) => return Err(Error::Unknown { what: "contacts", why: why.clone() }),
        };
        let usual = usual(sight);
        let largest = contacts.forces.iter().copied().fold(0.0, f32::max);
        let points = contacts.positions.iter().zip(&contacts.normals).zip(&contacts.forces);
        let mut strokes = Vec::new();
        for ((position, normal), force) in points {
            let at = sight.origin + Vec3::from_array(*position).as_dvec3();
            let normal = Vec3::from_array(*normal).as_dvec3();
            match self {
                Overlay::Normals => strokes.push(Stroke::line(at, at + 0.5 * usual * normal, 1.0, NORMAL)),
                Overlay::Impulses if largest > 0.0 => {
                    // On both sides alike: a force presses both bodies.
                    let half = usual * f64::from(force / largest).sqrt() * normal;
                    strokes.push(Stroke::line(at - half, at + half, 1.5, IMPULSE));
                }
                Overlay::Impulses => {}
                _ => strokes.push(Stroke::dot(at, 2.0, CONTACT)),
            }
        }
        Ok(strokes)
    }
}

/// The edges of a box.
fn bounds(at: DVec3, area: &Aabb, strokes: &mut Vec<Stroke>) {
    let corner = |k: u32| {
        let pick = |axis: usize| if k >> axis & 1 == 0 { area.min[axis] } else { area.max[axis] };
        at + Vec3::new(pick(0), pick(1), pick(2)).as_dvec3()
    };
    for k in 0..8_u32 {
        for other in [1, 2, 4].map(|bit| k | bit).into_iter().filter(|&other| other != k) {
            strokes.push(Stroke::line(corner(k), corner(other), 1.0, BOUNDS));
        }
    }
}

/// The radius of the usual body that moves, metres.
fn usual(sight: &Sight) -> f64 {
    let radius = |shape: &rockfall::Shape| shape.radius_about(shape.bounds().center());
    let of_shapes: Vec<f32> = sight.shapes.iter().map(radius).collect();
    let moving = sight.bodies.iter().filter(|body| body.kind != Kind::Static);
    let mut sizes: Vec<f32> = moving.filter_map(|body| of_shapes.get(body.shape as usize).copied()).collect();
    if sizes.is_empty() {
        return 1.0;
    }
    let middle = sizes.len() / 2;
    f64::from(*sizes.select_nth_unstable_by(middle, f32::total_cmp).1)
}

struct Pen<'a> {
    picture: &'a mut Picture,
    depth: &'a [f32],
    frame: Frame,
    size: f64,
}

impl Pen<'_> {
    fn draw(&mut self, &Stroke { from: a, to: b, width, color }: &Stroke) {
        // One that begins behind the eye is left out: it is nothing that one looks at.
        let (Some((from, near)), Some((to, far))) = (self.frame.project(a), self.frame.project(b)) else {
            return;
        };
        let depth = self.depth;
        self.picture.line(from, to, width * self.size, |picture, x, y, along| {
            let distance = near + along * (far - near);
            let index = y.max(0) as usize * picture.width as usize + x.max(0) as usize;
            let seen = depth.get(index).is_none_or(|&surface| distance <= 1.002 * f64::from(surface));
            Ink::new(color, if seen { 0.95 } else { BEHIND })
        });
    }
}
