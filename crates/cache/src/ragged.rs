//! Tables of which every frame has a number of rows of its own: `contacts` and `events`, groups within the trajectory.
//!
//! | array | type | what |
//! |---|---|---|
//! | `offset` | uint64, by frame | the first row of the frame |
//! | `count` | uint32, by frame | its rows |
//!
//! Its columns have the rows of all frames, one frame behind the other.

use crate::Error;
use crate::group::Group;
use crate::sheet::{Growing, NumberType, Sheet, SheetReader};
use crate::store::WholeFiles;
use crate::trajectory::{CHUNK_TIMES, attributes};
use serde_json::{Map, Value, json};
use std::ops::Range;
use std::path::Path;

/// Rows in a chunk of a column, at least and at most: some frames of few bodies, a part of one of very many.
const ROWS: [usize; 2] = [1 << 12, 1 << 18];

/// The rows in a chunk for so many bodies.
fn rows_in_chunk(bodies: usize) -> usize {
    bodies.saturating_mul(16).clamp(ROWS[0], ROWS[1]).next_power_of_two()
}

/// A kind of table.
#[derive(Debug)]
pub(crate) struct Kind {
    /// Its group in the trajectory.
    pub(crate) name: &'static str,
    /// All columns that there can be.
    pub(crate) columns: &'static [Column],
    /// How many of them, the first ones, every table has. The others are there where the run wants them.
    pub(crate) always: usize,
}

/// A column of one.
#[derive(Debug)]
pub(crate) struct Column {
    pub(crate) name: &'static str,
    pub(crate) numbers: NumberType,
    /// Of rows, and of the numbers in a row where it has several.
    pub(crate) dimensions: &'static [&'static str],
    pub(crate) units: Option<&'static str>,
    pub(crate) description: &'static str,
}

impl Kind {
    /// The columns of a table, with those that not every one has or without.
    fn of_table(&self, more: bool) -> &'static [Column] {
        if more { self.columns } else { &self.columns[..self.always] }
    }

    fn sheet(&self, column: &Column, span: usize) -> Sheet {
        let width = column.dimensions.get(1).map_or(1, |axes| axes.len());
        let name = format!("{}/{}", self.name, column.name);
        Sheet::of_rows(name, column.numbers, column.dimensions, width, span)
    }

    /// The rows in a chunk of the table on disk.
    fn span(&self, group: &Group) -> Result<usize, Error> {
        let name = format!("{}/{}", self.name, self.columns.first().map_or("", |column| column.name));
        let metadata = group.metadata(&format!("{name}/zarr.json"))?;
        let span = metadata.pointer("/chunk_grid/configuration/chunk_shape/0").and_then(Value::as_u64);
        let span = span.and_then(|span| usize::try_from(span).ok());
        let can_be = |span: &usize| (ROWS[0]..=ROWS[1]).contains(span);
        span.filter(can_be).ok_or_else(|| group.damaged(&name, "its chunks have no size that there can be"))
    }

    fn by_frame(&self, name: &str, numbers: NumberType) -> Sheet {
        Sheet::of_rows(format!("{}/{name}", self.name), numbers, &["frame"], 1, CHUNK_TIMES)
    }

    fn offsets(&self) -> [Sheet; 2] {
        [self.by_frame("offset", NumberType::U64), self.by_frame("count", NumberType::U32)]
    }
}

/// A table that is being written.
#[derive(Debug)]
pub(crate) struct Ragged {
    offset: Growing,
    count: Growing,
    columns: Vec<Growing>,
}

impl Ragged {
    fn empty(kind: &Kind, more: bool, span: usize) -> Self {
        let [offset, count] = kind.offsets();
        let about = |text| attributes([("description", json!(text))]);
        let column = |column: &Column| {
            let mut about = about(column.description);
            if let Some(units) = column.units {
                about.insert("units".into(), units.into());
            }
            if column.dimensions.len() > 1 {
                about.insert("axes".into(), json!(["x", "y", "z"]));
            }
            Growing::new(kind.sheet(column, span), about)
        };
        Ragged {
            offset: Growing::new(offset, about("first row of the frame")),
            count: Growing::new(count, about("rows of the frame")),
            columns: kind.of_table(more).iter().map(column).collect(),
        }
    }

    /// Starts one of a run of so many bodies, whose group has these attributes; with the columns that not every table has where there is to be `more`.
    pub(crate) fn create(
        kind: &Kind,
        more: bool,
        bodies: usize,
        about: Map<String, Value>,
        store: &WholeFiles,
    ) -> Result<Self, Error> {
        let group = json!({"zarr_format": 3, "node_type": "group", "attributes": about});
        store.put(&format!("{}/zarr.json", kind.name), group.to_string().as_bytes())?;
        Ok(Self::empty(kind, more, rows_in_chunk(bodies)))
    }

    /// Goes on after the first `frames` frames of what is in the trajectory `group` in `folder`.
    pub(crate) fn resume(
        kind: &Kind,
        more: bool,
        group: &Group,
        folder: &Path,
        frames: u64,
    ) -> Result<Self, Error> {
        let rows = RaggedReader::open(kind, more, group, folder)?.end(frames)?;
        let Ragged { offset, count, columns } = Self::empty(kind, more, kind.span(group)?);
        Ok(Ragged {
            offset: offset.resume(group, folder, frames)?,
            count: count.resume(group, folder, frames)?,
            columns: columns
                .into_iter()
                .map(|column| column.resume(group, folder, rows))
                .collect::<Result<_, Error>>()?,
        })
    }

    /// Adds a frame: its rows, and the bytes of each column.
    pub(crate) fn append(&mut self, rows: u32, columns: &[Vec<u8>], store: &WholeFiles) -> Result<(), Error> {
        let first = self.columns.first().map_or(0, Growing::rows);
        self.offset.push(1, &first.to_le_bytes(), store)?;
        self.count.push(1, &rows.to_le_bytes(), store)?;
        self.columns.iter_mut().zip(columns).try_for_each(|(to, bytes)| to.push(rows.into(), bytes, store))
    }

    /// Puts everything into the store.
    pub(crate) fn flush(&mut self, store: &WholeFiles) -> Result<(), Error> {
        self.all().try_for_each(|array| array.flush(store))
    }

    /// Says how much there is.
    pub(crate) fn announce(&mut self, store: &WholeFiles) -> Result<(), Error> {
        self.all().try_for_each(|array| array.announce(store))
    }

    /// The arrays that others refer to first.
    fn all(&mut self) -> impl Iterator<Item = &mut Growing> {
        self.columns.iter_mut().chain([&mut self.count, &mut self.offset])
    }
}

/// Reads a table.
#[derive(Debug)]
pub(crate) struct RaggedReader {
    offsets: Vec<u64>,
    counts: Vec<u32>,
    columns: Vec<SheetReader>,
}

impl RaggedReader {
    /// That of the trajectory `group` in `folder`.
    pub(crate) fn open(kind: &Kind, more: bool, group: &Group, folder: &Path) -> Result<Self, Error> {
        let [offset, count] = kind.offsets().map(|sheet| SheetReader::open(group, folder, sheet));
        let span = kind.span(group)?;
        let open = |column: &Column| SheetReader::open(group, folder, kind.sheet(column, span));
        let columns = kind.of_table(more).iter().map(open);
        let bytes = |reader: SheetReader| reader.rows(0..reader.len());
        let reader = RaggedReader {
            offsets: bytes(offset?)?.as_chunks().0.iter().map(|&b| u64::from_le_bytes(b)).collect(),
            counts: bytes(count?)?.as_chunks().0.iter().map(|&b| u32::from_le_bytes(b)).collect(),
            columns: columns.collect::<Result<_, Error>>()?,
        };
        // Each frame begins where the one before ends.
        let mut next = 0_u64;
        for (&offset, &count) in reader.offsets.iter().zip(&reader.counts) {
            if offset != next {
                return Err(
                    group.damaged(&format!("{}/offset", kind.name), "the frames do not follow each other")
                );
            }
            next += u64::from(count);
        }
        Ok(reader)
    }

    /// Rows of all frames.
    pub(crate) fn total(&self) -> u64 {
        self.counts.iter().copied().map(u64::from).sum()
    }

    /// The row behind the first `frames` frames.
    fn end(&self, frames: u64) -> Result<u64, Error> {
        match frames.checked_sub(1) {
            None => Ok(0),
            Some(last) => self.range(last).map(|rows| rows.end),
        }
    }

    fn range(&self, frame: u64) -> Result<Range<u64>, Error> {
        let index = usize::try_from(frame).unwrap_or(usize::MAX);
        match (self.offsets.get(index), self.counts.get(index)) {
            (Some(&first), Some(&count)) => Ok(first..first + u64::from(count)),
            _ => Err(Error::NoFrame { frame, frames: self.offsets.len() as u64 }),
        }
    }

    /// The bytes of each column at a frame.
    pub(crate) fn at(&self, frame: u64) -> Result<Vec<Vec<u8>>, Error> {
        let rows = self.range(frame)?;
        self.columns.iter().map(|column| column.rows(rows.clone())).collect()
    }
}
