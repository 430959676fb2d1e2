//! **Rockfall**: very many rigid bodies in hard contact.

mod body;
mod error;
mod material;
mod report;
mod settings;
mod world;

pub use body::{Body, BodyId, Kind, Locks, MassOverride};
pub use error::Error;
pub use material::{Material, Mix};
pub use report::{STAGES, StepReport};
pub use rockfall_math as math;
pub use rockfall_shape as shape;
pub use rockfall_shape::Shape;
pub use settings::{Settings, Solver};
pub use world::{Contact, MaterialId, ShapeId, World};
