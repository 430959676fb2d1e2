//! A writer of OpenUSD's binary files, called `usdc` or crate files.
//!
//! A [`Layer`] is a tree of [`Prim`]s with attributes and relationships. [`Writer`] takes it when all is known; samples of attributes, which are
//! most of a file, go to the disk as they come, so that memory does not grow with them.
//!
//! ```no_run
//! use rockfall_usd::{Array, Attribute, Layer, Prim, Value, Writer};
//!
//! let mut writer = Writer::create("points.usdc".as_ref())?;
//! for frame in 0..10 {
//!     let points = Array::Float3(vec![[frame as f32, 0.0, 0.0]; 1000]);
//!     writer.sample("/Points.points", frame.into(), &points)?;
//! }
//! let prim = Prim::def("Points", "Points").with(Attribute::sampled("point3f[]", "points"));
//! let metadata = vec![("upAxis", Value::Token("Z".into())), ("metersPerUnit", Value::Double(1.0))];
//! writer.finish(&Layer { metadata, prims: vec![prim] })?;
//! # Ok::<(), rockfall_usd::Error>(())
//! ```
//!
//! # The format
//!
//! | part | what |
//! |---|---|
//! | head | magic, version, place of the table of contents |
//! | values | one after the other, equal ones once |
//! | `TOKENS`, `STRINGS` | every text once |
//! | `FIELDS`, `FIELDSETS` | name and value of each field, and which of them go together |
//! | `PATHS` | the tree of paths |
//! | `SPECS` | what there is at each path: its kind and its fields |
//! | table of contents | place and size of each section |
//!
//! A value is pointed at by eight bytes: its type, whether it is an array, packed, or no pointer but the value itself, and 48 bits of place or value. All numbers
//! have their low bytes first. The facts are from OpenUSD's own reader and writer; the version is 0.8.0.

#![forbid(unsafe_code)]

mod error;
mod integers;
mod layer;
mod lz4;
mod pack;
mod path;
mod tables;
mod value;
mod writer;

pub use error::Error;
pub use layer::{Attribute, Layer, Metadata, Prim, Property, Relationship, Specifier};
pub use value::{Array, Dictionary, ListOp, Reference, Value};
pub use writer::Writer;

use value::Kind;
