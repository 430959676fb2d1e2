//! What is worked out of a moment for those who want to see it: colours and overlays, as pictures have them.

use crate::Error;
use crate::scenery::Scenery;
use crate::wire::{Colors, Line, UNPAINTED, lines};
use rockfall_math::Vec3;
use rockfall_picture::{ColorBy, Legend, Overlay, Sight, encode, ramp};
use serde_json::{Value, json};

/// Lines of overlays at most. Beyond, every so many of them are drawn, and the message says so.
const MOST_LINES: usize = 200_000;

/// Colours of the ramp that a legend shows.
const STEPS: usize = 24;

/// The colours of all rows.
pub(crate) fn colors(sight: &Sight, by: ColorBy, scenery: &Scenery) -> Result<Colors, Error> {
    let (painted, legend) = by.paint(sight, None)?;
    let mut colors = vec![UNPAINTED; scenery.ids.len()];
    for (body, color) in sight.bodies.iter().zip(&painted) {
        if let Some(row) = scenery.row(body.id) {
            colors[row] = bytes(*color);
        }
    }
    Ok(Colors { colors, legend: explained(by, &legend).to_string().into() })
}

fn bytes(linear: [f32; 3]) -> [u8; 3] {
    linear.map(|x| encode(x).round() as u8)
}

fn explained(by: ColorBy, legend: &Legend) -> Value {
    match legend {
        Legend::None => json!({"is": "legend", "by": by.word()}),
        Legend::Scale { title, unit, span } => {
            let color = |k: usize| bytes(ramp(k as f32 / (STEPS - 1) as f32).to_array());
            let colors: Vec<[u8; 3]> = (0..STEPS).map(color).collect();
            json!({"is": "legend", "by": by.word(), "title": title, "unit": unit, "span": span, "ramp": colors})
        }
        Legend::Names { title, entries } => {
            let entries: Vec<Value> =
                entries.iter().map(|(name, color)| json!({"name": name, "color": bytes(*color)})).collect();
            json!({"is": "legend", "by": by.word(), "title": title, "names": entries})
        }
    }
}

/// The lines of some overlays as a message, and what is to be said of them.
pub(crate) fn overlays(
    sight: &Sight,
    marks: &[Overlay],
    scenery: &Scenery,
) -> Result<(Vec<u8>, Option<String>), Error> {
    let mut all = Vec::new();
    for mark in marks {
        for stroke in mark.strokes(sight)? {
            let from = |point: rockfall_math::DVec3| -> Vec3 { (point - scenery.origin).as_vec3() };
            let color = stroke.color.map(|x| x.round() as u8);
            all.push(Line { from: from(stroke.from).to_array(), to: from(stroke.to).to_array(), color });
        }
    }
    if all.len() <= MOST_LINES {
        return Ok((lines(&all), None));
    }
    let every = all.len().div_ceil(MOST_LINES);
    let some: Vec<Line> = all.iter().step_by(every).copied().collect();
    Ok((lines(&some), Some(format!("one of {every} marks is drawn, of {}", all.len()))))
}
