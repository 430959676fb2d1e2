//! Pictures and films of Rockfall, traced on the engine's own tree and ray casts.
#![forbid(unsafe_code)]

mod camera;
mod course;
mod draw;
mod error;
mod expose;
mod font;
mod image;
mod legend;
mod light;
mod overlay;
mod paint;
mod picture;
mod ramp;
mod render;
mod sample;
mod sheet;
mod sight;
mod stage;
mod take;
mod tone;
mod view;

pub use camera::{Camera, Lens};
pub use error::Error;
pub use expose::Shutter;
pub use image::Image;
pub use legend::{Legend, Span, caption};
pub use light::Air;
pub use overlay::{Overlay, Stroke};
pub use paint::ColorBy;
pub use picture::Picture;
pub use ramp::{hue, ramp, stone};
pub use render::{Quality, Shot, render};
pub use sheet::sheet;
pub use sight::{Known, Recorded, Seen, Sight};
pub use stage::{Actor, Stage};
pub use take::{Look, take, take_open};
pub use tone::{curve, encode, tone};
