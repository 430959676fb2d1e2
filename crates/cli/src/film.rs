//! Films: pictures of a run or a scene, one after the other.

use crate::args::{LookArgs, Size};
use crate::exit::Failure;
use crate::shots::{self, Shots};
use crate::{say, units};
use rockfall_film::{Done, Effort, Film, Format};
use rockfall_picture::{Picture, Quality, Sight};
use rockfall_scene::{Running, Scene};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Pictures a second of a film beyond which screens show no difference: of a run that has more, some are left out where nobody says how many.
const MOST: f64 = 60.0;

/// Size of a picture where nobody says another one.
pub(crate) const SIZE: Size = Size { width: 1280, height: 720 };

/// How fast a film goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pace {
    /// Of so many frames one is a picture.
    pub(crate) every: u64,
    /// Pictures a second.
    pub(crate) rate: f64,
}

impl Pace {
    /// For so many frames a second: as fast as it is in the world unless `fps` says otherwise.
    pub(crate) fn new(frames: f64, every: Option<u64>, fps: Option<f64>) -> Self {
        let enough = if fps.is_some() { 1 } else { ((frames / MOST) - 1e-6).ceil().max(1.0) as u64 };
        let every = every.unwrap_or(enough);
        Pace { every, rate: fps.unwrap_or(frames / every as f64) }
    }
}

/// A film on its way.
pub(crate) struct Reel {
    film: Film,
    path: PathBuf,
    start: Instant,
}

impl Reel {
    /// Begins a film of so many pictures.
    pub(crate) fn start(
        path: &Path,
        size: Size,
        rate: f64,
        pictures: u64,
        quality: Quality,
    ) -> Result<Self, Failure> {
        let effort = match quality {
            Quality::Draft => Effort::Draft,
            Quality::Standard => Effort::Standard,
            Quality::Fine => Effort::Fine,
        };
        let threads = rayon::current_num_threads();
        let format = Format { width: size.width, height: size.height, rate, pictures, effort, threads };
        Ok(Reel { film: Film::create(path, &format)?, path: path.to_owned(), start: Instant::now() })
    }

    pub(crate) fn push(&mut self, picture: Picture) -> Result<(), Failure> {
        Ok(self.film.push(picture.pixels)?)
    }

    /// Ends the film; says what it is unless it is to be quiet.
    pub(crate) fn finish(self, quiet: bool) -> Result<(), Failure> {
        let Done { pictures, seconds, bytes } = self.film.finish()?;
        if !quiet && pictures > 0 {
            say::out(&format!(
                "{}: {} pictures, {seconds:.2} s, {}, in {}",
                self.path.display(),
                units::count(pictures),
                units::bytes(bytes),
                units::time(self.start.elapsed()),
            ));
        }
        Ok(())
    }
}

/// The film of a run while it is simulated. Whatever is wrong with it, the run goes on, and says so in the end.
pub(crate) struct Recording<'a> {
    scene: &'a Scene,
    shots: Shots,
    every: u64,
    reel: Option<Reel>,
    trouble: Option<Failure>,
}

impl<'a> Recording<'a> {
    pub(crate) fn start(path: &Path, scene: &'a Scene) -> Result<Self, Failure> {
        if path.extension().is_none_or(|extension| !extension.eq_ignore_ascii_case("mp4")) {
            return Err(Failure::Usage(format!(
                "{} is not a film's name, expected NAME.mp4",
                path.display()
            )));
        }
        let look = LookArgs::default();
        let shots = Shots::new(&look, SIZE, shots::chosen(None, scene.cameras())?);
        let Pace { every, rate } = Pace::new(scene.settings.rate.into(), None, None);
        let reel = Reel::start(path, SIZE, rate, scene.frames / every + 1, look.quality)?;
        Ok(Recording { scene, shots, every, reel: Some(reel), trouble: None })
    }

    /// Takes the picture of a frame, if it is one of the film's.
    pub(crate) fn frame(&mut self, running: &Running, frame: u64) {
        let Some(reel) = self.reel.as_mut().filter(|_| frame.is_multiple_of(self.every)) else { return };
        let sight = Sight::of_world(self.scene, running, frame);
        let shots = &mut self.shots;
        let prepared = if frame == 0 { shots.prepare(std::slice::from_ref(&sight)) } else { Ok(()) };
        let pushed = prepared.and_then(|()| shots.take(sight)).and_then(|(_, picture)| reel.push(picture));
        if let Err(trouble) = pushed {
            say::error("Warning: there is no more of the film; the run goes on");
            (self.reel, self.trouble) = (None, Some(trouble));
        }
    }

    /// Ends the film.
    pub(crate) fn finish(self, quiet: bool) -> Result<(), Failure> {
        match (self.trouble, self.reel) {
            (Some(trouble), _) => Err(trouble),
            (None, Some(reel)) => reel.finish(quiet),
            (None, None) => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_film_is_as_fast_as_the_world_and_has_no_more_pictures_than_a_screen_shows() {
        let pace = |frames, every, fps| {
            let Pace { every, rate } = Pace::new(frames, every, fps);
            (every, rate)
        };
        assert_eq!(pace(60.0, None, None), (1, 60.0));
        assert_eq!(pace(240.0, None, None), (4, 60.0));
        assert_eq!(pace(100.0, None, None), (2, 50.0));
        assert_eq!(pace(24.0, None, None), (1, 24.0));
        assert_eq!(pace(240.0, Some(2), None), (2, 120.0));
        assert_eq!(pace(240.0, None, Some(30.0)), (1, 30.0));
    }
}
