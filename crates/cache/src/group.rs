//! Reading a Zarr group that this crate has written.

use crate::Error;
use crate::seal::is_sound;
use crate::store::ATTRIBUTES;
use serde_json::{Map, Value};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use zarrs::array::{Array, ElementOwned};
use zarrs::filesystem::FilesystemStore;

/// A folder that is a Zarr group.
#[derive(Debug)]
pub(crate) struct Group {
    path: PathBuf,
    store: Arc<FilesystemStore>,
}

impl Group {
    /// That in the folder `path`, which exists; nothing is read yet.
    pub(crate) fn open(path: &Path) -> Result<Self, Error> {
        let store = FilesystemStore::new(path).map_err(|error| Error::damaged(path, error))?;
        Ok(Group { path: path.to_owned(), store: Arc::new(store) })
    }

    /// The attributes of the group.
    pub(crate) fn attributes(&self) -> Result<Map<String, Value>, Error> {
        match self.metadata("zarr.json")?.get_mut("attributes").map(Value::take) {
            Some(Value::Object(attributes)) => Ok(attributes),
            _ => Err(self.damaged("zarr.json", "it has no attributes")),
        }
    }

    /// A `zarr.json` whose checksum is right.
    pub(crate) fn metadata(&self, name: &str) -> Result<Value, Error> {
        let path = self.path.join(name);
        let text = fs::read(&path).map_err(|error| Error::damaged(&path, error))?;
        let metadata: Value = serde_json::from_slice(&text).map_err(|error| Error::damaged(&path, error))?;
        if is_sound(metadata.clone(), &ATTRIBUTES) {
            Ok(metadata)
        } else {
            Err(Error::damaged(&path, "its checksum is another one"))
        }
    }

    /// An array by its name.
    pub(crate) fn array(&self, name: &str) -> Result<Array<FilesystemStore>, Error> {
        self.metadata(&format!("{name}/zarr.json"))?;
        Array::open(self.store.clone(), &format!("/{name}")).map_err(|error| self.damaged(name, error))
    }

    /// All values of an array.
    pub(crate) fn all<T: ElementOwned>(&self, name: &str) -> Result<Vec<T>, Error> {
        let array = self.array(name)?;
        array.retrieve_array_subset::<Vec<T>>(&array.subset_all()).map_err(|error| self.damaged(name, error))
    }

    /// The same of an array of which every chunk has to be there. A reader of Zarr takes one that is not there for one of fill values;
    /// our writers leave out none.
    pub(crate) fn whole<T: ElementOwned>(&self, name: &str) -> Result<Vec<T>, Error> {
        let array = self.array(name)?;
        let chunks = array.chunk_grid_shape();
        let rest = ".0".repeat(chunks.len().saturating_sub(1));
        let file = |chunk| self.path.join(name).join(format!("c.{chunk}{rest}"));
        match (0..chunks.first().copied().unwrap_or(0)).map(file).find(|file| !file.is_file()) {
            Some(file) => Err(Error::damaged(&file, "it is missing")),
            None => self.all(name),
        }
    }

    /// An error of a part of the group.
    pub(crate) fn damaged(&self, name: &str, reason: impl ToString) -> Error {
        Error::damaged(&self.path.join(name), reason)
    }
}
