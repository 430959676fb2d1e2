//! From what is known of a moment to the light of its picture: at once, or gathered through a lens and while a shutter is open.

use crate::camera::Camera;
use crate::render::render_at;
use crate::sample::{hammersley, on_disc};
use crate::{Error, Image, Quality, Shot, Sight};

/// What happens between two pictures, for a shutter that is open.
#[derive(Clone, Copy)]
pub struct Shutter<'a> {
    /// The moment of the picture before.
    pub before: &'a Sight,
    /// Share of the time between the pictures for which it is open, up to the moment of this one; more than 0, at most 1.
    pub open: f64,
}

/// Pictures that are put together where a shutter is open, and through a lens.
fn moments(quality: Quality) -> u32 {
    match quality {
        Quality::Draft => 4,
        Quality::Standard => 8,
        Quality::Fine => 24,
    }
}

fn lens_places(quality: Quality) -> u32 {
    match quality {
        Quality::Draft => 8,
        Quality::Standard => 24,
        Quality::Fine => 96,
    }
}

/// The light that comes from bodies in the colours `colors`; `camera` tells where it is at a moment.
pub(crate) fn expose(
    sight: &Sight,
    colors: &[[f32; 3]],
    camera: &dyn Fn(&Sight) -> Result<Camera, Error>,
    shot: &Shot,
    shutter: Option<Shutter>,
) -> Result<Image, Error> {
    let now = camera(sight)?;
    // The mean of pictures at several moments and through several points of the lens (Haeberli and Akeley, "The accumulation buffer", SIGGRAPH 1990).
    let [times, places] =
        [shutter.map(|_| moments(shot.quality)), now.lens.map(|_| lens_places(shot.quality))];
    let count = times.max(places).unwrap_or(1);
    // Where each picture is of another moment, they smooth each other's edges, and none has to by itself.
    let rough = Shot { quality: Quality::Draft, ..*shot };
    let shot = if shutter.is_some() { &rough } else { shot };
    let mut sum: Option<Image> = None;
    for k in 0..count {
        let (u, v) = hammersley(k, count);
        let shift = if shutter.is_some() { [u, v].map(|x| f64::from(x) - 0.5) } else { [0.0; 2] };
        let moved = shutter.map(|shutter| {
            let share = 1.0 - shutter.open * (1.0 - (f64::from(k) + 0.5) / f64::from(count));
            sight.since(shutter.before, share)
        });
        let there = moved.as_ref().unwrap_or(sight);
        let camera = if shutter.is_some() { camera(there)? } else { now };
        // Points of the lens in another order than moments, so that neither follows the other.
        let (u, v) = hammersley(5 * k % count, count);
        let image = render_at(&there.stage(colors), &camera.through(on_disc(u, v)), shot, shift);
        match &mut sum {
            None => sum = Some(image),
            Some(sum) => sum.add(&image),
        }
    }
    // There is at least one.
    let mut image = sum.unwrap_or_else(|| render_at(&sight.stage(colors), &now, shot, [0.0; 2]));
    let share = 1.0 / count as f32;
    image.light.iter_mut().for_each(|light| *light = light.map(|x| x * share));
    Ok(image)
}
