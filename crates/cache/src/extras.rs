//! What a trajectory has beside poses and velocities, on request: contacts, events and columns.

use crate::columns::check;
use crate::contacts::CONTACTS;
use crate::events::{self, EVENTS};
use crate::ragged::{Ragged, RaggedReader};
use crate::sheet::{Growing, NumberType, Sheet, SheetReader};
use crate::store::WholeFiles;
use crate::trajectory::attributes;
use crate::{
    Column, Contacts, Contents, Error, Event, Frame, RunReader, Values, WantedContacts, WantedEvents,
};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// What is being written of it.
#[derive(Debug)]
pub(crate) struct Extras {
    contacts: Option<Ragged>,
    events: Option<Ragged>,
    columns: Vec<Growing>,
    bodies: usize,
}

/// What the attributes of a trajectory say of it.
pub(crate) fn about(contents: &Contents) -> impl Iterator<Item = (&'static str, Value)> {
    let names: Vec<&str> = contents.columns.iter().map(|column| column.name.as_str()).collect();
    let none = [("events", Value::Null), ("hits_N_s", Value::Null)];
    [("contacts", json!(contents.contacts.map(|wanted| wanted.about()))), ("columns", json!(names))]
        .into_iter()
        .chain(contents.events.map_or(none, WantedEvents::about))
}

fn growing(column: &Column, bodies: usize) -> Growing {
    let about = attributes([("units", json!(column.units)), ("description", json!(column.description))]);
    Growing::new(Sheet::of_bodies(column.name.clone(), column.numbers, bodies), about)
}

impl Extras {
    /// Starts what is wanted.
    pub(crate) fn create(contents: &Contents, bodies: usize, store: &WholeFiles) -> Result<Self, Error> {
        let contacts = contents
            .contacts
            .map(|wanted| Ragged::create(&CONTACTS, wanted.friction, bodies, wanted.about(), store));
        let events = contents.events.map(|wanted| {
            let [word, hits] = wanted.about();
            let rows = json!("those of frame f are the rows offset[f] to offset[f] + count[f]");
            let about = attributes([word, hits, ("description", rows)]);
            Ragged::create(&EVENTS, wanted.hits.is_some(), bodies, about, store)
        });
        Ok(Extras {
            contacts: contacts.transpose()?,
            events: events.transpose()?,
            columns: contents.columns.iter().map(|column| growing(column, bodies)).collect(),
            bodies,
        })
    }

    /// Goes on with those of a run in the trajectory in `folder`, after its first `frames` frames.
    pub(crate) fn resume(run: &RunReader, folder: &Path, bodies: usize, frames: u64) -> Result<Self, Error> {
        let group = run.group();
        let columns = run.columns()?;
        let columns = columns.iter().map(|column| growing(column, bodies).resume(group, folder, frames));
        Ok(Extras {
            contacts: run
                .wanted_contacts()?
                .map(|wanted| Ragged::resume(&CONTACTS, wanted.friction, group, folder, frames))
                .transpose()?,
            events: run
                .has_events()?
                .then(|| Ragged::resume(&EVENTS, run.has_hits()?, group, folder, frames))
                .transpose()?,
            columns: columns.collect::<Result<_, Error>>()?,
            bodies,
        })
    }

    /// Adds those of a frame.
    pub(crate) fn append(&mut self, frame: &Frame, store: &WholeFiles) -> Result<(), Error> {
        let rows = |count: usize| {
            u32::try_from(count).map_err(|_| Error::Column {
                name: "contacts".into(),
                reason: format!("{count} rows at a frame are more than a trajectory can have"),
            })
        };
        if let Some(contacts) = &mut self.contacts {
            contacts.append(rows(frame.contacts.len())?, &frame.contacts.to_bytes(), store)?;
        }
        if let Some(events) = &mut self.events {
            events.append(rows(frame.events.len())?, &events::to_bytes(&frame.events), store)?;
        }
        for (k, column) in self.columns.iter_mut().enumerate() {
            let Sheet { name, numbers, .. } = &column.sheet;
            let values = frame.columns.get(k).filter(|v| v.numbers() == *numbers && v.len() == self.bodies);
            let Some(values) = values else {
                let found = frame.columns.get(k).map_or("nothing".to_owned(), |values| {
                    format!("{} numbers of {}", values.len(), values.numbers().name())
                });
                let reason = format!("a frame has {found}, expected {} of {}", self.bodies, numbers.name());
                return Err(Error::Column { name: name.clone(), reason });
            };
            column.push(1, &values.to_bytes(), store)?;
        }
        Ok(())
    }

    /// Puts everything into the store.
    pub(crate) fn flush(&mut self, store: &WholeFiles) -> Result<(), Error> {
        self.contacts.iter_mut().chain(&mut self.events).try_for_each(|table| table.flush(store))?;
        self.columns.iter_mut().try_for_each(|column| column.flush(store))
    }

    /// Says how much there is.
    pub(crate) fn announce(&mut self, store: &WholeFiles) -> Result<(), Error> {
        self.contacts.iter_mut().chain(&mut self.events).try_for_each(|table| table.announce(store))?;
        self.columns.iter_mut().try_for_each(|column| column.announce(store))
    }
}

impl Contents {
    /// Whether there can be such a trajectory.
    pub(crate) fn check(&self) -> Result<(), Error> {
        check(&self.columns)
    }
}

/// The contacts of a run.
#[derive(Debug)]
pub struct ContactsReader {
    table: RaggedReader,
    folder: PathBuf,
}

/// The events of a run.
#[derive(Debug)]
pub struct EventsReader {
    table: RaggedReader,
    folder: PathBuf,
}

/// A column of a run.
#[derive(Debug)]
pub struct ColumnReader {
    numbers: NumberType,
    sheet: SheetReader,
}

impl ContactsReader {
    /// Contacts of all frames that there were when it was opened.
    pub fn total(&self) -> u64 {
        self.table.total()
    }

    /// Those of a frame.
    ///
    /// # Errors
    /// [`Error::NoFrame`], [`Error::Damaged`].
    pub fn at(&self, frame: u64) -> Result<Contacts, Error> {
        let found = Contacts::of_bytes(&self.table.at(frame)?);
        found.ok_or_else(|| Error::damaged(&self.folder, "its columns differ in length"))
    }
}

impl EventsReader {
    /// Events of all frames that there were when it was opened.
    pub fn total(&self) -> u64 {
        self.table.total()
    }

    /// Those of a frame.
    ///
    /// # Errors
    /// [`Error::NoFrame`], [`Error::Damaged`].
    pub fn at(&self, frame: u64) -> Result<Vec<Event>, Error> {
        let found = events::of_bytes(&self.table.at(frame)?);
        found.ok_or_else(|| Error::damaged(&self.folder, "it has events of no kind that there is"))
    }
}

impl ColumnReader {
    /// Its numbers at a frame, one for each body of the table.
    ///
    /// # Errors
    /// [`Error::Damaged`], also where there is no such frame.
    pub fn at(&self, frame: u64) -> Result<Values, Error> {
        Ok(Values::of_bytes(self.numbers, &self.sheet.rows(frame..frame + 1)?))
    }
}

impl RunReader {
    /// Which contacts the run has; `None` where it has none.
    ///
    /// # Errors
    /// [`Error::Damaged`].
    pub fn wanted_contacts(&self) -> Result<Option<WantedContacts>, Error> {
        match self.attributes()?.get("contacts") {
            None | Some(Value::Null) => Ok(None),
            Some(about) => {
                let wanted = about.as_object().and_then(WantedContacts::of);
                wanted
                    .map(Some)
                    .ok_or_else(|| self.group().damaged("zarr.json", "its `contacts` make no sense"))
            }
        }
    }

    /// Whether the run has events.
    ///
    /// # Errors
    /// [`Error::Damaged`].
    pub fn has_events(&self) -> Result<bool, Error> {
        Ok(self.attributes()?.get("events").is_some_and(|events| !events.is_null()))
    }

    /// Whether hits are among its events.
    ///
    /// # Errors
    /// [`Error::Damaged`].
    pub fn has_hits(&self) -> Result<bool, Error> {
        Ok(self.attributes()?.get("hits_N_s").is_some_and(|least| !least.is_null()))
    }

    /// The columns of the run beside poses and velocities.
    ///
    /// # Errors
    /// [`Error::Damaged`].
    pub fn columns(&self) -> Result<Vec<Column>, Error> {
        let none = Vec::new();
        let names = self.attributes()?.get("columns").and_then(Value::as_array).unwrap_or(&none);
        let column = |name: &Value| {
            let name = name.as_str().unwrap_or_default().to_owned();
            let numbers = NumberType::F32;
            let mut column = Column { name, numbers, units: String::new(), description: String::new() };
            // The name may say anything in a file that is damaged.
            check(std::slice::from_ref(&column))
                .map_err(|error| self.group().damaged("zarr.json", error.to_string()))?;
            let metadata = self.group().metadata(&format!("{}/zarr.json", column.name))?;
            let known = NumberType::ALL.into_iter().find(|numbers| metadata["data_type"] == numbers.name());
            let unknown = || self.group().damaged(&column.name, "it has numbers of another type");
            column.numbers = known.ok_or_else(unknown)?;
            let about = metadata.get("attributes").and_then(Value::as_object);
            let text = |name: &str| {
                let text = about.and_then(|about| about.get(name)).and_then(Value::as_str);
                text.map(str::to_owned)
                    .ok_or_else(|| self.group().damaged(&column.name, format!("it has no `{name}`")))
            };
            (column.units, column.description) = (text("units")?, text("description")?);
            Ok(column)
        };
        names.iter().map(column).collect()
    }

    /// The contacts of the run; `None` where it has none.
    ///
    /// # Errors
    /// [`Error::Damaged`].
    pub fn contacts(&self) -> Result<Option<ContactsReader>, Error> {
        let Some(wanted) = self.wanted_contacts()? else { return Ok(None) };
        let folder = self.folder();
        let table = RaggedReader::open(&CONTACTS, wanted.friction, self.group(), &folder)?;
        Ok(Some(ContactsReader { table, folder: folder.join(CONTACTS.name) }))
    }

    /// The events of the run; `None` where it has none.
    ///
    /// # Errors
    /// [`Error::Damaged`].
    pub fn events(&self) -> Result<Option<EventsReader>, Error> {
        if !self.has_events()? {
            return Ok(None);
        }
        let folder = self.folder();
        let table = RaggedReader::open(&EVENTS, self.has_hits()?, self.group(), &folder)?;
        Ok(Some(EventsReader { table, folder: folder.join(EVENTS.name) }))
    }

    /// Reads a column that [`RunReader::columns`] has.
    ///
    /// # Errors
    /// [`Error::Damaged`], also where there is no such column.
    pub fn column(&self, column: &Column) -> Result<ColumnReader, Error> {
        let bodies = self.body_count()?;
        let sheet = Sheet::of_bodies(column.name.clone(), column.numbers, bodies);
        let sheet = SheetReader::open(self.group(), &self.folder(), sheet)?;
        Ok(ColumnReader { numbers: column.numbers, sheet })
    }
}
