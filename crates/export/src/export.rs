//! An export from its options to its place.

use crate::target::{self, Target};
use crate::{Error, Format, Frames, Job, Makes, Run, Watch};
use std::path::{Path, PathBuf};

/// What is exported, and where to.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Which frames.
    pub frames: Frames,
    /// The file or folder to make; beside the run where `None`.
    pub to: Option<PathBuf>,
    /// Replace a former export.
    pub overwrite: bool,
    /// Threads; as many as the machine has where `None`.
    pub threads: Option<usize>,
}

/// What an export has made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Done {
    /// The file or folder.
    pub path: PathBuf,
    /// Number of frames.
    pub frames: u64,
    /// Number of files.
    pub files: u64,
    /// Their size.
    pub bytes: u64,
}

/// Writes frames of a run in a format. The output is there whole, or not at all.
///
/// # Errors
/// [`Error::Exists`], [`Error::Occupied`] and [`Error::NoFrame`] before anything is touched; those of [`Format::write`].
pub fn export(run: &Run, format: &dyn Format, options: &Options, watch: &dyn Watch) -> Result<Done, Error> {
    let frames = options.frames.among(run.frames())?;
    let path = options.to.clone().unwrap_or_else(|| beside(run.path(), format));
    let target = Target::start(&path, format.makes(), options.overwrite)?;
    let mut threads = rayon::ThreadPoolBuilder::new();
    if let Some(number) = options.threads {
        threads = threads.num_threads(number);
    }
    let threads = threads.build().map_err(|error| Error::Threads(error.to_string()))?;
    threads.install(|| format.write(&Job::new(run, &frames, watch), target.part()))?;
    let (bytes, files) = target::size(target.part())?;
    target.finish()?;
    Ok(Done { path, frames: frames.len() as u64, files, bytes })
}

/// The place beside a run: its name with that of the format.
fn beside(run: &Path, format: &dyn Format) -> PathBuf {
    // A path such as `.` or `..` has no name of its own.
    let whole = run.canonicalize().unwrap_or_else(|_| run.to_owned());
    let path = if run.file_name().is_some() { run } else { &whole };
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    path.with_file_name(match format.makes() {
        Makes::File { extension } => format!("{name}.{extension}"),
        Makes::Folder { .. } => format!("{name}-{}", format.name()),
    })
}
