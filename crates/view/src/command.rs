//! What a viewer can ask for.

use rockfall_math::{DVec3, Vec3};
use rockfall_picture::{ColorBy, Overlay};
use serde::Deserialize;

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
    Show { color: Color, overlays: Vec<Mark>, pick: Option<u32> },
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

/// The modes of colour by name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Color {
    #[default]
    Body,
    Material,
    Size,
    Speed,
    Force,
    Sleep,
    Island,
    Penetration,
}

impl Color {
    pub(crate) const NAMES: [&str; 8] =
        ["body", "material", "size", "speed", "force", "sleep", "island", "penetration"];

    pub(crate) fn mode(self) -> ColorBy {
        match self {
            Color::Body => ColorBy::Body,
            Color::Material => ColorBy::Material,
            Color::Size => ColorBy::Size,
            Color::Speed => ColorBy::Speed,
            Color::Force => ColorBy::Force,
            Color::Sleep => ColorBy::Sleep,
            Color::Island => ColorBy::Island,
            Color::Penetration => ColorBy::Penetration,
        }
    }

    pub(crate) fn name(self) -> &'static str {
        Color::NAMES[self as usize]
    }

    /// Whether it changes from frame to frame.
    pub(crate) fn moves(self) -> bool {
        !matches!(self, Color::Body | Color::Material | Color::Size)
    }
}

/// Overlays by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Mark {
    Contacts,
    Normals,
    Impulses,
    Bounds,
    Centres,
    Paths,
}

impl Mark {
    pub(crate) const NAMES: [&str; 6] = ["contacts", "normals", "impulses", "bounds", "centres", "paths"];

    pub(crate) fn overlay(self) -> Overlay {
        match self {
            Mark::Contacts => Overlay::Contacts,
            Mark::Normals => Overlay::Normals,
            Mark::Impulses => Overlay::Impulses,
            Mark::Bounds => Overlay::Bounds,
            Mark::Centres => Overlay::Centres,
            Mark::Paths => Overlay::Paths,
        }
    }
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

    #[test]
    fn commands_are_read_and_rubbish_is_named() {
        assert_eq!(Command::read(r#"{"do":"play","on":true}"#), Ok(Command::Play { on: true }));
        assert_eq!(
            Command::read(r#"{"do":"show","color":"speed","overlays":["contacts"],"pick":null}"#),
            Ok(Command::Show { color: Color::Speed, overlays: vec![Mark::Contacts], pick: None })
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
    fn names_are_those_that_are_read() {
        for (k, name) in Color::NAMES.iter().enumerate() {
            let color: Color = serde_json::from_str(&format!("\"{name}\"")).unwrap();
            assert_eq!((color as usize, color.name()), (k, *name));
        }
        for (k, name) in Mark::NAMES.iter().enumerate() {
            assert_eq!(serde_json::from_str::<Mark>(&format!("\"{name}\"")).unwrap() as usize, k);
        }
    }
}
