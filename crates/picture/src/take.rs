//! From what is known of a moment to a picture with everything on it.

use crate::camera::Camera;
use crate::sample::{hammersley, on_disc};
use crate::{
    Air, ColorBy, Error, Image, Overlay, Picture, Quality, Shot, Sight, Span, caption, render, tone,
};

/// What a picture is to look like.
#[derive(Clone, Debug, PartialEq)]
pub struct Look {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// How much work goes into it.
    pub quality: Quality,
    /// What colours tell.
    pub colors: ColorBy,
    /// The numbers at the ends of the colours; those that suit the moment where `None`.
    pub span: Option<Span>,
    /// What is drawn over it.
    pub overlays: Vec<Overlay>,
    /// Whether frame, time and number of bodies are written on it.
    pub caption: bool,
}

impl Default for Look {
    fn default() -> Self {
        Look {
            width: 1280,
            height: 720,
            quality: Quality::Standard,
            colors: ColorBy::Body,
            span: None,
            overlays: Vec::new(),
            caption: false,
        }
    }
}

/// Places on the lens for a camera that has one.
fn lens_places(quality: Quality) -> u32 {
    match quality {
        Quality::Draft => 8,
        Quality::Standard => 24,
        Quality::Fine => 96,
    }
}

/// Takes a picture: the light alone, and the picture for a screen with legend, overlays and caption.
///
/// # Errors
/// [`Error::Unknown`] where what is seen does not tell what is to be shown.
pub fn take(sight: &Sight, camera: &Camera, look: &Look) -> Result<(Image, Picture), Error> {
    let (colors, legend) = look.colors.paint(sight, look.span)?;
    let stage = sight.stage(&colors);
    let air = Air::beyond((camera.target - camera.eye).length());
    let shot = Shot { width: look.width, height: look.height, quality: look.quality, air };
    let image = match camera.lens {
        None => render(&stage, camera, &shot),
        // A picture through a lens is the mean of pictures through its points (Haeberli and Akeley, "The accumulation buffer", SIGGRAPH 1990).
        Some(_) => {
            let places = lens_places(look.quality);
            let through = |k: u32| {
                let (u, v) = hammersley(k, places);
                render(&stage, &camera.through(on_disc(u, v)), &shot)
            };
            let mut sum = through(0);
            sum.light.iter_mut().for_each(|light| *light = light.map(|x| x / places as f32));
            (1..places).for_each(|k| sum.add(&through(k), 1.0 / places as f32));
            sum
        }
    };
    let mut picture = tone(&image);
    for overlay in &look.overlays {
        overlay.draw(&mut picture, &image, camera, sight)?;
    }
    legend.draw(&mut picture);
    if look.caption {
        let moving = sight.bodies.iter().filter(|body| body.kind != rockfall::Kind::Static).count();
        let text = format!("frame {}  {:.3} s  {moving} bodies", sight.frame, sight.time);
        caption(&mut picture, &text);
    }
    Ok((image, picture))
}
