//! Columns of a program's own: a number for each body at each frame, beside poses.

use crate::frame::rows;
use crate::sheet::NumberType;
use crate::trajectory::MOVING;
use crate::{BodyTable, Error};
use rockfall::BodyId;

/// Names that mean something else in a trajectory.
const TAKEN: [&str; 8] = ["time", "hash", "id", "name", "shape", "scale", "contacts", "events"];

/// A column: an array `frame`, `body` of the trajectory.
///
/// # Examples
/// ```
/// use rockfall_cache::{
///     BodyTable, Column, Contents, FORMAT, Frame, NumberType, RunFolder, RunReader, RunWriter, Summary, VERSION, Values,
/// };
/// # let folder = tempfile::tempdir()?;
/// # let path = folder.path().join("run");
/// # let (names, shapes, scales) = (vec![String::new(); 2], vec![0; 2], vec![1.0; 2]);
/// # let table = BodyTable { ids: vec![1, 2], names, shapes, scales };
/// # let summary = Summary { format: FORMAT.into(), format_version: VERSION, ..Summary::default() };
/// let (name, numbers) = ("heat".to_owned(), NumberType::F32);
/// let heat = Column { name, numbers, units: "K".into(), description: "at the core".into() };
/// let contents = Contents { columns: vec![heat.clone()], ..Contents::default() };
/// let folder = RunFolder::at(&path, false)?;
/// let mut writer = RunWriter::create(&folder, "", &summary, &table, contents)?;
/// writer.push(Frame { columns: vec![Values::F32(vec![293.0, 310.0])], ..Frame::default() })?;
/// writer.finish()?;
///
/// let run = RunReader::open(&path)?;
/// assert_eq!(run.column(&heat)?.at(0)?, Values::F32(vec![293.0, 310.0]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Its name: small letters, digits and `_`, a letter first.
    pub name: String,
    /// Type of its numbers.
    pub numbers: NumberType,
    /// As the CF conventions write them: `m s-1`, `N`, `1`.
    pub units: String,
    /// For people.
    pub description: String,
}

/// The numbers of a column at a frame, one for each body of the table.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Single precision; NaN where absent.
    F32(Vec<f32>),
    /// Double precision; NaN where absent.
    F64(Vec<f64>),
    /// Bytes.
    U8(Vec<u8>),
    /// 32 bits.
    U32(Vec<u32>),
    /// 64 bits.
    U64(Vec<u64>),
}

/// A number that a column can hold.
pub trait Number: Copy {
    /// What bodies have that are not in the world.
    const ABSENT: Self;

    /// Many of them.
    fn values(numbers: Vec<Self>) -> Values;
}

macro_rules! number {
    ($type:ty, $variant:ident, $absent:expr) => {
        impl Number for $type {
            const ABSENT: Self = $absent;

            fn values(numbers: Vec<Self>) -> Values {
                Values::$variant(numbers)
            }
        }
    };
}

number!(f32, F32, f32::NAN);
number!(f64, F64, f64::NAN);
number!(u8, U8, 0);
number!(u32, U32, 0);
number!(u64, U64, 0);

impl Values {
    /// Takes a number of each body of a world, `ids` ascending as [`rockfall::World::ids`] gives them, into the rows of a table.
    ///
    /// # Errors
    /// [`Error::UnknownBody`] where the table lacks one of the ids.
    pub fn gather<T: Number>(table: &BodyTable, ids: &[BodyId], numbers: &[T]) -> Result<Self, Error> {
        let mut all = vec![T::ABSENT; table.len()];
        for (row, &number) in rows(table, ids).zip(numbers) {
            all[row?] = number;
        }
        Ok(T::values(all))
    }

    /// Those of some rows.
    pub fn of_rows(&self, rows: &[u32]) -> Self {
        fn pick<T: Number>(numbers: &[T], rows: &[u32]) -> Values {
            T::values(
                rows.iter().map(|&row| numbers.get(row as usize).copied().unwrap_or(T::ABSENT)).collect(),
            )
        }
        match self {
            Values::F32(numbers) => pick(numbers, rows),
            Values::F64(numbers) => pick(numbers, rows),
            Values::U8(numbers) => pick(numbers, rows),
            Values::U32(numbers) => pick(numbers, rows),
            Values::U64(numbers) => pick(numbers, rows),
        }
    }

    /// Type of the numbers.
    pub fn numbers(&self) -> NumberType {
        match self {
            Values::F32(_) => NumberType::F32,
            Values::F64(_) => NumberType::F64,
            Values::U8(_) => NumberType::U8,
            Values::U32(_) => NumberType::U32,
            Values::U64(_) => NumberType::U64,
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Values::F32(numbers) => numbers.len(),
            Values::F64(numbers) => numbers.len(),
            Values::U8(numbers) => numbers.len(),
            Values::U32(numbers) => numbers.len(),
            Values::U64(numbers) => numbers.len(),
        }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(crate) fn to_bytes(&self) -> Vec<u8> {
        match self {
            Values::F32(numbers) => numbers.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Values::F64(numbers) => numbers.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Values::U8(numbers) => numbers.clone(),
            Values::U32(numbers) => numbers.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Values::U64(numbers) => numbers.iter().flat_map(|x| x.to_le_bytes()).collect(),
        }
    }

    pub(crate) fn of_bytes(numbers: NumberType, bytes: &[u8]) -> Self {
        match numbers {
            NumberType::F32 => {
                Values::F32(bytes.as_chunks().0.iter().map(|&x| f32::from_le_bytes(x)).collect())
            }
            NumberType::F64 => {
                Values::F64(bytes.as_chunks().0.iter().map(|&x| f64::from_le_bytes(x)).collect())
            }
            NumberType::U8 => Values::U8(bytes.to_vec()),
            NumberType::U32 => {
                Values::U32(bytes.as_chunks().0.iter().map(|&x| u32::from_le_bytes(x)).collect())
            }
            NumberType::U64 => {
                Values::U64(bytes.as_chunks().0.iter().map(|&x| u64::from_le_bytes(x)).collect())
            }
        }
    }
}

/// Whether columns can stand side by side in a trajectory.
pub(crate) fn check(columns: &[Column]) -> Result<(), Error> {
    for (k, Column { name, .. }) in columns.iter().enumerate() {
        let failed = |reason: &str| Err(Error::Column { name: name.clone(), reason: reason.to_owned() });
        let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        if !name.starts_with(|c: char| c.is_ascii_lowercase()) || !name.chars().all(plain) {
            return failed("its name has to be of small letters, digits and `_`, a letter first");
        }
        if TAKEN.contains(&name.as_str()) || MOVING.iter().any(|(taken, _)| taken == name) {
            return failed("a trajectory has something else under this name");
        }
        if columns[..k].iter().any(|other| other.name == *name) {
            return failed("there are two of this name");
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_cannot_be_are_refused() {
        let column = |name: &str| Column {
            name: name.into(),
            numbers: NumberType::F32,
            units: "1".into(),
            description: String::new(),
        };
        assert!(check(&[column("heat"), column("heat_2")]).is_ok());
        for names in [&["heat", "heat"][..], &["Heat"], &["2nd"], &[""], &["a/b"], &["position"], &["events"]]
        {
            let columns: Vec<Column> = names.iter().map(|name| column(name)).collect();
            assert!(matches!(check(&columns), Err(Error::Column { .. })), "{names:?}");
        }
    }
}
