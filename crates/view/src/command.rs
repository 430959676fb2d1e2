//! What a viewer can ask for.

use rockfall_math::{DVec3, Vec3};
use rockfall_picture::{ColorBy, Overlay};
use serde::de::Error;
use serde::{Deserialize, Deserializer};

/// One command of the page, as JSON with the tag `do`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
pub(crate) enum Command {
    /// Time goes on, or stands.
    Play { on: bool },
    /// So many frames further, or back.
    Step { by: i64 },
    /// To a frame.
    Seek { frame: u64 },
    /// How fast time goes, 1 being as in the world.
    Speed { of: f64 },
    /// From the end to the beginning.
    Loop { on: bool },
    /// The scene anew.
    Reset,
    /// Writes what is shown as a scene.
    Save,
    /// What this viewer wants to see.
    Show {
        #[serde(deserialize_with = "color")]
        color: ColorBy,
        #[serde(deserialize_with = "overlays")]
        overlays: Vec<Overlay>,
        pick: Option<u32>,
    },
    /// Takes hold of a body at a point of the world.
    Grab { row: u32, at: [f64; 3] },
    /// Pulls it there.
    Pull { to: [f64; 3] },
    /// Lets go.
    Release,
    /// Throws a ball.
    Throw { from: [f64; 3], velocity: [f32; 3], radius: f32 },
    /// Drops boxes over a point.
    Pile { over: [f64; 3], size: f32, count: u32 },
    /// Other settings; what is not named stays.
    Set { gravity: Option<[f32; 3]>, solver: Option<String>, substeps: Option<u32> },
    /// Another surface of a material.
    Material { index: usize, friction: Option<f32>, restitution: Option<f32> },
}

/// A mode of colour by its word.
fn color<'de, D: Deserializer<'de>>(from: D) -> Result<ColorBy, D::Error> {
    let text = String::deserialize(from)?;
    word(&text, &ColorBy::WORDS).map_err(D::Error::custom)
}

/// Overlays by their words.
fn overlays<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Overlay>, D::Error> {
    let texts = Vec::<String>::deserialize(from)?;
    texts.iter().map(|text| word(text, &Overlay::WORDS).map_err(D::Error::custom)).collect()
}

fn word<T: Copy>(text: &str, words: &[(&str, T)]) -> Result<T, String> {
    let found = words.iter().find(|(word, _)| *word == text).map(|(_, value)| *value);
    found.ok_or_else(|| format!("there is no `{text}`"))
}

impl Command {
    /// Reads a message of a viewer.
    ///
    /// # Errors
    /// Says what is wrong with it.
    pub(crate) fn read(text: &str) -> Result<Self, String> {
        serde_json::from_str(text).map_err(|error| format!("that is no command: {error}"))
    }
}

/// A point of the page.
pub(crate) fn point(numbers: [f64; 3]) -> DVec3 {
    DVec3::from_array(numbers)
}

/// A vector of the page.
pub(crate) fn vector(numbers: [f32; 3]) -> Vec3 {
    Vec3::from_array(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn commands_are_read_and_rubbish_is_named() {
        assert_eq!(Command::read(r#"{"do":"play","on":true}"#), Ok(Command::Play { on: true }));
        assert_eq!(
            Command::read(r#"{"do":"show","color":"speed","overlays":["contacts"],"pick":null}"#),
            Ok(Command::Show { color: ColorBy::Speed, overlays: vec![Overlay::Contacts], pick: None })
        );
        for rubbish in [
            "",
            "{}",
            "[]",
            r#"{"do":"fly"}"#,
            r#"{"do":"seek","frame":-1}"#,
            r#"{"do":"play","on":1e999}"#,
            "\u{0}",
        ] {
            assert!(Command::read(rubbish).unwrap_err().starts_with("that is no command"), "{rubbish}");
        }
    }

    #[test]
    fn words_are_those_that_are_read() {
        let show = |color: &str, overlay: &str| {
            let text = json!({"do": "show", "color": color, "overlays": [overlay], "pick": null});
            Command::read(&text.to_string())
        };
        for (word, color) in ColorBy::WORDS {
            for (mark, overlay) in Overlay::WORDS {
                let read = Command::Show { color, overlays: vec![overlay], pick: None };
                assert_eq!(show(word, mark), Ok(read));
            }
            assert_eq!(color.word(), word);
        }
        assert!(show("colour", "paths").is_err() && show("body", "path").is_err());
    }
}
