//! Arrays of any numbers that grow with a run: what contacts, events and columns of a program's own lie in.
//!
//! A chunk holds some rows; of an array that has a value for each body, of some bodies. Its bytes are shuffled, the lowest of all numbers first, and
//! compressed, as those of poses are (`moving.rs`); of values by frame and body the frames of a body are side by side first.

use crate::Error;
use crate::group::Group;
use crate::moving::{LEVEL, Moving};
use crate::precision::Numbers;
use crate::store::WholeFiles;
use serde_json::{Map, Value, json};
use std::fs;
use std::io;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use zstd::bulk::{Compressor, Decompressor};

/// A type of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberType {
    /// Single precision; NaN is absent.
    F32,
    /// Double precision; NaN is absent.
    F64,
    /// A byte.
    U8,
    /// 32 bits, unsigned; 0 where absent.
    U32,
    /// 64 bits, unsigned; 0 where absent.
    U64,
}

impl NumberType {
    /// All of them.
    pub const ALL: [NumberType; 5] =
        [NumberType::F32, NumberType::F64, NumberType::U8, NumberType::U32, NumberType::U64];

    /// As Zarr calls it.
    pub fn name(self) -> &'static str {
        match self {
            NumberType::F32 => "float32",
            NumberType::F64 => "float64",
            NumberType::U8 => "uint8",
            NumberType::U32 => "uint32",
            NumberType::U64 => "uint64",
        }
    }

    /// Bytes of a number.
    pub fn bytes(self) -> usize {
        match self {
            NumberType::U8 => 1,
            NumberType::F32 | NumberType::U32 => 4,
            NumberType::F64 | NumberType::U64 => 8,
        }
    }

    /// The bytes of what is absent.
    pub(crate) fn absent(self) -> Vec<u8> {
        match self {
            NumberType::F32 => f32::NAN.to_le_bytes().to_vec(),
            NumberType::F64 => f64::NAN.to_le_bytes().to_vec(),
            _ => vec![0; self.bytes()],
        }
    }

    fn fill_value(self) -> Value {
        match self {
            NumberType::F32 | NumberType::F64 => json!("NaN"),
            _ => json!(0),
        }
    }
}

/// One array.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Sheet {
    /// Its name in the trajectory, such as `contacts/normal`.
    pub(crate) name: String,
    pub(crate) numbers: NumberType,
    /// Names of its dimensions: of rows, and where a row has several numbers, of those.
    dimensions: &'static [&'static str],
    /// Numbers of a row.
    width: usize,
    /// Rows in a chunk,
    span: usize,
    /// and numbers of each row in it.
    part: usize,
}

impl Sheet {
    /// Rows with `width` numbers each, `span` of them in a chunk.
    pub(crate) fn of_rows(
        name: String,
        numbers: NumberType,
        dimensions: &'static [&'static str],
        width: usize,
        span: usize,
    ) -> Self {
        Sheet { name, numbers, dimensions, width, span, part: width }
    }

    /// A number for each body at each frame, in the chunks of the poses.
    pub(crate) fn of_bodies(name: String, numbers: NumberType, bodies: usize) -> Self {
        let Moving { span, chunk, .. } = Moving::new("position", "xyz", Numbers::Bits, bodies);
        Sheet { name, numbers, dimensions: &["frame", "body"], width: bodies, span, part: chunk }
    }

    /// What its `zarr.json` says when it has so many rows.
    pub(crate) fn metadata(&self, rows: u64, attributes: &Map<String, Value>) -> Value {
        let codec = |name: &str, configuration| json!({"name": name, "configuration": configuration});
        let bytes = self.numbers.bytes();
        // Of single bytes nothing is shuffled, and their order needs no telling.
        let order = if bytes > 1 { json!({"endian": "little"}) } else { json!({}) };
        let codecs = [
            self.turned().then(|| codec("transpose", json!({"order": [1, 0]}))),
            Some(codec("bytes", order)),
            (bytes > 1).then(|| codec("numcodecs.shuffle", json!({"elementsize": bytes}))),
            Some(codec("zstd", json!({"level": LEVEL, "checksum": true}))),
        ];
        let of = |rows: u64, width: usize| match self.dimensions.len() {
            1 => vec![rows],
            _ => vec![rows, width as u64],
        };
        json!({
            "zarr_format": 3,
            "node_type": "array",
            "shape": of(rows, self.width),
            "data_type": self.numbers.name(),
            "chunk_grid": {
                "name": "regular",
                "configuration": {"chunk_shape": of(self.span as u64, self.part)},
            },
            "chunk_key_encoding": {"name": "default", "configuration": {"separator": "."}},
            "fill_value": self.numbers.fill_value(),
            "codecs": codecs.into_iter().flatten().collect::<Vec<Value>>(),
            "attributes": attributes,
            "dimension_names": self.dimensions,
        })
    }

    /// The number of rows that a `zarr.json` says, of this array but for its attributes.
    fn rows_in(&self, metadata: &Value) -> Result<u64, String> {
        let rows = metadata.pointer("/shape/0").and_then(Value::as_u64).ok_or("it has no length")?;
        let expected = self.metadata(rows, &Map::new());
        let differs =
            |(key, value): (&String, &Value)| key != "attributes" && metadata.get(key) != Some(value);
        match expected.as_object().and_then(|all| all.iter().find(|entry| differs(*entry))) {
            Some((key, _)) => Err(format!("its {key} is not what this program writes")),
            None => Ok(rows),
        }
    }

    /// Whether the rows of a number lie side by side.
    fn turned(&self) -> bool {
        self.dimensions == ["frame", "body"]
    }

    /// Chunks side by side.
    fn columns(&self) -> usize {
        self.width.div_ceil(self.part.max(1))
    }

    fn key(&self, row: u64, column: usize) -> String {
        match self.dimensions.len() {
            1 => format!("{}/c.{row}", self.name),
            _ => format!("{}/c.{row}.{column}", self.name),
        }
    }

    /// Bytes of a row.
    pub(crate) fn row_bytes(&self) -> usize {
        self.width * self.numbers.bytes()
    }

    /// Bytes of the rows of a chunk.
    pub(crate) fn chunk_bytes(&self) -> usize {
        self.span * self.row_bytes()
    }

    /// The places of a chunk's numbers among those of its rows, in the order in which they lie in it; `None` for those beyond the last column.
    fn places(&self, column: usize) -> Vec<Option<usize>> {
        let first = column * self.part;
        let turned = self.turned();
        let (outer, inner) = if turned { (self.part, self.span) } else { (self.span, self.part) };
        let mut places = Vec::with_capacity(outer * inner);
        for i in 0..outer {
            places.extend((0..inner).map(|j| {
                let (row, at) = if turned { (j, first + i) } else { (i, first + j) };
                (at < self.width).then_some(row * self.width + at)
            }));
        }
        places
    }

    /// The bytes of a chunk; `values` are those of its rows.
    fn encode(&self, values: &[u8], column: usize) -> io::Result<Vec<u8>> {
        let (bytes, absent) = (self.numbers.bytes(), self.numbers.absent());
        let places = self.places(column);
        let mut planes = vec![0; places.len() * bytes];
        for (byte, plane) in planes.chunks_exact_mut(places.len()).enumerate() {
            for (to, place) in plane.iter_mut().zip(&places) {
                *to = place.map_or(absent[byte], |at| values[at * bytes + byte]);
            }
        }
        let mut compressor = Compressor::new(LEVEL)?;
        compressor.include_checksum(true)?;
        compressor.compress(&planes)
    }

    /// Puts the numbers of a chunk where they are in the `values` of its rows.
    fn decode(&self, chunk: &[u8], column: usize, values: &mut [u8]) -> io::Result<()> {
        let bytes = self.numbers.bytes();
        let places = self.places(column);
        let size = places.len() * bytes;
        let planes = Decompressor::new()?.decompress(chunk, size)?;
        if planes.len() != size {
            return Err(io::Error::other(format!("it has {} bytes, and not {size}", planes.len())));
        }
        for (byte, plane) in planes.chunks_exact(places.len()).enumerate() {
            for (from, place) in plane.iter().zip(&places) {
                if let Some(at) = place {
                    values[at * bytes + byte] = *from;
                }
            }
        }
        Ok(())
    }
}

/// An array that is being written.
#[derive(Debug)]
pub(crate) struct Growing {
    pub(crate) sheet: Sheet,
    attributes: Map<String, Value>,
    /// The rows of the chunk that is not full.
    values: Vec<u8>,
    /// Rows that there are, those included that are on disk.
    rows: u64,
    /// Rows that are in the store, and that it says there are; `None` where that is not known. What has not changed is not written again: of events there
    /// may be none for a long time, and every file that is written has to be handed to the disk before a checkpoint.
    stored: Option<u64>,
    said: Option<u64>,
}

impl Growing {
    pub(crate) fn new(sheet: Sheet, attributes: Map<String, Value>) -> Self {
        Growing { sheet, attributes, values: Vec::new(), rows: 0, stored: None, said: None }
    }

    /// Goes on after the first `rows` rows of what is on disk.
    pub(crate) fn resume(mut self, group: &Group, folder: &Path, rows: u64) -> Result<Self, Error> {
        let reader = SheetReader::open(group, folder, self.sheet.clone())?;
        let full = rows - rows % self.sheet.span as u64;
        (self.rows, self.values) = (rows, reader.rows(full..rows)?);
        Ok(self)
    }

    /// Rows that there are.
    pub(crate) fn rows(&self) -> u64 {
        self.rows
    }

    /// Adds some rows, and writes the chunks that become full.
    pub(crate) fn push(&mut self, rows: u64, bytes: &[u8], store: &WholeFiles) -> Result<(), Error> {
        let (span, size) = (self.sheet.span as u64, self.sheet.row_bytes());
        let (mut missing, mut bytes) = (rows, bytes);
        while missing > 0 {
            let now = missing.min(span - self.rows % span);
            let (these, rest) = bytes.split_at(now as usize * size);
            self.values.extend_from_slice(these);
            (missing, bytes, self.rows) = (missing - now, rest, self.rows + now);
            if self.rows.is_multiple_of(span) {
                self.write(self.rows / span - 1, store)?;
                self.stored = Some(self.rows);
                self.values.clear();
            }
        }
        Ok(())
    }

    /// Writes the chunk that is not full.
    pub(crate) fn flush(&mut self, store: &WholeFiles) -> Result<(), Error> {
        let span = self.sheet.span as u64;
        if !self.rows.is_multiple_of(span) && self.stored != Some(self.rows) {
            self.write(self.rows / span, store)?;
            self.stored = Some(self.rows);
        }
        Ok(())
    }

    fn write(&self, row: u64, store: &WholeFiles) -> Result<(), Error> {
        let absent = self.sheet.numbers.absent();
        let mut rows = self.values.clone();
        let missing = (self.sheet.chunk_bytes() - rows.len()) / absent.len();
        rows.extend(std::iter::repeat_n(&absent[..], missing).flatten());
        for column in 0..self.sheet.columns() {
            let bytes = self.sheet.encode(&rows, column).map_err(|error| store.explain(error))?;
            store.put(&self.sheet.key(row, column), &bytes)?;
        }
        Ok(())
    }

    /// Says how many rows there are.
    pub(crate) fn announce(&mut self, store: &WholeFiles) -> Result<(), Error> {
        if self.said != Some(self.rows) {
            let metadata = self.sheet.metadata(self.rows, &self.attributes).to_string();
            store.put(&format!("{}/zarr.json", self.sheet.name), metadata.as_bytes())?;
            self.said = Some(self.rows);
        }
        Ok(())
    }
}

/// Reads an array.
#[derive(Debug)]
pub(crate) struct SheetReader {
    sheet: Sheet,
    folder: PathBuf,
    /// Rows that there were when it was opened.
    rows: u64,
    /// The chunks that were read last, side by side, and their number: what is wanted next is most often among them.
    last: Mutex<Option<(u64, Vec<u8>)>>,
}

impl SheetReader {
    /// That of the group in `folder`, which has to be `sheet`.
    pub(crate) fn open(group: &Group, folder: &Path, sheet: Sheet) -> Result<Self, Error> {
        let metadata = group.metadata(&format!("{}/zarr.json", sheet.name))?;
        let rows = sheet.rows_in(&metadata).map_err(|reason| group.damaged(&sheet.name, reason))?;
        Ok(SheetReader { sheet, folder: folder.to_owned(), rows, last: Mutex::default() })
    }

    /// Rows that there were when it was opened.
    pub(crate) fn len(&self) -> u64 {
        self.rows
    }

    /// The bytes of some rows.
    pub(crate) fn rows(&self, wanted: Range<u64>) -> Result<Vec<u8>, Error> {
        if wanted.end > self.rows || wanted.start > wanted.end {
            let path = self.folder.join(&self.sheet.name);
            return Err(Error::damaged(&path, format!("it has {} rows, and not {}", self.rows, wanted.end)));
        }
        let (span, size) = (self.sheet.span as u64, self.sheet.row_bytes());
        let mut bytes = Vec::new();
        // Nobody panics while it is held; and what it guards is whole at any time.
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        for row in wanted.start / span..wanted.end.div_ceil(span) {
            if last.as_ref().is_none_or(|(index, _)| *index != row) {
                *last = None;
                let mut values = vec![0; self.sheet.chunk_bytes()];
                for column in 0..self.sheet.columns() {
                    let path = self.folder.join(self.sheet.key(row, column));
                    let chunk = fs::read(&path).map_err(|error| Error::damaged(&path, error))?;
                    self.sheet
                        .decode(&chunk, column, &mut values)
                        .map_err(|error| Error::damaged(&path, error))?;
                }
                *last = Some((row, values));
            }
            let Some((_, values)) = last.as_ref() else { continue };
            let from = wanted.start.max(row * span) - row * span;
            let to = wanted.end.min((row + 1) * span) - row * span;
            bytes.extend_from_slice(&values[from as usize * size..to as usize * size]);
        }
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall_math::hash::mix;

    fn bytes(count: usize, seed: u64) -> Vec<u8> {
        (0..count as u64).map(|i| (mix(i + seed) >> (mix(i) % 60)) as u8).collect()
    }

    /// Promise: rows come back as they were, in whatever pieces they are written, also when the writer stops in between and goes on.
    #[test]
    fn rows_come_back_and_a_writer_goes_on() {
        for numbers in NumberType::ALL {
            for (sheet, rows) in [
                (Sheet::of_rows("x/a".into(), numbers, &["contact"], 1, 100), 1234),
                (Sheet::of_rows("x/b".into(), numbers, &["contact", "xyz"], 3, 64), 640),
                (Sheet { span: 8, part: 5, ..Sheet::of_bodies("c".into(), numbers, 12) }, 30),
            ] {
                let folder = tempfile::tempdir().unwrap();
                let store = WholeFiles::new(folder.path().to_owned());
                let group = Group::open(folder.path()).unwrap();
                let size = sheet.row_bytes();
                let all = bytes(rows * size, 7);
                let mut writer = Growing::new(sheet.clone(), Map::new());
                for part in all.chunks(37 * size) {
                    writer.push((part.len() / size) as u64, part, &store).unwrap();
                }
                writer.flush(&store).unwrap();
                writer.announce(&store).unwrap();
                assert_eq!(writer.rows(), rows as u64);
                let reader = SheetReader::open(&group, folder.path(), sheet.clone()).unwrap();
                assert!(reader.rows(0..rows as u64).unwrap() == all);
                for (from, to) in [(0, 0), (5, 5), (3, 17), (rows / 2, rows), (rows - 1, rows)] {
                    let part = reader.rows(from as u64..to as u64).unwrap();
                    assert_eq!(part, all[from * size..to * size]);
                }
                assert!(reader.rows(0..rows as u64 + 1).is_err());

                let files = || -> Vec<(PathBuf, Vec<u8>)> {
                    let folder = folder.path().join(&sheet.name);
                    let mut all: Vec<_> =
                        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
                    all.sort();
                    all.into_iter().map(|path| (path.clone(), fs::read(path).unwrap())).collect()
                };
                let before = files();
                let kept = rows * 2 / 5;
                let again =
                    Growing::new(sheet.clone(), Map::new()).resume(&group, folder.path(), kept as u64);
                let mut again = again.unwrap();
                again.push((rows - kept) as u64, &all[kept * size..], &store).unwrap();
                again.flush(&store).unwrap();
                again.announce(&store).unwrap();
                assert!(files() == before);
            }
        }
    }

    /// Promise: nothing is written where nothing has come, so that there is nothing to hand to the disk.
    #[test]
    fn what_has_not_changed_is_not_written_again() {
        let folder = tempfile::tempdir().unwrap();
        let store = WholeFiles::new(folder.path().to_owned());
        let sheet = Sheet::of_rows("x".into(), NumberType::U32, &["event"], 1, 100);
        let mut writer = Growing::new(sheet, Map::new());
        let mut write = |rows: u64| {
            writer.push(rows, &vec![7; 4 * rows as usize], &store).unwrap();
            writer.flush(&store).unwrap();
            writer.announce(&store).unwrap();
            ["x/c.0", "x/zarr.json"].map(|name| fs::remove_file(folder.path().join(name)).is_ok())
        };
        assert_eq!(write(0), [false, true]);
        assert_eq!(write(0), [false, false]);
        assert_eq!(write(3), [true, true]);
        assert_eq!(write(0), [false, false]);
        assert_eq!(write(97), [true, true]);
        assert_eq!(write(0), [false, false]);
    }

    #[test]
    fn another_array_is_refused() {
        let sheet = Sheet::of_rows("a".into(), NumberType::F32, &["contact"], 1, 100);
        let mut metadata = sheet.metadata(7, &Map::new());
        assert_eq!(sheet.rows_in(&metadata), Ok(7));
        metadata["data_type"] = json!("float64");
        assert_eq!(sheet.rows_in(&metadata).unwrap_err(), "its data_type is not what this program writes");
    }
}
