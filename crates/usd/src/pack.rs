//! Values on their way into a file.
//!
//! A value of up to four bytes, and a text, lies where it is pointed at; all others lie somewhere in the file, equal ones once. An array is its length
//! and its elements, and starts at a multiple of eight bytes, so that readers can map it into memory. Integers in arrays of 16 and more are packed.

use crate::integers::{self, Width};
use crate::tables::Rep;
use crate::value::Kind;
use crate::{Array, Dictionary, Error, ListOp, Reference, Value, Writer};
use half::f16;

/// The least number of integers that is packed.
const PACKED_FROM: usize = 16;

/// What a value in another place has before it: how far on from here that place begins. Here it always comes next.
const NEXT: [u8; 8] = 8u64.to_le_bytes();

/// Something that lies in a file as its bytes, low ones first.
trait Plain {
    fn put(&self, to: &mut Vec<u8>);
}

macro_rules! plain {
    ($($number:ty),*) => {$(
        impl Plain for $number {
            fn put(&self, to: &mut Vec<u8>) {
                to.extend(self.to_le_bytes());
            }
        }
    )*};
}

plain!(u32, i32, i64, f16, f32, f64);

impl Plain for bool {
    fn put(&self, to: &mut Vec<u8>) {
        to.push((*self).into());
    }
}

impl<T: Plain, const N: usize> Plain for [T; N] {
    fn put(&self, to: &mut Vec<u8>) {
        self.iter().for_each(|one| one.put(to));
    }
}

/// A number and that many elements.
fn put_all<T: Plain>(items: &[T], to: &mut Vec<u8>) {
    to.reserve(8 + size_of_val(items));
    to.extend((items.len() as u64).to_le_bytes());
    items.iter().for_each(|item| item.put(to));
}

impl Writer {
    /// Writes a value, unless it is there already, and says where it is.
    pub(crate) fn value(&mut self, value: &Value) -> Result<Rep, Error> {
        let kind = value.kind().0;
        Ok(match value {
            Value::Bool(value) => Rep::inline(kind, (*value).into()),
            Value::Int(value) => Rep::inline(kind, *value as u32),
            Value::Half(value) => Rep::inline(kind, value.to_bits().into()),
            Value::Float(value) => Rep::inline(kind, value.to_bits()),
            Value::String(text) => Rep::inline(kind, self.tables.string(text)?),
            Value::Token(text) | Value::Asset(text) => Rep::inline(kind, self.tables.token(text)?),
            Value::Int64(value) => self.plain(kind, value)?,
            Value::Double(value) => self.plain(kind, value)?,
            Value::Float2(value) => self.plain(kind, value)?,
            Value::Float3(value) => self.plain(kind, value)?,
            Value::Double2(value) => self.plain(kind, value)?,
            Value::Double3(value) => self.plain(kind, value)?,
            Value::Half3(value) => self.plain(kind, value)?,
            Value::Quath(value) => self.plain(kind, value)?,
            Value::Quatf(value) => self.plain(kind, value)?,
            Value::Matrix4d(value) => self.plain(kind, value)?,
            Value::Array(array) => self.array(array)?,
            Value::Dictionary(dictionary) => self.dictionary(dictionary)?,
            Value::Tokens(list) => self.list(kind, list, |writer, text, to| {
                writer.tables.token(text)?.put(to);
                Ok(())
            })?,
            Value::Paths(list) => self.list(kind, list, |writer, path, to| {
                writer.tables.path(path)?.put(to);
                Ok(())
            })?,
            Value::References(list) => self.list(kind, list, Writer::reference)?,
        })
    }

    /// Writes an array, unless it is there already.
    pub(crate) fn array(&mut self, array: &Array) -> Result<Rep, Error> {
        let mut out = Vec::new();
        match array {
            Array::Bool(items) => put_all(items, &mut out),
            Array::Int(items) => {
                let wide: Vec<i64> = items.iter().map(|&item| i64::from(item)).collect();
                return self.integers(Kind::Int, &wide, Width::Four, items);
            }
            Array::Int64(items) => return self.integers(Kind::Int64, items, Width::Eight, items),
            Array::Half(items) => put_all(items, &mut out),
            Array::Float(items) => put_all(items, &mut out),
            Array::Double(items) => put_all(items, &mut out),
            // A path of a file is a string in arrays, though a token by itself.
            Array::String(texts) | Array::Asset(texts) => {
                let texts: Result<Vec<u32>, Error> =
                    texts.iter().map(|text| self.tables.string(text)).collect();
                put_all(&texts?, &mut out);
            }
            Array::Token(texts) => {
                let texts: Result<Vec<u32>, Error> =
                    texts.iter().map(|text| self.tables.token(text)).collect();
                put_all(&texts?, &mut out);
            }
            Array::Float2(items) => put_all(items, &mut out),
            Array::Float3(items) => put_all(items, &mut out),
            Array::Double2(items) => put_all(items, &mut out),
            Array::Double3(items) => put_all(items, &mut out),
            Array::Half3(items) => put_all(items, &mut out),
            Array::Quath(items) => put_all(items, &mut out),
            Array::Quatf(items) => put_all(items, &mut out),
            Array::Matrix4d(items) => put_all(items, &mut out),
        }
        self.place_array(array.kind(), &out)
    }

    fn integers<T: Plain>(
        &mut self,
        kind: Kind,
        wide: &[i64],
        width: Width,
        items: &[T],
    ) -> Result<Rep, Error> {
        let mut out = Vec::new();
        if items.len() < PACKED_FROM {
            put_all(items, &mut out);
            return self.place_array(kind, &out);
        }
        out.extend((items.len() as u64).to_le_bytes());
        integers::put(wide, width, &mut out);
        Ok(self.place_array(kind, &out)?.compressed())
    }

    /// Tokens that are no array, as lists of children are.
    pub(crate) fn tokens(&mut self, texts: &[&str]) -> Result<Rep, Error> {
        let numbers: Result<Vec<u32>, Error> = texts.iter().map(|text| self.tables.token(text)).collect();
        let mut out = Vec::new();
        put_all(&numbers?, &mut out);
        self.place(Kind::TokenVector, &out, 1)
    }

    /// The times of samples, and where each value is.
    pub(crate) fn time_samples(&mut self, times: &[f64], reps: &[Rep]) -> Result<Rep, Error> {
        let mut out = Vec::new();
        put_all(times, &mut out);
        let times = self.place(Kind::DoubleVector, &out, 1)?;
        out = [&NEXT[..], &times.to_le_bytes(), &NEXT, &(reps.len() as u64).to_le_bytes()].concat();
        out.extend(reps.iter().flat_map(|rep| rep.to_le_bytes()));
        self.place(Kind::TimeSamples, &out, 1)
    }

    fn plain<T: Plain>(&mut self, kind: Kind, value: &T) -> Result<Rep, Error> {
        let mut out = Vec::new();
        value.put(&mut out);
        self.place(kind, &out, 1)
    }

    fn dictionary(&mut self, dictionary: &Dictionary) -> Result<Rep, Error> {
        let mut out = (dictionary.len() as u64).to_le_bytes().to_vec();
        for (key, value) in dictionary {
            self.tables.string(key)?.put(&mut out);
            out.extend(NEXT);
            out.extend(self.value(value)?.to_le_bytes());
        }
        self.place(Kind::Dictionary, &out, 1)
    }

    fn list<T>(
        &mut self,
        kind: Kind,
        list: &ListOp<T>,
        put: impl Fn(&mut Self, &T, &mut Vec<u8>) -> Result<(), Error>,
    ) -> Result<Rep, Error> {
        let items = list.items();
        let has = |bit: u8| if items.is_empty() { 0 } else { bit };
        let mut out = vec![match list {
            ListOp::Explicit(_) => 1 | has(2),
            ListOp::Prepend(_) => has(32),
        }];
        if !items.is_empty() {
            out.extend((items.len() as u64).to_le_bytes());
        }
        for item in items {
            put(self, item, &mut out)?;
        }
        self.place(kind, &out, 1)
    }

    fn reference(&mut self, reference: &Reference, to: &mut Vec<u8>) -> Result<(), Error> {
        self.tables.string(&reference.asset)?.put(to);
        self.tables.path(&reference.prim)?.put(to);
        // Offset and scale of time; and no data of the user's own.
        [0.0f64, 1.0].put(to);
        to.extend(0u64.to_le_bytes());
        Ok(())
    }

    fn place_array(&mut self, kind: Kind, bytes: &[u8]) -> Result<Rep, Error> {
        match bytes.starts_with(&[0; 8]) {
            true => Ok(Rep::at(kind, 0).array()),
            false => Ok(self.place(kind, bytes, 8)?.array()),
        }
    }
}
