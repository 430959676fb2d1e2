//! Parquet: one row per body and frame, column by column, for pandas, Polars, DuckDB and Spark.
//!
//! A row group is a frame, or as many whole frames as it takes to have [`GROUP`] rows: a group of few rows would be more footer than data. Columns of a group
//! are encoded beside each other. The library's interface to single columns serves without its Arrow arrays, which are most of what it depends on.

use crate::columns::{COLUMNS, Column};
use crate::{Detail, Error, Format, Ids, Job, Makes, Moment, Run};
use parquet::basic::{Compression, Encoding, LogicalType, Repetition, Type as Physical, ZstdLevel};
use parquet::column::writer::{ColumnCloseResult, ColumnWriter, get_column_writer};
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::properties::{WriterProperties, WriterPropertiesPtr};
use parquet::file::writer::{SerializedFileWriter, SerializedPageWriter, TrackedWrite};
use parquet::schema::types::{ColumnDescPtr, ColumnPath, Type};
use rayon::prelude::*;
use rockfall_math::DVec3;
use std::fs::File;
use std::io;
use std::path::Path;
use std::sync::Arc;

/// Rows of a group, at least.
const GROUP: usize = 1 << 17;

/// A table, of all frames or of each.
#[derive(Clone, Debug, Default)]
pub struct Parquet {
    /// Which bodies; all where `None`.
    pub bodies: Option<Ids>,
    /// A folder with a file for each frame instead of one file.
    pub per_frame: bool,
}

impl Format for Parquet {
    fn name(&self) -> &'static str {
        "parquet"
    }

    fn makes(&self) -> Makes {
        if self.per_frame {
            Makes::Folder { extensions: &["parquet"] }
        } else {
            Makes::File { extension: "parquet" }
        }
    }

    fn write(&self, job: &Job<'_>, to: &Path) -> Result<(), Error> {
        let rows = job.rows(self.bodies.as_ref())?;
        if self.per_frame {
            let one = |moment: Moment| {
                let path = to.join(format!("frame-{:06}.parquet", moment.frame));
                let mut file = Table::create(job.run(), &path)?;
                file.add(moment)?;
                file.finish()
            };
            return job.stream(&rows, Detail::Motion, one, Ok);
        }
        let mut file = Table::create(job.run(), to)?;
        job.stream(&rows, Detail::Motion, Ok, |moment| file.add(moment))?;
        file.finish()
    }
}

/// A file that is being written.
struct Table<'a> {
    run: &'a Run,
    path: &'a Path,
    properties: WriterPropertiesPtr,
    writer: SerializedFileWriter<File>,
    /// Moments that wait for others to fill a group.
    waiting: Vec<Moment>,
}

impl<'a> Table<'a> {
    fn create(run: &'a Run, path: &'a Path) -> Result<Self, Error> {
        let file = File::create_new(path).map_err(|error| Error::io("write", path, &error))?;
        let properties = Arc::new(properties());
        let writer = SerializedFileWriter::new(file, schema(run.origin())?, properties.clone());
        let writer = writer.map_err(|error| failed(path, error))?;
        Ok(Table { run, path, properties, writer, waiting: Vec::new() })
    }

    fn add(&mut self, moment: Moment) -> Result<(), Error> {
        self.waiting.push(moment);
        let rows: usize = self.waiting.iter().map(|moment| moment.rows.len()).sum();
        if rows >= GROUP { self.flush() } else { Ok(()) }
    }

    /// Writes what waits as a group.
    fn flush(&mut self) -> Result<(), Error> {
        let failed = |error| failed(self.path, error);
        let columns = self.writer.schema_descr().columns().to_vec();
        let encoded: Vec<_> = columns
            .into_par_iter()
            .zip(COLUMNS)
            .map(|(descriptor, (_, column))| {
                let values = values(self.run, &self.waiting, column);
                encode(descriptor, &self.properties, values)
            })
            .collect();
        let mut group = self.writer.next_row_group().map_err(failed)?;
        for column in encoded {
            let (bytes, closed) = column.map_err(failed)?;
            group.append_column(&bytes::Bytes::from(bytes), closed).map_err(failed)?;
        }
        group.close().map_err(failed)?;
        self.waiting.clear();
        Ok(())
    }

    fn finish(mut self) -> Result<(), Error> {
        // Where there is no body there is no group either.
        if self.waiting.iter().any(|moment| !moment.rows.is_empty()) {
            self.flush()?;
        }
        self.writer.close().map(drop).map_err(|error| failed(self.path, error))
    }
}

/// The values of a column in a group.
enum Values {
    Int32(Vec<i32>),
    Int64(Vec<i64>),
    Float(Vec<f32>),
    Double(Vec<f64>),
    Text(Vec<ByteArray>),
}

/// Takes the values of a column together.
fn values(run: &Run, moments: &[Moment], column: Column) -> Values {
    let (table, origin) = (run.bodies(), run.origin());
    let rows = || moments.iter().flat_map(|moment| &moment.rows).map(|&row| row as usize);
    let each = |of: fn(&Moment) -> f64| {
        moments.iter().flat_map(move |moment| std::iter::repeat_n(of(moment), moment.rows.len()))
    };
    let vectors = |of: fn(&Moment) -> &[[f32; 3]], axis: usize| {
        moments.iter().flat_map(of).map(|v| v[axis]).collect::<Vec<f32>>()
    };
    match column {
        // A run has at most a thousand million frames.
        Column::Frame => {
            Values::Int32(each(|moment| moment.frame as f64).map(|frame| frame as i32).collect())
        }
        Column::Time => Values::Double(each(|moment| moment.time).collect()),
        // Unsigned numbers lie in signed ones, bit by bit; the schema says what they are.
        Column::Id => Values::Int64(rows().map(|row| table.ids[row] as i64).collect()),
        Column::Shape => Values::Int32(rows().map(|row| table.shapes[row] as i32).collect()),
        Column::Name => Values::Text(rows().map(|row| table.names[row].as_str().into()).collect()),
        Column::Scale => Values::Float(rows().map(|row| table.scales[row]).collect()),
        Column::Position(axis) => {
            let positions = vectors(|moment| &moment.positions, axis);
            if is_single(origin) {
                Values::Float(positions)
            } else {
                Values::Double(positions.into_iter().map(|x| origin[axis] + f64::from(x)).collect())
            }
        }
        Column::Rotation(axis) => {
            Values::Float(moments.iter().flat_map(|moment| &moment.rotations).map(|q| q[axis]).collect())
        }
        Column::Velocity(axis) => Values::Float(vectors(|moment| &moment.velocities, axis)),
        Column::Spin(axis) => Values::Float(vectors(|moment| &moment.spins, axis)),
    }
}

/// Whether positions in the world are in single precision: where there is nothing to add to those of the run.
fn is_single(origin: DVec3) -> bool {
    origin == DVec3::ZERO
}

/// The bytes of a column in a group.
fn encode(
    descriptor: ColumnDescPtr,
    properties: &WriterPropertiesPtr,
    values: Values,
) -> Result<(Vec<u8>, ColumnCloseResult), ParquetError> {
    let mut bytes = TrackedWrite::new(Vec::new());
    let pages = Box::new(SerializedPageWriter::new(&mut bytes));
    let mut writer = get_column_writer(descriptor, properties.clone(), pages);
    match (&mut writer, &values) {
        (ColumnWriter::Int32ColumnWriter(to), Values::Int32(values)) => to.write_batch(values, None, None)?,
        (ColumnWriter::Int64ColumnWriter(to), Values::Int64(values)) => to.write_batch(values, None, None)?,
        (ColumnWriter::FloatColumnWriter(to), Values::Float(values)) => to.write_batch(values, None, None)?,
        (ColumnWriter::DoubleColumnWriter(to), Values::Double(values)) => {
            to.write_batch(values, None, None)?
        }
        (ColumnWriter::ByteArrayColumnWriter(to), Values::Text(values)) => {
            to.write_batch(values, None, None)?
        }
        _ => return Err(ParquetError::General("a column has values of another type".into())),
    };
    let closed = writer.close()?;
    Ok((bytes.into_inner()?, closed))
}

/// What the columns are.
fn schema(origin: DVec3) -> Result<Arc<Type>, Error> {
    let unsigned = |bits| Some(LogicalType::integer(bits, false));
    let field = |(name, column): (&str, Column)| {
        let (physical, logical) = match column {
            Column::Frame => (Physical::INT32, None),
            Column::Shape => (Physical::INT32, unsigned(32)),
            Column::Id => (Physical::INT64, unsigned(64)),
            Column::Name => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
            Column::Time => (Physical::DOUBLE, None),
            Column::Position(_) if !is_single(origin) => (Physical::DOUBLE, None),
            _ => (Physical::FLOAT, None),
        };
        let field = Type::primitive_type_builder(name, physical).with_logical_type(logical);
        Ok(Arc::new(field.with_repetition(Repetition::REQUIRED).build()?))
    };
    let fields: Result<Vec<_>, ParquetError> = COLUMNS.into_iter().map(field).collect();
    let schema = fields.and_then(|fields| Type::group_type_builder("bodies").with_fields(fields).build());
    schema.map(Arc::new).map_err(|error| Error::Limit(error.to_string()))
}

/// How the columns are encoded: what repeats by a dictionary, ids by their differences, and of other numbers all first bytes, then all second bytes and so
/// on, so that signs and exponents, which hardly differ, lie together.
fn properties() -> WriterProperties {
    let mut properties = WriterProperties::builder()
        .set_created_by(concat!("rockfall ", env!("CARGO_PKG_VERSION")).into())
        .set_compression(Compression::ZSTD(ZstdLevel::default()));
    for (name, column) in COLUMNS {
        let encoding = match column {
            Column::Frame | Column::Time | Column::Name | Column::Shape | Column::Scale => continue,
            Column::Id => Encoding::DELTA_BINARY_PACKED,
            _ => Encoding::BYTE_STREAM_SPLIT,
        };
        properties = properties
            .set_column_dictionary_enabled(ColumnPath::from(name), false)
            .set_column_encoding(ColumnPath::from(name), encoding);
    }
    properties.build()
}

/// What the library says, as one of our errors: the system's own where it was the system.
fn failed(path: &Path, error: ParquetError) -> Error {
    let error = match error {
        ParquetError::External(inner) => match inner.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(other) => io::Error::other(other.to_string()),
        },
        other => io::Error::other(other.to_string()),
    };
    Error::io("write", path, &error)
}
