//! What is known of bodies at one moment, whether a world simulates them or a run has kept them.

mod between;
mod run;
mod world;

pub use run::Recorded;

use crate::{Actor, Stage};
use rockfall::{Kind, Shape};
use rockfall_cache::Contacts;
use rockfall_math::{DVec3, Pose, Vec3};
use std::collections::BTreeMap;

/// Bodies at a moment, and what else is known of them. Sensors are nothing to look at, and left out.
#[derive(Clone, Debug)]
pub struct Sight {
    /// Number of the frame.
    pub frame: u64,
    /// Simulated seconds.
    pub time: f64,
    /// Seconds between two frames.
    pub step: f64,
    /// All shapes that bodies have, and the meshes that are seen in place of some.
    pub shapes: Vec<Shape>,
    /// Names of all materials.
    pub materials: Vec<String>,
    /// The colour of each material, where the scene gives it one: linear red, green and blue from 0 to 1.
    pub colors: Vec<Option<[f32; 3]>>,
    /// The bodies, by their ids.
    pub bodies: Vec<Seen>,
    /// Ids of those that have a name.
    pub names: BTreeMap<String, u64>,
    /// Which of them are asleep, in the same order.
    pub asleep: Known<Vec<bool>>,
    /// Sum of the normal forces on each of them, N.
    pub forces: Known<Vec<f32>>,
    /// What touches, from `origin`.
    pub contacts: Known<Contacts>,
    /// Where the positions of contacts start from, metres.
    pub origin: DVec3,
}

/// Something that is known, or the reason why it isn't: a sentence without its end.
pub type Known<T> = Result<T, String>;

/// A body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// Its id.
    pub id: u64,
    /// Index of its shape.
    pub shape: u32,
    /// Index of what is seen of it: its shape, or a mesh in its place.
    pub shown: u32,
    /// Its colour, where the scene gives it or its shape one: linear red, green and blue from 0 to 1.
    pub color: Option<[f32; 3]>,
    /// Index of its material.
    pub material: u32,
    /// Who moves it.
    pub kind: Kind,
    /// Of the frame of its shape.
    pub pose: Pose,
    /// Its centre of mass; the origin of its shape where it is not dynamic. Metres.
    pub center: DVec3,
    /// Of the centre of mass, m/s.
    pub velocity: Vec3,
    /// Angular velocity, rad/s, world axes.
    pub spin: Vec3,
}

/// Nothing at all.
impl Default for Sight {
    fn default() -> Self {
        let nothing = || "nothing is seen".to_owned();
        Sight {
            frame: 0,
            time: 0.0,
            step: 0.0,
            shapes: Vec::new(),
            materials: Vec::new(),
            colors: Vec::new(),
            bodies: Vec::new(),
            names: BTreeMap::new(),
            asleep: Err(nothing()),
            forces: Err(nothing()),
            contacts: Err(nothing()),
            origin: DVec3::ZERO,
        }
    }
}

impl Sight {
    /// The bodies in the colours of `colors`, as many as there are bodies.
    pub fn stage(&self, colors: &[[f32; 3]]) -> Stage {
        let actor = |(body, color): (&Seen, &[f32; 3])| Actor {
            shape: body.shown,
            pose: body.pose,
            color: *color,
            moves: body.kind != Kind::Static,
        };
        Stage { shapes: self.shapes.clone(), actors: self.bodies.iter().zip(colors).map(actor).collect() }
    }

    /// The colour that the scene gives a material.
    pub(crate) fn color_of(&self, material: u32) -> Option<[f32; 3]> {
        self.colors.get(material as usize).copied().flatten()
    }

    /// The row of a body.
    pub(crate) fn row(&self, id: u64) -> Option<usize> {
        self.bodies.binary_search_by_key(&id, |body| body.id).ok()
    }
}
