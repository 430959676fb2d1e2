//! The run that is exported.

use crate::{Error, Inventory};
use rockfall_cache::{
    BodyTable, Column, ColumnReader, Contacts, ContactsReader, Poses, RunReader, Summary, Values, Velocities,
    WantedContacts,
};
use rockfall_math::DVec3;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// A run on disk, finished or not: what is there when it is opened is what can be exported.
#[derive(Debug)]
pub struct Run {
    path: PathBuf,
    reader: RunReader,
    bodies: BodyTable,
    times: Vec<f64>,
    origin: DVec3,
    has_velocities: bool,
    columns: Vec<Column>,
    readers: Vec<ColumnReader>,
    contacts: Option<(WantedContacts, ContactsReader)>,
    inventory: OnceLock<Inventory>,
}

impl Run {
    /// Opens the run in the folder `path`.
    ///
    /// # Errors
    /// Those of [`RunReader`]; [`Error::NoFrames`].
    pub fn open(path: &Path) -> Result<Self, Error> {
        let reader = RunReader::open(path)?;
        let (bodies, times, origin) = (reader.bodies()?, reader.times()?, reader.origin()?);
        if times.is_empty() {
            return Err(Error::NoFrames(path.to_owned()));
        }
        let (has_velocities, columns) = (reader.has_velocities()?, reader.columns()?);
        let readers = columns.iter().map(|column| reader.column(column)).collect::<Result<_, _>>()?;
        let contacts = reader.wanted_contacts()?.zip(reader.contacts()?);
        Ok(Run {
            path: path.to_owned(),
            reader,
            bodies,
            times,
            origin,
            has_velocities,
            columns,
            readers,
            contacts,
            inventory: OnceLock::new(),
        })
    }

    /// Takes in what was written since it was opened, and tells whether that is anything: a run that is still being written is followed so.
    ///
    /// # Errors
    /// Those of [`Run::open`]; it is left as it was.
    pub fn refresh(&mut self) -> Result<bool, Error> {
        let mut fresh = Run::open(&self.path)?;
        let news = fresh.times != self.times || fresh.summary().status != self.summary().status;
        fresh.inventory = std::mem::take(&mut self.inventory);
        *self = fresh;
        Ok(news)
    }

    /// Its folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What it says of itself.
    pub fn summary(&self) -> &Summary {
        self.reader.summary()
    }

    /// The bodies; everything else that has rows has them in this order, which is that of ids.
    pub fn bodies(&self) -> &BodyTable {
        &self.bodies
    }

    /// Simulated time of each frame, seconds; there is at least one.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Number of frames, the start included.
    pub fn frames(&self) -> u64 {
        self.times.len() as u64
    }

    /// Where positions start from, metres.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// The poses at a frame, as they are stored.
    ///
    /// # Errors
    /// Those of [`RunReader::poses`].
    pub fn poses(&self, frame: u64) -> Result<Poses, Error> {
        Ok(self.reader.poses(frame)?)
    }

    /// Whether it has velocities beside poses.
    pub fn has_velocities(&self) -> bool {
        self.has_velocities
    }

    /// The velocities at a frame, as they are stored; `None` in a run without.
    ///
    /// # Errors
    /// Those of [`RunReader::velocities`].
    pub fn velocities(&self, frame: u64) -> Result<Option<Velocities>, Error> {
        Ok(self.reader.velocities(frame)?)
    }

    /// The columns that it has of its own.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Their values at a frame.
    ///
    /// # Errors
    /// Those of [`ColumnReader::at`].
    pub fn values(&self, frame: u64) -> Result<Vec<Values>, Error> {
        self.readers.iter().map(|reader| Ok(reader.at(frame)?)).collect()
    }

    /// Which contacts it has; none where `None`.
    pub fn wanted_contacts(&self) -> Option<WantedContacts> {
        self.contacts.as_ref().map(|(wanted, _)| *wanted)
    }

    /// Its contacts at a frame; none where it has none there.
    ///
    /// # Errors
    /// Those of [`ContactsReader::at`].
    pub fn contacts(&self, frame: u64) -> Result<Contacts, Error> {
        Ok(self.contacts.as_ref().map_or(Ok(Contacts::default()), |(_, reader)| reader.at(frame))?)
    }

    /// What the bodies look like. Made when it is first asked for, since the scene has to be laid out for it.
    ///
    /// # Errors
    /// [`Error::Scene`] where the scene, or a mesh that it names, can't be read; [`Error::OtherScene`].
    pub fn inventory(&self) -> Result<&Inventory, Error> {
        if let Some(inventory) = self.inventory.get() {
            return Ok(inventory);
        }
        let inventory = Inventory::of(&self.path, &self.bodies)?;
        Ok(self.inventory.get_or_init(|| inventory))
    }
}
