//! From what is known of a moment to a picture with everything on it.

use crate::camera::Camera;
use crate::expose::{Shutter, expose};
use crate::{Air, ColorBy, Error, Image, Overlay, Picture, Quality, Shot, Sight, Span, caption, tone};

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

/// Takes a picture: the light alone, and the picture for a screen with legend, overlays and caption.
///
/// # Errors
/// [`Error::Unknown`] where what is seen does not tell what is to be shown.
pub fn take(sight: &Sight, camera: &Camera, look: &Look) -> Result<(Image, Picture), Error> {
    take_open(sight, &|_| Ok(*camera), look, None)
}

/// The same with a shutter that is open for a while, if there is one: what moves is blurred. `camera` tells where it is at a moment.
///
/// # Errors
/// Those of [`take`] and of `camera`.
pub fn take_open(
    sight: &Sight,
    camera: &dyn Fn(&Sight) -> Result<Camera, Error>,
    look: &Look,
    shutter: Option<Shutter>,
) -> Result<(Image, Picture), Error> {
    let (colors, legend) = look.colors.paint(sight, look.span)?;
    let now = camera(sight)?;
    let air = Air::beyond((now.target - now.eye).length());
    let shot = Shot { width: look.width, height: look.height, quality: look.quality, air };
    let image = expose(sight, &colors, camera, &shot, shutter)?;
    let camera = &now;
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
