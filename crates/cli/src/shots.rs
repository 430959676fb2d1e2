//! Pictures of many moments with one camera and one legend.

use crate::args::{LookArgs, Size};
use crate::exit::Failure;
use rockfall_picture::{Camera, Image, Look, Picture, Shutter, Sight, take_open};
use rockfall_scene::SceneCamera;

/// The camera that finds its own place.
const AUTOMATIC: &str = "auto";

/// The camera of the scene that is asked for; its first one where nobody asks, `None` for the automatic one.
pub(crate) fn chosen(
    name: Option<&str>,
    mut cameras: Vec<SceneCamera>,
) -> Result<Option<SceneCamera>, Failure> {
    let Some(name) = name else {
        return Ok((!cameras.is_empty()).then(|| cameras.swap_remove(0)));
    };
    if let Some(found) = cameras.iter().position(|camera| camera.name == name) {
        return Ok(Some(cameras.swap_remove(found)));
    }
    if name == AUTOMATIC {
        return Ok(None);
    }
    let mut names: Vec<String> = cameras.iter().map(|camera| format!("`{}`", camera.name)).collect();
    names.push(format!("`{AUTOMATIC}`"));
    Err(Failure::Usage(format!("the scene has no camera `{name}`, expected {}", names.join(" or "))))
}

/// What all pictures of a command have in common.
pub(crate) struct Shots {
    look: Look,
    chosen: Option<SceneCamera>,
    automatic: Option<Camera>,
    /// Share of the time between two pictures for which the shutter is open.
    blur: Option<f64>,
    before: Option<Sight>,
}

impl Shots {
    pub(crate) fn new(args: &LookArgs, size: Size, chosen: Option<SceneCamera>) -> Self {
        let look = Look {
            width: size.width,
            height: size.height,
            quality: args.quality,
            colors: args.color_by,
            span: None,
            overlays: args.overlay.clone(),
            caption: args.caption,
        };
        Shots { look, chosen, automatic: None, blur: args.blur, before: None }
    }

    /// Finds what all pictures have in common from some of their moments: the place of the automatic camera, and the span of the colours.
    pub(crate) fn prepare(&mut self, sights: &[Sight]) -> Result<(), Failure> {
        if self.chosen.is_none()
            && let Some(first) = sights.first()
        {
            let balls: Vec<_> = sights.iter().flat_map(|sight| sight.stage(&blank(sight)).balls()).collect();
            let aspect = f64::from(self.look.width) / f64::from(self.look.height);
            self.automatic = Some(Camera::fitting(&first.stage(&blank(first)), &balls, aspect));
        }
        for sight in sights {
            if let Some([low, high]) = self.look.colors.span(sight)? {
                let [a, b] = self.look.span.unwrap_or([low, high]);
                self.look.span = Some([a.min(low), b.max(high)]);
            }
        }
        Ok(())
    }

    /// The picture of the next moment.
    pub(crate) fn take(&mut self, sight: Sight) -> Result<(Image, Picture), Failure> {
        let Shots { look, chosen, automatic, blur, before } = self;
        let camera = |sight: &Sight| match (&*chosen, *automatic) {
            (Some(chosen), _) => Camera::of_scene(chosen, sight),
            (None, Some(camera)) => Ok(camera),
            // Nobody has asked for a place: that of nothing at all.
            (None, None) => Ok(Camera::fitting(&sight.stage(&blank(sight)), &[], 1.0)),
        };
        let shutter = before.as_ref().zip(*blur).map(|(before, open)| Shutter { before, open });
        let taken = take_open(&sight, &camera, look, shutter)?;
        if blur.is_some() {
            *before = Some(sight);
        }
        Ok(taken)
    }
}

/// Colours for what only has to be there.
fn blank(sight: &Sight) -> Vec<[f32; 3]> {
    vec![[0.0; 3]; sight.bodies.len()]
}
