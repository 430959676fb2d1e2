//! What can be in a column.

use super::Error;
use crate::lanes::Row;
use crate::{Aabb, DVec3, Quat, Vec3};
use bytemuck::Pod;

/// Takes bytes to where they are written.
pub type Put<'a> = &'a mut dyn FnMut(&[u8]) -> Result<(), Error>;

/// Fills bytes from where they are read.
pub type Get<'a> = &'a mut dyn FnMut(&mut [u8]) -> Result<(), Error>;

/// Values that pass at a time where they don't lie in memory as they are stored, or where there may be fewer than was said.
const PIECE: usize = 4096;

/// A type that can be in a column.
pub trait Stored: Sized {
    /// Its name in the file: another one is refused.
    const TYPE: &'static str;

    /// Bytes of a value in the file.
    const SIZE: usize = size_of::<Self>();

    /// Writes values.
    ///
    /// # Errors
    /// Those of `put`.
    fn put(column: &[Self], put: Put<'_>) -> Result<(), Error>;

    /// Reads `count` values; nothing where one of them is none of the type.
    ///
    /// # Errors
    /// Those of `get`.
    fn get(count: u64, get: Get<'_>) -> Result<Option<Vec<Self>>, Error>;
}

/// Writes plain numbers as they lie in memory.
///
/// # Errors
/// Those of `put`.
pub fn put_plain<T: Pod>(column: &[T], put: Put<'_>) -> Result<(), Error> {
    put(bytemuck::cast_slice(column))
}

/// Reads plain numbers.
///
/// # Errors
/// Those of `get`.
pub fn get_plain<T: Pod>(count: u64, get: Get<'_>) -> Result<Option<Vec<T>>, Error> {
    let mut column: Vec<T> = Vec::new();
    loop {
        let from = column.len();
        // As many as have come already, so that no more is allocated than twice what is there.
        let more = (count - from as u64).min(from.max(PIECE) as u64) as usize;
        if more == 0 {
            return Ok(Some(column));
        }
        column.reserve_exact(more);
        column.resize(from + more, T::zeroed());
        get(bytemuck::cast_slice_mut(&mut column[from..]))?;
    }
}

/// Writes values one by one: `write` appends the bytes of each.
///
/// # Errors
/// Those of `put`.
pub fn put_each<T>(column: &[T], put: Put<'_>, mut write: impl FnMut(&T, &mut Vec<u8>)) -> Result<(), Error> {
    let mut bytes = Vec::new();
    for piece in column.chunks(PIECE) {
        bytes.clear();
        piece.iter().for_each(|value| write(value, &mut bytes));
        put(&bytes)?;
    }
    Ok(())
}

/// Reads values of `size` bytes each, one by one.
///
/// # Errors
/// Those of `get`.
pub fn get_each<T>(
    count: u64,
    size: usize,
    get: Get<'_>,
    mut read: impl FnMut(&[u8]) -> Option<T>,
) -> Result<Option<Vec<T>>, Error> {
    let (mut column, mut good, mut left) = (Vec::new(), true, count);
    while left > 0 {
        let more = left.min(PIECE as u64) as usize;
        let mut bytes = vec![0; more * size];
        get(&mut bytes)?;
        for value in bytes.chunks_exact(size).map(&mut read) {
            good &= value.is_some();
            column.extend(value);
        }
        left -= more as u64;
    }
    column.shrink_to_fit();
    Ok(good.then_some(column))
}

/// Stores types of plain numbers, under the names that follow.
#[macro_export]
macro_rules! stored_plain {
    ($($type:ty: $name:literal),* $(,)?) => {
        $(impl $crate::snapshot::Stored for $type {
            const TYPE: &'static str = $name;

            fn put(column: &[Self], put: $crate::snapshot::Put<'_>) -> Result<(), $crate::snapshot::Error> {
                $crate::snapshot::put_plain(column, put)
            }

            fn get(
                count: u64,
                get: $crate::snapshot::Get<'_>,
            ) -> Result<Option<Vec<Self>>, $crate::snapshot::Error> {
                $crate::snapshot::get_plain(count, get)
            }
        })*
    };
}

/// Stores a type of a few values as a byte each.
#[macro_export]
macro_rules! stored_byte {
    ($type:ty: $name:literal, $($value:path = $byte:literal),* $(,)?) => {
        impl $crate::snapshot::Stored for $type {
            const TYPE: &'static str = $name;
            const SIZE: usize = 1;

            fn put(column: &[Self], put: $crate::snapshot::Put<'_>) -> Result<(), $crate::snapshot::Error> {
                $crate::snapshot::put_each(column, put, |value, bytes| {
                    bytes.push(match value { $($value => $byte,)* });
                })
            }

            fn get(
                count: u64,
                get: $crate::snapshot::Get<'_>,
            ) -> Result<Option<Vec<Self>>, $crate::snapshot::Error> {
                $crate::snapshot::get_each(count, 1, get, |bytes| match bytes {
                    $([$byte] => Some($value),)*
                    _ => None,
                })
            }
        }
    };
}

stored_plain! {
    u8: "u8",
    u16: "u16",
    u32: "u32",
    u64: "u64",
    f32: "f32",
    f64: "f64",
    [f32; 2]: "f32x2",
    [u32; 2]: "u32x2",
    Row: "f32x8",
    Vec3: "f32x3",
    Quat: "f32x4",
    DVec3: "f64x3",
    Aabb: "box",
}

impl Stored for bool {
    const TYPE: &'static str = "bool";

    fn put(column: &[Self], put: Put<'_>) -> Result<(), Error> {
        put_each(column, put, |&value, bytes| bytes.push(u8::from(value)))
    }

    fn get(count: u64, get: Get<'_>) -> Result<Option<Vec<Self>>, Error> {
        get_each(count, 1, get, |bytes| match bytes {
            [0] => Some(false),
            [1] => Some(true),
            _ => None,
        })
    }
}
