//! Value clips: files with some frames each, and what says which frames are where.

use super::crowd::{Crowd, Declared, attributes};
use super::stage::BODIES;
use crate::{Error, Job};
use rockfall_usd::{Array, Dictionary, Layer, Prim, Value, Writer};
use std::path::{Path, PathBuf};

/// The digits of a clip's number in the name of its file; more where it takes more.
const DIGITS: usize = 4;

/// What is in the clips, without values.
const MANIFEST: &str = "manifest.usdc";

/// Writes clips one after the other.
pub(super) struct Clips<'a> {
    folder: &'a Path,
    /// Frames in a clip.
    length: u64,
    first: u64,
    last: u64,
    declared: Declared,
    /// The clip at hand and how many frames it has.
    open: Option<(Writer, u64)>,
    /// First frame and name of each clip.
    clips: Vec<(u64, String)>,
}

impl<'a> Clips<'a> {
    pub(super) fn new(folder: &'a Path, job: &Job<'_>, length: u64, declared: Declared) -> Self {
        let frames = job.frames();
        let (first, last) = (frames[0], frames[frames.len() - 1]);
        Clips { folder, length, first, last, declared, open: None, clips: Vec::new() }
    }

    /// Writes the frame at hand.
    pub(super) fn write(&mut self, crowd: &Crowd) -> Result<(), Error> {
        let (mut writer, frames) = match self.open.take() {
            Some(open) => open,
            None => (Writer::create(&self.begin(crowd.frame()))?, 0),
        };
        crowd.sample(&mut writer)?;
        match frames + 1 == self.length {
            true => writer.finish(&self.layer()).map(drop)?,
            false => self.open = Some((writer, frames + 1)),
        }
        Ok(())
    }

    fn begin(&mut self, frame: u64) -> PathBuf {
        let name = format!("frames-{:0DIGITS$}.usdc", self.clips.len());
        let path = self.folder.join(&name);
        self.clips.push((frame, name));
        path
    }

    /// Ends the last clip, and says what goes into the metadata `clips` of the prim whose attributes they hold.
    pub(super) fn finish(mut self) -> Result<Value, Error> {
        if let Some((writer, _)) = self.open.take() {
            writer.finish(&self.layer())?;
        }
        Writer::create(&self.folder.join(MANIFEST))?.finish(&self.layer())?;
        let files = self.clips.iter().map(|(_, name)| format!("./{name}")).collect();
        let active = self.clips.iter().zip(0_u32..).map(|(clip, k)| [clip.0 as f64, k.into()]).collect();
        // Time in the clips is that of the scene.
        let times = [self.first, self.last].map(|frame| [frame as f64; 2]).to_vec();
        let set = [
            ("assetPaths", Value::Array(Array::Asset(files))),
            ("manifestAssetPath", Value::Asset(format!("./{MANIFEST}"))),
            ("primPath", Value::String(BODIES.to_owned())),
            ("active", Value::Array(Array::Double2(active))),
            ("times", Value::Array(Array::Double2(times))),
        ];
        let set: Dictionary = set.map(|(key, value)| (key.to_owned(), value)).into();
        Ok(Value::Dictionary(Dictionary::from([("default".to_owned(), Value::Dictionary(set))])))
    }

    /// The prims of a clip, and of the manifest.
    fn layer(&self) -> Layer {
        let mut bodies = Prim::over("Bodies");
        bodies.properties = attributes(&self.declared).map(Into::into).collect();
        Layer { metadata: Vec::new(), prims: vec![Prim::over("World").child(bodies)] }
    }
}
