//! One run at a time in a folder.

use crate::{Error, LOCK};
use std::fs::{File, TryLockError};
use std::io::ErrorKind;
use std::path::Path;

/// The right to write into the folder of a run, for as long as it is kept. It ends with the program, however that ends.
#[derive(Debug)]
pub(crate) struct Lock {
    _file: Option<File>,
}

impl Lock {
    /// Takes the folder `run`.
    ///
    /// # Errors
    /// [`Error::Locked`] where another program has it; [`Error::Io`].
    pub(crate) fn take(run: &Path) -> Result<Self, Error> {
        let path = run.join(LOCK);
        let options = File::options().create(true).append(true).open(&path);
        let file = options.map_err(|error| Error::io("create", &path, &error))?;
        match file.try_lock() {
            Ok(()) => Ok(Lock { _file: Some(file) }),
            Err(TryLockError::WouldBlock) => Err(Error::Locked(run.to_owned())),
            // Some file systems over a network know no locks; a run there is not guarded.
            Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => {
                Ok(Lock { _file: None })
            }
            Err(TryLockError::Error(error)) => Err(Error::io("lock", &path, &error)),
        }
    }
}
