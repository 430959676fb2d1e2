//! **Rockfall**: very many rigid bodies in hard contact.

#![forbid(unsafe_code)]

mod ahead;
mod apply;
mod bodies;
mod body;
mod bound;
mod error;
mod events;
mod index;
mod inherit;
mod link;
mod material;
mod measure;
mod pair;
mod recall;
mod recognise;
mod report;
mod seam;
mod settings;
mod settle;
mod sleep;
mod slender;
mod slots;
mod sweep;
mod touch;
mod touches;
mod world;

pub use body::{Body, BodyId, Kind, Locks, MassOverride};
pub use error::Error;
pub use events::{ContactForce, Events, Hit, Pair, Presence, Watch};
pub use material::{Material, Mix};
pub use report::{Invariant, STAGES, StepReport};
pub use rockfall_collide::INSIDE;
pub use rockfall_math as math;
pub use rockfall_math::snapshot;
pub use rockfall_shape as shape;
pub use rockfall_shape::Shape;
pub use settings::{Integrator, Quality, Settings, Solver};
pub use world::query::{Cast, CastHit, Filter, Lists, Movers, Penetration, PointHit, Ray, RayHit};
pub use world::{Contact, MaterialId, ShapeId, Spring, World};

/// The examples of the guide are tests.
#[cfg(doctest)]
#[doc = include_str!("../../../docs/queries.md")]
#[doc = include_str!("../../../docs/events.md")]
struct Guide;
