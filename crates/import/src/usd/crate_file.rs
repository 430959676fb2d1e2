//! Checks a binary file of OpenUSD (`.usdc`) before the library reads it.
//!
//! The library takes counts and indices as they are, makes room for them, follows offsets wherever they lead, and calls itself for values in values. What
//! would make it run out of memory, time or stack, or panic, is found here; what is wrong in other ways, it says itself. The layout is that of OpenUSD's
//! `crateFile.cpp` (pxr/usd/usd, version 0.13): a head with the place of a table of sections, compressed tables of tokens, fields, paths and specs, and values
//! at offsets.

use super::names::{braces_close, refused};
use lz4_flex::block::decompress_into;
use std::collections::BTreeMap;

/// The first bytes of such a file.
pub(super) const MAGIC: &[u8] = b"PXR-USDC";

/// Paths below paths.
const DEEPEST_PATH: usize = 500;
/// Dictionaries in dictionaries, samples in samples.
const DEEPEST_VALUE: usize = 32;
/// Bytes of all paths, each with those of its parents, as the library keeps them.
const MOST_PATH_BYTES: usize = 1 << 31;
/// Elements of an array.
const MOST_ELEMENTS: u64 = 1 << 30;
/// LZ4 makes at most 255 bytes of one, and a byte holds the codes of four integers.
const MOST_INTEGERS_PER_BYTE: u64 = 255 * 4;

/// What is larger than 2 GB is, which the library can't read.
const PIECES: &str = "something in it is compressed in pieces, or not at all";

type Check<T = ()> = Result<T, String>;

/// Looks through a whole file.
pub(super) fn check(bytes: &[u8]) -> Check {
    let mut file = Crate {
        bytes,
        version: 0,
        tokens: 0,
        broken: BTreeMap::new(),
        strings: Vec::new(),
        paths: 0,
        budget: 1 << 20,
    };
    // Values that others share are counted each time; a file says few things often.
    file.budget += bytes.len();
    file.whole()
}

struct Crate<'a> {
    bytes: &'a [u8],
    /// The second number of its version; the first is 0.
    version: u32,
    /// How many there are.
    tokens: u64,
    /// Tokens whose braces do not close, by number: no names.
    broken: BTreeMap<u32, String>,
    /// The token of each string.
    strings: Vec<u32>,
    /// How many there are.
    paths: u64,
    /// Values that may still be looked at.
    budget: usize,
}

/// A place in the file.
#[derive(Clone, Copy)]
struct At(u64);

impl Crate<'_> {
    fn whole(&mut self) -> Check {
        let head: [u8; 8] = self.take(&mut At(8))?;
        let [major, minor, ..] = head;
        if major != 0 || minor < 4 {
            return Err(format!("its version is {major}.{minor}, expected 0.4 or later"));
        }
        self.version = u32::from(minor);
        let toc = self.u64(&mut At(16))?;
        let mut at = At(toc);
        let count = self.u64(&mut at)?;
        if count > 64 {
            return Err(format!("it has {count} sections"));
        }
        let mut sections = Vec::new();
        for _ in 0..count {
            let name: [u8; 16] = self.take(&mut at)?;
            let (start, size) = (self.u64(&mut at)?, self.u64(&mut at)?);
            self.fits(At(start), size, 1)?;
            sections.push((name, start));
        }
        let find = |wanted: &[u8]| {
            let named = |name: &[u8; 16]| name.split(|b| *b == 0).next() == Some(wanted);
            sections.iter().find(|(name, _)| named(name)).map(|&(_, start)| At(start))
        };
        let tokens = find(b"TOKENS").map_or(Ok(Vec::new()), |at| self.tokens(at))?;
        self.tokens = tokens.len() as u64;
        if let Some(mut at) = find(b"STRINGS") {
            self.strings = self.indices(&mut at, self.tokens)?;
        }
        if let Some(at) = find(b"PATHS") {
            self.paths = self.paths(at, &tokens)?;
        }
        let fields = find(b"FIELDS").map_or(Ok(Vec::new()), |at| self.fields(at))?;
        let mut ends = Vec::new();
        if let Some(mut at) = find(b"FIELDSETS") {
            let count = self.u64(&mut at)?;
            ends = self.integers(&mut at, count)?;
            // The largest number ends a set.
            let within = |&&i: &&i32| i == -1 || (i as u32 as usize) < fields.len();
            self.all(&ends, within, "a set of fields")?;
        }
        if let Some(mut at) = find(b"SPECS") {
            let count = self.u64(&mut at)?;
            let [paths, sets] = [self.integers(&mut at, count)?, self.integers(&mut at, count)?];
            self.integers_fit(&mut at, count)?;
            self.all(&paths, |&&i| u64::from(i as u32) < self.paths, "a spec")?;
            self.all(&sets, |&&i| (i as u32 as usize) < ends.len(), "a spec")?;
        }
        fields.into_iter().try_for_each(|value| self.value(value, 0))
    }

    fn all(&self, indices: &[i32], within: impl Fn(&&i32) -> bool, what: &str) -> Check {
        match indices.iter().find(|i| !within(i)) {
            Some(&index) => Err(format!("{what} names number {}, which is not there", index as u32)),
            None => Ok(()),
        }
    }

    /// Lengths of the tokens; keeps those that are no names.
    fn tokens(&mut self, mut at: At) -> Check<Vec<usize>> {
        let count = self.u64(&mut at)?;
        let size = self.u64(&mut at)?;
        let packed = self.u64(&mut at)?;
        self.fits(at, packed, 1)?;
        if count > size || size > packed.saturating_mul(255) || size > MOST_ELEMENTS {
            return Err(format!("{packed} bytes hold {count} tokens of {size} bytes"));
        }
        let text = self.unpack(at, packed, size as usize)?;
        let mut tokens: Vec<&[u8]> = text.split(|b| *b == 0).collect();
        // Each ends with a zero, so that nothing is behind the last one.
        tokens.pop();
        let broken = tokens.iter().enumerate().filter(|(_, token)| !braces_close(token));
        self.broken =
            broken.map(|(k, token)| (k as u32, String::from_utf8_lossy(token).into_owned())).collect();
        Ok(tokens.into_iter().map(<[u8]>::len).collect())
    }

    /// Paths must be a tree, in which each is found once.
    fn paths(&self, mut at: At, tokens: &[usize]) -> Check<u64> {
        let (room, count) = (self.u64(&mut at)?, self.u64(&mut at)?);
        let indices = self.integers(&mut at, count)?;
        let names = self.integers(&mut at, count)?;
        let jumps = self.integers(&mut at, count)?;
        if room > MOST_ELEMENTS || room > count.saturating_mul(64).saturating_add(1 << 20) {
            return Err(format!("it has room for {room} paths, but only {count} of them"));
        }
        if let Some(index) = indices.iter().find(|&&index| index as u32 as u64 >= room) {
            return Err(format!("a path has the number {index}, but there are {room}"));
        }
        let mut seen = vec![false; jumps.len()];
        let mut bytes = 0_usize;
        // Place in the lists, depth, and length of what it is below.
        let mut waiting = vec![(0_usize, 0_usize, 0_usize)];
        while let Some((mut here, mut depth, mut length)) = waiting.pop() {
            loop {
                let known = seen.get_mut(here).is_none_or(|seen| std::mem::replace(seen, true));
                if known || depth > DEEPEST_PATH {
                    return Err("its paths are not a tree, or too deep".into());
                }
                // The first is the root, which has no name.
                let own = match here {
                    0 => 1,
                    _ => {
                        let name = names[here].unsigned_abs();
                        self.name(name)?;
                        length.saturating_add(tokens[name as usize] + 1)
                    }
                };
                bytes = bytes.saturating_add(own);
                if bytes > MOST_PATH_BYTES {
                    return Err("its paths are too long".into());
                }
                let jump = jumps[here];
                if jump > 0 {
                    waiting.push((here + jump as usize, depth, length));
                }
                match jump {
                    i32::MIN..=-2 => break,
                    0 => {}
                    _ => (depth, length) = (depth + 1, own),
                }
                here += 1;
            }
        }
        Ok(room)
    }

    /// The values of all fields.
    fn fields(&self, mut at: At) -> Check<Vec<u64>> {
        let count = self.u64(&mut at)?;
        let names = self.integers(&mut at, count)?;
        self.all(&names, |&&i| u64::from(i as u32) < self.tokens, "a field")?;
        let packed = self.u64(&mut at)?;
        self.fits(at, packed, 1)?;
        if count.saturating_mul(8) > packed.saturating_mul(255) || count > MOST_ELEMENTS {
            return Err(format!("{packed} bytes hold {count} fields"));
        }
        let values = self.unpack(at, packed, 8 * count as usize)?;
        if values.len() as u64 != 8 * count {
            return Err(format!("{count} fields have {} bytes of values", values.len()));
        }
        Ok(values.as_chunks().0.iter().map(|word| u64::from_le_bytes(*word)).collect())
    }

    /// Looks at a value: its type, whether it is an array, and where it is.
    fn value(&mut self, value: u64, depth: usize) -> Check {
        let left = self.budget.checked_sub(1).filter(|_| depth <= DEEPEST_VALUE);
        self.budget = left.ok_or("values in values have no end")?;
        let flag = |bit: u32| value >> bit & 1 == 1;
        let (array, inlined, packed) = (flag(63), flag(62), flag(61));
        let (kind, at) = ((value >> 48 & 0xff) as u8, At(value & ((1 << 48) - 1)));
        if array && inlined {
            return Err(format!("an array of type {kind} is written in a way that it can't be"));
        }
        match kind {
            // Lists of strings, of asset paths and of path expressions are numbers of strings.
            10 | 12 | 57 if array && at.0 == 0 => Ok(()),
            10 | 12 | 57 if array => self.strings(&mut At(at.0)),
            _ if array => self.array(kind, at, packed),
            10 => self.string(if inlined { value as u32 } else { self.u32(&mut At(at.0))? }),
            11 | 53 if !inlined => Err("a token is not where it should be".into()),
            11 => self.name(value as u32),
            12 | 53 | 57 if inlined => self.below(value as u32, self.tokens),
            12 | 57 => self.string(self.u32(&mut At(at.0))?),
            31 if inlined => Ok(()),
            31 => self.dictionary(&mut At(at.0), depth),
            32..=41 | 45..=50 | 54 | 55 | 58 if inlined || array || packed => {
                Err(format!("a value of type {kind} is written in a way that it can't be"))
            }
            32 => self.lists(at, |file, at| file.names(at)),
            34 => self.lists(at, |file, at| file.indices(at, file.paths).map(|_| ())),
            33 => self.lists(at, |file, at| {
                let strings = file.indices(at, file.strings.len() as u64)?;
                strings.into_iter().try_for_each(|string| file.named(string))
            }),
            54 => self.lists(at, Self::strings),
            36 | 38 => self.lists(at, |file, at| file.list(at, 4)),
            37 | 39 => self.lists(at, |file, at| file.list(at, 8)),
            35 => self.lists(at, |file, at| {
                let count = file.u64(at)?;
                file.fits(*at, count, 32)?;
                (0..count).try_for_each(|_| {
                    file.target(at)?;
                    at.0 += 16;
                    file.dictionary(at, depth)
                })
            }),
            47 => self.target(&mut At(at.0)),
            55 => self.lists(at, |file, at| {
                let offset = if file.version >= 8 { 16 } else { 0 };
                let count = file.u64(at)?;
                file.fits(*at, count, 8 + offset)?;
                (0..count).try_for_each(|_| {
                    file.target(at)?;
                    at.0 += offset;
                    Ok(())
                })
            }),
            40 => self.indices(&mut At(at.0), self.paths).map(|_| ()),
            41 => self.names(&mut At(at.0)),
            50 => self.strings(&mut At(at.0)),
            45 => {
                let mut at = At(at.0);
                let count = self.u64(&mut at)?;
                self.fits(at, count, 8)?;
                // Sets of variants, and which of each is selected.
                (0..2 * count).try_for_each(|_| self.named(self.u32(&mut at)?))
            }
            58 => {
                let mut at = At(at.0);
                let count = self.u64(&mut at)?;
                self.fits(at, count, 8)?;
                (0..2 * count).try_for_each(|_| self.below(self.u32(&mut at)?, self.paths))
            }
            49 => self.list(&mut At(at.0), 16),
            46 => self.samples(at, depth),
            48 => self.array(9, at, packed),
            _ => Ok(()),
        }
    }

    /// A reference or a payload: the string of a file, and a path in it.
    fn target(&self, at: &mut At) -> Check {
        self.string(self.u32(at)?)?;
        self.below(self.u32(at)?, self.paths)
    }

    /// The number of a string must be one.
    fn string(&self, index: u32) -> Check {
        self.below(index, self.strings.len() as u64)
    }

    /// A token that may become part of a path must be a name.
    fn name(&self, token: u32) -> Check {
        self.below(token, self.tokens)?;
        self.broken.get(&token).map_or(Ok(()), |token| Err(refused(token)))
    }

    /// The token of a string must be a name.
    fn named(&self, string: u32) -> Check {
        self.string(string)?;
        self.name(self.strings[string as usize])
    }

    /// A count, and so many tokens that are names; ends behind them.
    fn names(&self, at: &mut At) -> Check {
        self.indices(at, self.tokens)?.into_iter().try_for_each(|token| self.name(token))
    }

    fn below(&self, index: u32, count: u64) -> Check {
        match u64::from(index) < count {
            true => Ok(()),
            false => Err(format!("a value names number {index}, but there are {count}")),
        }
    }

    /// A count, and so many numbers of strings.
    fn strings(&mut self, at: &mut At) -> Check {
        self.indices(at, self.strings.len() as u64).map(|_| ())
    }

    /// A count, and so many numbers below `limit`; ends behind them.
    fn indices(&self, at: &mut At, limit: u64) -> Check<Vec<u32>> {
        let count = self.u64(at)?;
        self.fits(*at, count, 4)?;
        let one = |_| {
            let index = self.u32(at)?;
            self.below(index, limit).map(|()| index)
        };
        (0..count).map(one).collect()
    }

    /// An array of elements that are all of one size, or integers or floats that are compressed.
    fn array(&self, kind: u8, mut at: At, packed: bool) -> Check {
        // Bytes of an element.
        let size = match kind {
            1 | 2 => 1,
            7 => 2,
            3 | 4 | 8 | 11 | 22 => 4,
            5 | 6 | 9 | 21 | 56 => 8,
            20 => 8,
            24 => 12,
            25 => 6,
            26 => 12,
            19 | 17 => 16,
            18 | 29 => 8,
            28 | 30 => 16,
            23 => 24,
            27 | 16 | 13 => 32,
            14 => 72,
            15 => 128,
            _ => return Err(format!("a value of type {kind} is an array")),
        };
        if packed && !matches!(kind, 3..=9 | 56) {
            return Err(format!("an array of type {kind} is compressed"));
        }
        if at.0 == 0 {
            return Ok(());
        }
        if self.version < 5 {
            at.0 += 4;
        }
        let count = if self.version < 7 { u64::from(self.u32(&mut at)?) } else { self.u64(&mut at)? };
        let integers = matches!(kind, 3..=6) && self.version >= 5;
        let floats = matches!(kind, 7..=9 | 56) && self.version >= 6;
        if !packed || !(integers || floats) || count < 4 {
            self.fits(at, count, size)?;
            let tokens = if kind == 11 { count } else { 0 };
            return (0..tokens).try_for_each(|_| self.name(self.u32(&mut at)?));
        }
        if floats {
            let [code] = self.take(&mut at)?;
            if code == b't' {
                let table = u64::from(self.u32(&mut at)?);
                self.fits(at, table, size)?;
                at.0 += table * size;
            }
        }
        self.integers_fit(&mut at, count)
    }

    /// Up to six lists, as the bits of the first byte say.
    fn lists(&mut self, mut at: At, mut list: impl FnMut(&mut Self, &mut At) -> Check) -> Check {
        let [bits] = self.take(&mut at)?;
        (0..(bits >> 1 & 0x3f).count_ones()).try_for_each(|_| list(self, &mut at))
    }

    /// A count, and so many elements of `size` bytes; ends behind them.
    fn list(&self, at: &mut At, size: u64) -> Check {
        let count = self.u64(at)?;
        self.fits(*at, count, size)?;
        at.0 += count * size;
        Ok(())
    }

    /// Names and values; ends behind it.
    fn dictionary(&mut self, at: &mut At, depth: usize) -> Check {
        let count = self.u64(at)?;
        self.fits(*at, count, 12)?;
        for _ in 0..count {
            self.string(self.u32(at)?)?;
            self.jump(at)?;
            let value = self.u64(at)?;
            self.value(value, depth + 1)?;
        }
        Ok(())
    }

    fn samples(&mut self, mut at: At, depth: usize) -> Check {
        self.jump(&mut at)?;
        let times = self.u64(&mut at)?;
        self.value(times, depth + 1)?;
        self.jump(&mut at)?;
        let count = self.u64(&mut at)?;
        self.fits(at, count, 8)?;
        (0..count).try_for_each(|_| {
            let value = self.u64(&mut at)?;
            self.value(value, depth + 1)
        })
    }

    /// Goes where an offset leads from where it stands.
    fn jump(&self, at: &mut At) -> Check {
        let start = at.0;
        let offset = self.u64(at)? as i64;
        at.0 = start.checked_add_signed(offset).ok_or("an offset leads out of it")?;
        Ok(())
    }

    /// Compressed integers of 32 bits, `count` of them; ends behind them.
    fn integers(&self, at: &mut At, count: u64) -> Check<Vec<i32>> {
        let (start, size) = self.integers_at(at, count)?;
        let count = count as usize;
        if count == 0 {
            return Ok(Vec::new());
        }
        let coded = self.unpack(start, size, 4 + count.div_ceil(4) + 4 * count)?;
        decode(&coded, count).ok_or_else(|| "its integers end early".to_owned())
    }

    fn integers_fit(&self, at: &mut At, count: u64) -> Check {
        self.integers_at(at, count).map(|_| ())
    }

    /// Where compressed integers are, and how many bytes.
    fn integers_at(&self, at: &mut At, count: u64) -> Check<(At, u64)> {
        let size = self.u64(at)?;
        self.fits(*at, size, 1)?;
        let start = *at;
        if size > 0 && self.bytes[start.0 as usize] != 0 {
            return Err(PIECES.into());
        }
        at.0 += size;
        if count > size.saturating_mul(MOST_INTEGERS_PER_BYTE) || count > MOST_ELEMENTS {
            return Err(format!("{size} bytes hold {count} integers"));
        }
        Ok((start, size))
    }

    /// What `size` bytes at a place unpack to, at most `most` bytes.
    fn unpack(&self, at: At, size: u64, most: usize) -> Check<Vec<u8>> {
        let packed = &self.bytes[at.0 as usize..(at.0 + size) as usize];
        let [0, packed @ ..] = packed else {
            return Err(PIECES.into());
        };
        let mut bytes = vec![0; most];
        let found = decompress_into(packed, &mut bytes).map_err(|error| error.to_string())?;
        bytes.truncate(found);
        Ok(bytes)
    }

    /// Whether `count` elements of `size` bytes are in the file.
    fn fits(&self, at: At, count: u64, size: u64) -> Check {
        let end = count.checked_mul(size).and_then(|bytes| bytes.checked_add(at.0));
        match end.is_some_and(|end| end <= self.bytes.len() as u64) {
            true => Ok(()),
            false => Err(format!("{count} elements at byte {} reach beyond its end", at.0)),
        }
    }

    fn take<const N: usize>(&self, at: &mut At) -> Check<[u8; N]> {
        let start = usize::try_from(at.0).ok();
        let found = start.and_then(|start| self.bytes.get(start..start.checked_add(N)?)?.try_into().ok());
        at.0 = at.0.saturating_add(N as u64);
        found.ok_or_else(|| "it ends early".to_owned())
    }

    fn u32(&self, at: &mut At) -> Check<u32> {
        self.take(at).map(u32::from_le_bytes)
    }

    fn u64(&self, at: &mut At) -> Check<u64> {
        self.take(at).map(u64::from_le_bytes)
    }
}

/// Integers from differences: a common one, two bits for each that say how it is written, and what is written (`integerCoding.cpp`).
fn decode(coded: &[u8], count: usize) -> Option<Vec<i32>> {
    let (common, rest) = coded.split_first_chunk()?;
    let common = i32::from_le_bytes(*common);
    let (codes, mut rest) = rest.split_at_checked(count.div_ceil(4))?;
    let mut last = 0_i32;
    let mut next = |k: usize| {
        let difference = match codes[k / 4] >> (2 * (k % 4)) & 3 {
            0 => common,
            1 => {
                let (x, more) = rest.split_first_chunk()?;
                rest = more;
                i8::from_le_bytes(*x).into()
            }
            2 => {
                let (x, more) = rest.split_first_chunk()?;
                rest = more;
                i16::from_le_bytes(*x).into()
            }
            _ => {
                let (x, more) = rest.split_first_chunk()?;
                rest = more;
                i32::from_le_bytes(*x)
            }
        };
        last = last.wrapping_add(difference);
        Some(last)
    };
    (0..count).map(&mut next).collect()
}
