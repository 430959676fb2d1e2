//! The tables that the rest of a file points into: tokens, strings, paths, fields and sets of fields.

use crate::integers::{self, Width};
use crate::{Error, Kind, lz4, path};
use std::collections::HashMap;

/// Where a value is, or the value itself where it is small, in eight bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Rep(u64);

impl Rep {
    const ARRAY: u64 = 1 << 63;
    const INLINE: u64 = 1 << 62;
    const COMPRESSED: u64 = 1 << 61;

    /// A value of four bytes.
    pub(crate) fn inline(kind: Kind, value: u32) -> Self {
        Rep(Rep::INLINE | (kind as u64) << 48 | u64::from(value))
    }

    /// A value at a place in the file. An array at 0 is empty.
    pub(crate) fn at(kind: Kind, place: u64) -> Self {
        Rep((kind as u64) << 48 | place)
    }

    pub(crate) fn array(self) -> Self {
        Rep(self.0 | Rep::ARRAY)
    }

    pub(crate) fn compressed(self) -> Self {
        Rep(self.0 | Rep::COMPRESSED)
    }

    pub(crate) fn to_le_bytes(self) -> [u8; 8] {
        self.0.to_le_bytes()
    }
}

/// What stands behind the last field of a set.
const END: u32 = u32::MAX;

/// Things in the order in which they came, each once.
#[derive(Debug)]
struct Numbered<T> {
    items: Vec<T>,
    numbers: HashMap<T, u32>,
}

impl<T> Default for Numbered<T> {
    fn default() -> Self {
        Numbered { items: Vec::new(), numbers: HashMap::new() }
    }
}

impl<T: Clone + Eq + std::hash::Hash> Numbered<T> {
    /// The number of an item, and whether it is new.
    fn number(&mut self, item: T, what: &'static str) -> Result<(u32, bool), Error> {
        if let Some(&number) = self.numbers.get(&item) {
            return Ok((number, false));
        }
        // Tokens are numbered with a sign.
        let number = i32::try_from(self.items.len()).map_err(|_| Error::TooMany(what))? as u32;
        self.items.push(item.clone());
        self.numbers.insert(item, number);
        Ok((number, true))
    }
}

/// The tables of a file.
#[derive(Debug)]
pub(crate) struct Tables {
    tokens: Numbered<String>,
    strings: Numbered<u32>,
    paths: Numbered<String>,
    fields: Numbered<(u32, Rep)>,
    /// The fields of all sets, each set with [`END`] behind it.
    sets: Vec<u32>,
    known_sets: HashMap<Vec<u32>, u32>,
    /// Path, set of fields and kind of everything that there is.
    specs: Vec<[u32; 3]>,
}

impl Tables {
    pub(crate) fn new() -> Self {
        let mut tokens = Numbered::default();
        // The empty token has the number 0, which has no negative, so that no property's name gets it.
        tokens.items.push(String::new());
        tokens.numbers.insert(String::new(), 0);
        Tables {
            tokens,
            strings: Numbered::default(),
            paths: Numbered::default(),
            fields: Numbered::default(),
            sets: Vec::new(),
            known_sets: HashMap::new(),
            specs: Vec::new(),
        }
    }

    pub(crate) fn token(&mut self, text: &str) -> Result<u32, Error> {
        if text.contains('\0') {
            return Err(Error::Zero(text.to_owned()));
        }
        Ok(self.tokens.number(text.to_owned(), "tokens")?.0)
    }

    pub(crate) fn string(&mut self, text: &str) -> Result<u32, Error> {
        let token = self.token(text)?;
        Ok(self.strings.number(token, "strings")?.0)
    }

    /// The number of a path, or of the empty path. Those above it get numbers too.
    pub(crate) fn path(&mut self, text: &str) -> Result<u32, Error> {
        if !text.is_empty() {
            path::check(text)?;
            let mut above = Some(text);
            while let Some(one) = above {
                if !self.paths.number(one.to_owned(), "paths")?.1 {
                    break;
                }
                self.token(path::last_name(one).0)?;
                above = path::parent(one);
            }
        }
        Ok(self.paths.number(text.to_owned(), "paths")?.0)
    }

    /// Adds something that has fields: a prim, a property or the layer.
    pub(crate) fn spec(&mut self, path: &str, kind: u32, fields: &[(&str, Rep)]) -> Result<(), Error> {
        let mut numbers = Vec::new();
        for &(name, rep) in fields {
            let token = self.token(name)?;
            numbers.push(self.fields.number((token, rep), "fields")?.0);
        }
        let set = match self.known_sets.get(&numbers) {
            Some(&set) => set,
            None => {
                let set = i32::try_from(self.sets.len()).map_err(|_| Error::TooMany("fields"))? as u32;
                self.sets.extend(&numbers);
                self.sets.push(END);
                self.known_sets.insert(numbers, set);
                set
            }
        };
        let path = self.path(path)?;
        self.specs.push([path, set, kind]);
        Ok(())
    }

    /// The sections that end a file: their names, and their bytes.
    pub(crate) fn sections(&mut self) -> Result<[(&'static str, Vec<u8>); 6], Error> {
        // Paths first: that makes sure of all tokens.
        let paths = self.paths_section()?;
        Ok([
            ("TOKENS", self.tokens_section()),
            ("STRINGS", self.strings_section()),
            ("FIELDS", self.fields_section()),
            ("FIELDSETS", list(&self.sets)),
            ("PATHS", paths),
            ("SPECS", self.specs_section()),
        ])
    }

    fn tokens_section(&self) -> Vec<u8> {
        let text: Vec<u8> = self.tokens.items.iter().flat_map(|text| text.bytes().chain([0])).collect();
        let mut out = count(self.tokens.items.len());
        out.extend(count(text.len()));
        put_sized(&lz4::compress(&text), &mut out);
        out
    }

    fn strings_section(&self) -> Vec<u8> {
        let mut out = count(self.strings.items.len());
        out.extend(self.strings.items.iter().flat_map(|token| token.to_le_bytes()));
        out
    }

    fn fields_section(&self) -> Vec<u8> {
        let names: Vec<u32> = self.fields.items.iter().map(|field| field.0).collect();
        let reps: Vec<u8> = self.fields.items.iter().flat_map(|field| field.1.to_le_bytes()).collect();
        let mut out = list(&names);
        put_sized(&lz4::compress(&reps), &mut out);
        out
    }

    fn paths_section(&mut self) -> Result<Vec<u8>, Error> {
        let texts = self.paths.items.clone();
        let mut sorted: Vec<&str> =
            texts.iter().map(String::as_str).filter(|text| !text.is_empty()).collect();
        path::sort(&mut sorted);
        let (mut numbers, mut names) = (Vec::new(), Vec::new());
        for &text in &sorted {
            let (name, is_property) = path::last_name(text);
            let token = i64::from(self.token(name)?);
            names.push(if is_property { -token } else { token });
            numbers.push(i64::from(self.path(text)?));
        }
        // The empty path has a number, but no place in the tree.
        let mut out = count(texts.len());
        out.extend(count(sorted.len()));
        for column in [numbers, names, path::jumps(&sorted)] {
            integers::put(&column, Width::Four, &mut out);
        }
        Ok(out)
    }

    fn specs_section(&self) -> Vec<u8> {
        let mut out = count(self.specs.len());
        for column in 0..3 {
            let values: Vec<i64> = self.specs.iter().map(|spec| i64::from(spec[column])).collect();
            integers::put(&values, Width::Four, &mut out);
        }
        out
    }
}

fn count(number: usize) -> Vec<u8> {
    (number as u64).to_le_bytes().to_vec()
}

/// A number of integers, and the integers.
fn list(values: &[u32]) -> Vec<u8> {
    let mut out = count(values.len());
    let values: Vec<i64> = values.iter().map(|&value| i64::from(value)).collect();
    integers::put(&values, Width::Four, &mut out);
    out
}

/// Bytes with their number before them.
fn put_sized(bytes: &[u8], to: &mut Vec<u8>) {
    to.extend((bytes.len() as u64).to_le_bytes());
    to.extend(bytes);
}
