//! Films: pictures one after the other, as AV1 in a fragmented MP4 that browsers play.
//!
//! The encoder is compiled in and needs no system library. It works on a thread of its own, so that the next picture is made meanwhile. What it makes depends
//! on the pictures and the format alone, not on threads.
//!
//! The crate knows nothing of what the pictures show.
#![forbid(unsafe_code)]

mod color;
mod encode;
mod error;
mod film;
mod mp4;

pub use color::{Planes, planes};
pub use error::Error;
pub use film::{Done, Film};

/// How much work goes into a film, and how true it is to its pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Effort {
    /// To see what happens.
    Draft,
    /// For the eye.
    #[default]
    Standard,
    /// For the wall.
    Fine,
}

/// What a film is like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Format {
    /// Pixels in a row, even, from 16 to 65,534.
    pub width: u32,
    /// Rows, even, from 16 to 65,534.
    pub height: u32,
    /// Pictures a second, from 0.001 to 1000; kept to a thousandth.
    pub rate: f64,
    /// How many pictures are to come. If fewer do, the film is as long as what came.
    pub pictures: u64,
    /// How much work goes into it.
    pub effort: Effort,
    /// Threads that encode, besides the one that leads them; 0 for as many as the machine has.
    pub threads: usize,
}

/// Time units a second of a film are a thousand times its pictures, so that each picture lasts this many.
const TICKS: u32 = 1000;

impl Format {
    /// Time units a second.
    fn timescale(&self) -> u32 {
        (self.rate * f64::from(TICKS)).round() as u32
    }

    /// Pictures from one that stands by itself to the next, at most half a second: so long is what is lost when a film is broken off.
    fn group(&self) -> u64 {
        ((0.5 * self.rate) as u64).clamp(1, 30)
    }

    fn check(&self) -> Result<(), Error> {
        let even = |size: u32| (16..=65_534).contains(&size) && size.is_multiple_of(2);
        if !even(self.width) || !even(self.height) {
            return Err(Error::Size { width: self.width, height: self.height });
        }
        if !(0.001..=1000.0).contains(&self.rate) {
            return Err(Error::Rate(self.rate));
        }
        Ok(())
    }
}
