//! `start.zarr`: what a run began with, where that was a frame of another run.
//!
//! It is the [`State`] of that frame, with the scene of the other run in the attributes: all that is needed to lay out its bodies anew when the
//! other run is gone. Where that run began with a third one, what it began with lies within, as `start.zarr` again.

use crate::trajectory::attributes;
use crate::{Error, RunReader, SCENE, START, State, checksum};
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// Runs that began with runs that began with runs.
const DEEPEST: usize = 64;

/// A frame of a run as the beginning of another.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Start {
    /// The folder of the run.
    pub run: PathBuf,
    /// The text of its `scene.toml`.
    pub scene: String,
    /// The largest id of its bodies, those included that are not there at the frame; 0 without bodies.
    pub last_id: u64,
    /// Its bodies.
    pub state: State,
    /// What that run began with.
    pub start: Option<Box<Start>>,
}

impl Start {
    /// The frame `frame` of the run in the folder `path`; the last one on disk where `None`.
    ///
    /// # Errors
    /// [`Error::NotARun`], [`Error::NoFrame`], [`Error::Version`], [`Error::Damaged`], [`Error::Io`].
    pub fn of_run(path: &Path, frame: Option<u64>) -> Result<Self, Error> {
        let run = RunReader::open(path)?;
        let frames = run.frames()?;
        let last = frames.checked_sub(1).ok_or(Error::NoFrame { frame: 0, frames })?;
        let file = path.join(SCENE);
        let scene = fs::read_to_string(&file).map_err(|error| Error::io("read", &file, &error))?;
        let expected = &run.summary().scene_checksum;
        if !expected.is_empty() && *expected != checksum(scene.as_bytes()) {
            return Err(Error::damaged(
                &file,
                "it is not the scene that was run: its checksum is another one",
            ));
        }
        Ok(Start {
            run: path.to_owned(),
            scene,
            last_id: run.bodies()?.ids.last().copied().unwrap_or_default(),
            state: State::of_run(&run, frame.unwrap_or(last))?,
            start: Self::read(&path.join(START))?.map(Box::new),
        })
    }

    /// Writes it as the folder `path`, whole or not at all.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let Start { run, scene, last_id, state, start } = self;
        let more = attributes([
            ("run", json!(run.display().to_string())),
            ("last_id", json!(last_id)),
            ("scene", json!(scene)),
        ]);
        state.write_with(path, more, |folder| {
            start.iter().try_for_each(|start| start.write(&folder.join(START)))
        })
    }

    /// Reads the folder `path`; `None` where there is none.
    ///
    /// # Errors
    /// [`Error::Damaged`], [`Error::Version`].
    pub fn read(path: &Path) -> Result<Option<Self>, Error> {
        Self::read_within(path, DEEPEST)
    }

    fn read_within(path: &Path, depth: usize) -> Result<Option<Self>, Error> {
        let Some((state, about)) = State::read_with(path)? else { return Ok(None) };
        let text = |name: &str| about.get(name).and_then(Value::as_str);
        let last_id = about.get("last_id").and_then(Value::as_u64);
        let (Some(run), Some(scene), Some(last_id)) = (text("run"), text("scene"), last_id) else {
            return Err(Error::damaged(path, "it does not say of which run and scene it is"));
        };
        if depth == 0 {
            return Err(Error::damaged(path, format!("it began with more than {DEEPEST} runs")));
        }
        let start = Self::read_within(&path.join(START), depth - 1)?.map(Box::new);
        Ok(Some(Start { run: run.into(), scene: scene.to_owned(), last_id, state, start }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn starts_within_starts_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(START);
        let start = |run: &str, frame, start| Start {
            run: run.into(),
            scene: format!("# {run}\n"),
            last_id: 5,
            state: State { frame, ..State::default() },
            start,
        };
        let all =
            start("third", 9, Some(Box::new(start("second", 7, Some(Box::new(start("first", 5, None)))))));
        all.write(&path).unwrap();
        assert_eq!(Start::read(&path).unwrap(), Some(all));
    }
}
