//! State on its way to a stream and back, column by column.
//!
//! | part | bytes |
//! |---|---|
//! | magic | 8: [`MAGIC`] |
//! | byte order | 4: 0x01020304 as this machine writes it |
//! | version | 4: [`VERSION`] |
//! | each column | length of its name (1), name, length of its type (1), type, count (8), bytes of the values (8), values, checksum (8) |
//! | end | a column without a name, type and values |
//!
//! Values lie as they do in memory, so that a column passes without a copy. The checksum is XXH3, 64 bits, over the checksum before and
//! all of the column: none can be altered, lost, doubled or exchanged. What is read is allocated as it comes, so that a count that
//! is too large ends where the stream does.
//!
//! A struct writes and reads its own columns, next to its definition; it takes itself apart without `..`, so that a field that
//! is added can't be forgotten.

mod error;
mod stored;

pub use error::Error;
pub use stored::{Get, Put, Stored, get_each, get_plain, put_each, put_plain};

use std::io::{Read, Write};
use xxhash_rust::xxh3::Xxh3;

/// The first bytes of every snapshot. The first one is no text.
pub const MAGIC: [u8; 8] = *b"\x8Frockfl\n";

/// The version of this format. Another one is refused.
pub const VERSION: u32 = 2;

/// What the byte order is told by.
const ORDER: u32 = 0x0102_0304;

/// Writes columns.
pub struct Writer<'a> {
    to: &'a mut dyn Write,
    /// Of the column at hand.
    hash: Xxh3,
    /// Bytes so far.
    bytes: u64,
}

impl<'a> Writer<'a> {
    /// Starts a snapshot. Many writes are small: `to` should have a buffer.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn new(to: &'a mut dyn Write) -> Result<Self, Error> {
        let mut writer = Writer { to, hash: Xxh3::new(), bytes: 0 };
        writer.put(&MAGIC)?;
        writer.put(&ORDER.to_ne_bytes())?;
        writer.put(&VERSION.to_ne_bytes())?;
        Ok(writer)
    }

    /// Writes a column.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn column<T: Stored>(&mut self, name: &str, column: &[T]) -> Result<(), Error> {
        self.pieces(name, column.len(), std::iter::once(column))
    }

    /// Writes a column that lies in pieces, of `count` values together.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn pieces<'p, T: Stored + 'p>(
        &mut self,
        name: &str,
        count: usize,
        pieces: impl IntoIterator<Item = &'p [T]>,
    ) -> Result<(), Error> {
        self.head(name, T::TYPE, count as u64, (count * T::SIZE) as u64)?;
        for piece in pieces {
            T::put(piece, &mut |bytes| self.put(bytes))?;
        }
        self.seal()
    }

    /// Writes a single value.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn one<T: Stored>(&mut self, name: &str, value: T) -> Result<(), Error> {
        self.column(name, &[value])
    }

    /// Writes a text.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn text(&mut self, name: &str, text: &str) -> Result<(), Error> {
        self.column(name, text.as_bytes())
    }

    /// Writes the end. Returns the number of bytes of all.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn finish(mut self) -> Result<u64, Error> {
        self.head("", "", 0, 0)?;
        self.seal()?;
        self.to.flush()?;
        Ok(self.bytes)
    }

    fn head(&mut self, name: &str, kind: &str, count: u64, bytes: u64) -> Result<(), Error> {
        for text in [name, kind] {
            // Names and types are a few letters.
            debug_assert!(text.len() < 256);
            self.put(&[text.len() as u8])?;
            self.put(text.as_bytes())?;
        }
        self.put(&count.to_ne_bytes())?;
        self.put(&bytes.to_ne_bytes())
    }

    fn seal(&mut self) -> Result<(), Error> {
        let sum = self.hash.digest().to_ne_bytes();
        self.hash = Xxh3::new();
        self.put(&sum)
    }

    fn put(&mut self, bytes: &[u8]) -> Result<(), Error> {
        self.hash.update(bytes);
        self.bytes += bytes.len() as u64;
        Ok(self.to.write_all(bytes)?)
    }
}

/// Reads columns, in the order in which they were written.
pub struct Reader<'a> {
    from: &'a mut dyn Read,
    hash: Xxh3,
}

impl<'a> Reader<'a> {
    /// Opens a snapshot. Many reads are small: `from` should have a buffer.
    ///
    /// # Errors
    /// [`Error::Format`], [`Error::ByteOrder`], [`Error::Version`], [`Error::Io`].
    pub fn new(from: &'a mut dyn Read) -> Result<Self, Error> {
        let mut reader = Reader { from, hash: Xxh3::new() };
        let (mut magic, mut order, mut version) = ([0; 8], [0; 4], [0; 4]);
        reader.get("head", &mut magic)?;
        if magic != MAGIC {
            return Err(Error::Format);
        }
        reader.get("head", &mut order)?;
        reader.get("head", &mut version)?;
        match (u32::from_ne_bytes(order), u32::from_ne_bytes(version)) {
            (ORDER, VERSION) => Ok(reader),
            (ORDER, found) => Err(Error::Version { found: found.to_string(), expected: VERSION.to_string() }),
            (order, _) if order == ORDER.swap_bytes() => Err(Error::ByteOrder),
            _ => Err(Error::Checksum { column: "head".into() }),
        }
    }

    /// Reads a column.
    ///
    /// # Errors
    /// [`Error::Column`] where another one comes, [`Error::Checksum`], [`Error::Truncated`], [`Error::Invalid`] for values that the type
    /// does not have, [`Error::Io`].
    pub fn column<T: Stored>(&mut self, name: &str) -> Result<Vec<T>, Error> {
        let count = self.expect(name, T::TYPE, T::SIZE as u64)?;
        let column = T::get(count, &mut |bytes| self.get(name, bytes))?;
        self.check(name)?;
        column.ok_or_else(|| Error::invalid(name, "a value that there is not"))
    }

    /// Reads a column of `count` values.
    ///
    /// # Errors
    /// As [`Reader::column`], and [`Error::Invalid`] for another count.
    pub fn column_of<T: Stored>(&mut self, name: &str, count: usize) -> Result<Vec<T>, Error> {
        let column = self.column(name)?;
        if column.len() == count {
            return Ok(column);
        }
        Err(Error::invalid(name, format!("{} values, expected {count}", column.len())))
    }

    /// Reads a single value.
    ///
    /// # Errors
    /// As [`Reader::column_of`].
    pub fn one<T: Stored>(&mut self, name: &str) -> Result<T, Error> {
        let value = self.column_of(name, 1)?.pop();
        value.ok_or_else(|| Error::invalid(name, "no value"))
    }

    /// Reads a text.
    ///
    /// # Errors
    /// As [`Reader::column`].
    pub fn text(&mut self, name: &str) -> Result<String, Error> {
        String::from_utf8(self.column(name)?).map_err(|_| Error::invalid(name, "not UTF-8"))
    }

    /// Reads all columns that are left, whatever they are, and the end. Returns the name of each and the bytes of its values.
    ///
    /// # Errors
    /// [`Error::Checksum`], [`Error::Truncated`], [`Error::Invalid`], [`Error::Io`].
    pub fn rest(mut self) -> Result<Vec<(String, u64)>, Error> {
        let mut columns = Vec::new();
        let mut room = vec![0; 1 << 20];
        loop {
            let Head { name, bytes, .. } = self.head("head of a column")?;
            let mut left = bytes;
            while left > 0 {
                let now = left.min(room.len() as u64) as usize;
                self.get(&name, &mut room[..now])?;
                left -= now as u64;
            }
            self.check(&name)?;
            if name.is_empty() {
                self.nothing_more()?;
                return Ok(columns);
            }
            columns.push((name, bytes));
        }
    }

    /// Reads the end, behind which nothing comes.
    ///
    /// # Errors
    /// As [`Reader::column`].
    pub fn finish(mut self) -> Result<(), Error> {
        self.expect("", "", 0)?;
        self.check("end")?;
        self.nothing_more()
    }

    fn nothing_more(&mut self) -> Result<(), Error> {
        match self.from.read(&mut [0])? {
            0 => Ok(()),
            _ => Err(Error::invalid("end", "there is more behind it")),
        }
    }

    /// Reads the head of a column that is to come, of values of `size` bytes. Returns their number.
    fn expect(&mut self, name: &str, kind: &str, size: u64) -> Result<u64, Error> {
        let found = self.head(name)?;
        if found.name != name || found.kind != kind || Some(found.bytes) != found.count.checked_mul(size) {
            return Err(Error::Column {
                expected: format!("`{name}` of {kind}"),
                found: format!("`{}` of {}", found.name, found.kind),
            });
        }
        Ok(found.count)
    }

    fn head(&mut self, place: &str) -> Result<Head, Error> {
        let mut texts = [String::new(), String::new()];
        for text in &mut texts {
            let mut len = [0];
            self.get(place, &mut len)?;
            let mut bytes = vec![0; usize::from(len[0])];
            self.get(place, &mut bytes)?;
            *text = String::from_utf8_lossy(&bytes).into_owned();
        }
        let [name, kind] = texts;
        let mut numbers = [[0; 8]; 2];
        numbers.iter_mut().try_for_each(|bytes| self.get(place, bytes))?;
        let [count, bytes] = numbers.map(u64::from_ne_bytes);
        Ok(Head { name, kind, count, bytes })
    }

    fn check(&mut self, name: &str) -> Result<(), Error> {
        let expected = self.hash.digest();
        self.hash = Xxh3::new();
        let mut sum = [0; 8];
        self.get(name, &mut sum)?;
        if u64::from_ne_bytes(sum) == expected {
            Ok(())
        } else {
            Err(Error::Checksum { column: name.into() })
        }
    }

    fn get(&mut self, name: &str, bytes: &mut [u8]) -> Result<(), Error> {
        match self.from.read_exact(bytes) {
            Ok(()) => {
                self.hash.update(bytes);
                Ok(())
            }
            Err(error) if error.kind() == std::io::ErrorKind::UnexpectedEof => {
                Err(Error::Truncated { column: name.into() })
            }
            Err(error) => Err(error.into()),
        }
    }
}

/// What stands before the values of a column.
struct Head {
    name: String,
    kind: String,
    count: u64,
    bytes: u64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Aabb, DVec3, Vec3};

    fn snapshot() -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut writer = Writer::new(&mut bytes).unwrap();
        writer.text("name", "Körper").unwrap();
        writer.column("places", &[DVec3::new(1.0, 2.0, f64::NAN), DVec3::ZERO]).unwrap();
        writer.pieces("numbers", 3, [&[1_u32, 2][..], &[], &[3]]).unwrap();
        writer.column("marks", &[true, false]).unwrap();
        writer.one("box", Aabb::new(Vec3::ZERO, Vec3::INFINITY)).unwrap();
        let len = writer.finish().unwrap();
        assert_eq!(len, bytes.len() as u64);
        bytes
    }

    type Columns = (String, Vec<DVec3>, Vec<u32>, Vec<bool>, Aabb);

    fn read(mut bytes: &[u8]) -> Result<Columns, Error> {
        let mut reader = Reader::new(&mut bytes)?;
        let all = (
            reader.text("name")?,
            reader.column("places")?,
            reader.column_of("numbers", 3)?,
            reader.column("marks")?,
            reader.one("box")?,
        );
        reader.finish()?;
        Ok(all)
    }

    #[test]
    fn what_is_written_is_read_to_the_last_bit() {
        let (name, places, numbers, marks, bounds) = read(&snapshot()).unwrap();
        assert_eq!((name.as_str(), numbers, marks), ("Körper", vec![1, 2, 3], vec![true, false]));
        assert_eq!(places[0].to_array().map(f64::to_bits), [1.0, 2.0, f64::NAN].map(f64::to_bits));
        assert_eq!(bounds, Aabb::new(Vec3::ZERO, Vec3::INFINITY));
    }

    #[test]
    fn no_byte_can_be_altered_lost_or_added() {
        let good = snapshot();
        for at in 0..good.len() {
            for bit in 0..8 {
                let mut bad = good.clone();
                bad[at] ^= 1 << bit;
                assert!(read(&bad).is_err(), "bit {bit} of byte {at}");
            }
            assert!(read(&good[..at]).is_err(), "{at} bytes");
        }
        assert!(read(&[&good[..], &[0]].concat()).is_err());
        let mut bytes = &good[..];
        let columns = Reader::new(&mut bytes).unwrap().rest().unwrap();
        let sizes: Vec<(&str, u64)> = columns.iter().map(|(name, bytes)| (name.as_str(), *bytes)).collect();
        assert_eq!(sizes, [("name", 7), ("places", 48), ("numbers", 12), ("marks", 2), ("box", 24)]);
    }

    #[test]
    fn columns_can_not_be_exchanged_between_snapshots() {
        let two = |first: u32| {
            let mut bytes = Vec::new();
            let mut writer = Writer::new(&mut bytes).unwrap();
            writer.one("first", first).unwrap();
            writer.one("second", 7_u32).unwrap();
            writer.finish().unwrap();
            bytes
        };
        let (one, other) = (two(1), two(2));
        let mut mixed = one.clone();
        let half = 16 + (1 + 5 + 1 + 3 + 8 + 8 + 4 + 8);
        mixed[..half].copy_from_slice(&other[..half]);
        let mut bytes = &mixed[..];
        let mut reader = Reader::new(&mut bytes).unwrap();
        assert_eq!(reader.one::<u32>("first").unwrap(), 2);
        assert!(matches!(reader.one::<u32>("second"), Err(Error::Checksum { .. })));
    }

    #[test]
    fn other_versions_other_machines_and_other_files_are_told_apart() {
        let altered = |at: usize, bytes: &[u8]| {
            let mut file = snapshot();
            file[at..at + bytes.len()].copy_from_slice(bytes);
            read(&file).unwrap_err()
        };
        assert!(matches!(altered(0, b"PK"), Error::Format));
        assert!(matches!(altered(8, &ORDER.swap_bytes().to_ne_bytes()), Error::ByteOrder));
        assert!(matches!(altered(12, &9_u32.to_ne_bytes()), Error::Version { .. }));
        assert!(matches!(read(b"12345678"), Err(Error::Format)));
    }

    #[test]
    fn a_count_beyond_the_stream_takes_no_memory() {
        let mut bytes = Vec::new();
        let mut writer = Writer::new(&mut bytes).unwrap();
        writer.head("numbers", u64::TYPE, u64::MAX / 8, u64::MAX / 8 * 8).unwrap();
        let mut from = &bytes[..];
        let mut reader = Reader::new(&mut from).unwrap();
        assert!(matches!(reader.column::<u64>("numbers"), Err(Error::Truncated { .. })));
    }
}
