//! A film from its first picture to its last.

use crate::encode::{Encoder, Sample};
use crate::mp4::Writer;
use crate::{Error, Format};
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{SyncSender, sync_channel};
use std::thread::{Builder, JoinHandle};

/// Pictures that may wait for the encoder.
const WAITING: usize = 2;

/// A film that is being made.
#[derive(Debug)]
pub struct Film {
    path: PathBuf,
    pixels: usize,
    pictures: Option<SyncSender<Vec<[u8; 3]>>>,
    encoding: Option<JoinHandle<Result<Done, Error>>>,
}

/// What became of a film.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Done {
    /// Pictures in it.
    pub pictures: u64,
    /// How long it is, seconds.
    pub seconds: f64,
    /// Size of the file.
    pub bytes: u64,
}

impl Film {
    /// Begins a film; what is at `path` is replaced. It can be read while it is made, up to the last complete half second.
    ///
    /// # Errors
    /// [`Error::Size`] and [`Error::Rate`] for a format that no film has, [`Error::Write`] where the file can't be made.
    pub fn create(path: &Path, format: &Format) -> Result<Self, Error> {
        format.check()?;
        let encoder =
            Encoder::new(format).map_err(|reason| Error::Encode { path: path.to_owned(), reason })?;
        let failed =
            |error: std::io::Error| Error::Write { path: path.to_owned(), reason: error.to_string() };
        let file = File::create(path).map_err(failed)?;
        let writer = Writer::new(file, *format, encoder.level);
        let (pictures, coming) = sync_channel::<Vec<[u8; 3]>>(WAITING);
        let (of_thread, rate) = (path.to_owned(), format.rate);
        let encoding = Builder::new().name("film".into()).spawn(move || {
            let mut job = Job { path: of_thread, encoder, writer };
            for pixels in coming {
                job.push(Some(&pixels))?;
            }
            job.finish(rate)
        });
        let encoding = Some(encoding.map_err(failed)?);
        let pixels = format.width as usize * format.height as usize;
        Ok(Film { path: path.to_owned(), pixels, pictures: Some(pictures), encoding })
    }

    /// Adds a picture: pixels in sRGB, row by row from the top. It waits while the encoder has enough to do.
    ///
    /// # Errors
    /// [`Error::Picture`] if it has another size; what went wrong with the pictures before it.
    pub fn push(&mut self, pixels: Vec<[u8; 3]>) -> Result<(), Error> {
        if pixels.len() != self.pixels {
            return Err(Error::Picture { expected: self.pixels, found: pixels.len() });
        }
        match self.pictures.as_ref().map(|pictures| pictures.send(pixels)) {
            Some(Ok(())) => Ok(()),
            // The encoder has stopped: it knows why.
            _ => self.end().and_then(|_| Err(self.stopped())),
        }
    }

    /// Writes what is left. A film without pictures leaves no file.
    ///
    /// # Errors
    /// What went wrong with it.
    pub fn finish(mut self) -> Result<Done, Error> {
        self.end()
    }

    fn end(&mut self) -> Result<Done, Error> {
        self.pictures = None;
        match self.encoding.take().map(JoinHandle::join) {
            Some(Ok(done)) => done,
            Some(Err(_)) | None => Err(self.stopped()),
        }
    }

    fn stopped(&self) -> Error {
        Error::Encode { path: self.path.clone(), reason: "the encoder has stopped".into() }
    }
}

/// Whoever drops a film has no use for it; but what is there of it is complete.
impl Drop for Film {
    fn drop(&mut self) {
        if self.encoding.is_some() {
            let _ = self.end();
        }
    }
}

/// The work of the thread.
struct Job {
    path: PathBuf,
    encoder: Encoder,
    writer: Writer,
}

/// What a step of the encoder can end with.
enum Trouble {
    Encoder(String),
    Disk(std::io::Error),
}

impl From<String> for Trouble {
    fn from(reason: String) -> Self {
        Trouble::Encoder(reason)
    }
}

impl Job {
    fn push(&mut self, pixels: Option<&[[u8; 3]]>) -> Result<(), Error> {
        let writer = &mut self.writer;
        let out = |sample: Sample| writer.push(sample).map_err(Trouble::Disk);
        self.encoder.push(pixels, out).map_err(|trouble| match trouble {
            Trouble::Encoder(reason) => Error::Encode { path: self.path.clone(), reason },
            Trouble::Disk(error) => Error::Write { path: self.path.clone(), reason: error.to_string() },
        })
    }

    fn finish(mut self, rate: f64) -> Result<Done, Error> {
        self.push(None)?;
        let failed =
            |error: std::io::Error| Error::Write { path: self.path.clone(), reason: error.to_string() };
        self.writer.finish().map_err(failed)?;
        let pictures = self.writer.pictures;
        if pictures == 0 {
            fs::remove_file(&self.path).map_err(failed)?;
        }
        Ok(Done { pictures, seconds: pictures as f64 / rate, bytes: self.writer.bytes })
    }
}
