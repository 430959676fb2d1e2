//! One `.vtp` file: names and sizes as XML, then all numbers as they lie in memory.

use crate::Error;
use bytemuck::NoUninit;
use std::borrow::Cow;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Bytes that are handed to the system at once.
const BUFFER: usize = 1 << 20;

/// Writes the values of an array, one after the other.
type Fill<'a> = Box<dyn Fn(&mut dyn Write) -> io::Result<()> + 'a>;

/// A column of numbers.
pub(super) struct Array<'a> {
    name: Cow<'a, str>,
    /// VTK's name of the type.
    kind: &'static str,
    /// Names of the components; none where there is one.
    components: &'static [&'static str],
    bytes: u64,
    fill: Fill<'a>,
}

impl<'a> Array<'a> {
    /// Numbers that are there already.
    pub(super) fn new<T: Number, R: NoUninit>(
        name: impl Into<Cow<'a, str>>,
        components: &'static [&'static str],
        rows: Vec<R>,
    ) -> Self {
        let count = size_of_val(&rows[..]) as u64 / size_of::<T>() as u64;
        Self::streamed::<T>(name, components, count, move |to| to.write_all(bytemuck::cast_slice(&rows)))
    }

    /// `count` numbers of type `T` that `fill` writes.
    pub(super) fn streamed<T: Number>(
        name: impl Into<Cow<'a, str>>,
        components: &'static [&'static str],
        count: u64,
        fill: impl Fn(&mut dyn Write) -> io::Result<()> + 'a,
    ) -> Self {
        Array {
            name: name.into(),
            kind: T::KIND,
            components,
            bytes: count * size_of::<T>() as u64,
            fill: Box::new(fill),
        }
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// The line that announces it.
    fn head(&self, offset: u64) -> String {
        let mut line = format!("<DataArray type=\"{}\" Name=\"{}\"", self.kind, self.name);
        line += &format!(" NumberOfComponents=\"{}\"", self.components.len().max(1));
        for (index, name) in self.components.iter().enumerate() {
            line += &format!(" ComponentName{index}=\"{name}\"");
        }
        line + &format!(" format=\"appended\" offset=\"{offset}\"/>\n")
    }
}

/// A type of number that VTK knows.
pub(super) trait Number: NoUninit {
    /// What VTK calls it.
    const KIND: &'static str;
}

impl Number for f32 {
    const KIND: &'static str = "Float32";
}

impl Number for f64 {
    const KIND: &'static str = "Float64";
}

impl Number for u8 {
    const KIND: &'static str = "UInt8";
}

impl Number for u32 {
    const KIND: &'static str = "UInt32";
}

impl Number for u64 {
    const KIND: &'static str = "UInt64";
}

impl Number for i64 {
    const KIND: &'static str = "Int64";
}

/// Corners of the cells of one kind, one cell after the other, and where each cell ends.
pub(super) struct Cells<'a> {
    pub(super) count: u64,
    pub(super) connectivity: Array<'a>,
    pub(super) offsets: Array<'a>,
}

/// Points, cells and what is said of them.
pub(super) struct PolyData<'a> {
    /// Simulated seconds; NaN where it has no time.
    pub(super) time: f64,
    pub(super) count: u64,
    pub(super) points: Array<'a>,
    pub(super) vertices: Option<Cells<'a>>,
    pub(super) polygons: Option<Cells<'a>>,
    pub(super) of_points: Vec<Array<'a>>,
    pub(super) of_cells: Vec<Array<'a>>,
}

impl PolyData<'_> {
    /// Writes the file at `path`.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub(super) fn write(&self, path: &Path) -> Result<(), Error> {
        let write = || {
            let mut to = BufWriter::with_capacity(BUFFER, File::create_new(path)?);
            self.write_to(&mut to)?;
            to.into_inner().map(drop).map_err(io::IntoInnerError::into_error)
        };
        write().map_err(|error| Error::io("write", path, &error))
    }

    fn write_to(&self, to: &mut dyn Write) -> io::Result<()> {
        let order = if cfg!(target_endian = "little") { "LittleEndian" } else { "BigEndian" };
        let cells = |cells: &Option<Cells<'_>>| cells.as_ref().map_or(0, |cells| cells.count);
        write!(
            to,
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"{order}\" \
             header_type=\"UInt64\">\n<PolyData>\n"
        )?;
        if self.time.is_finite() {
            writeln!(
                to,
                "<FieldData><DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{}\
                 </DataArray></FieldData>",
                self.time
            )?;
        }
        writeln!(
            to,
            "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" \
             NumberOfPolys=\"{}\">",
            self.count,
            cells(&self.vertices),
            cells(&self.polygons)
        )?;
        let mut offset = 0;
        for (section, arrays) in self.sections() {
            let normals = arrays.iter().any(|array| array.name == "Normals");
            let attribute = if normals { " Normals=\"Normals\"" } else { "" };
            writeln!(to, "<{section}{attribute}>")?;
            for array in arrays {
                to.write_all(array.head(offset).as_bytes())?;
                offset += size_of::<u64>() as u64 + array.bytes;
            }
            writeln!(to, "</{section}>")?;
        }
        write!(to, "</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_")?;
        for array in self.sections().into_iter().flat_map(|(_, arrays)| arrays) {
            to.write_all(&array.bytes.to_ne_bytes())?;
            (array.fill)(to)?;
        }
        to.write_all(b"\n</AppendedData>\n</VTKFile>\n")
    }

    /// Everything in the order of the file.
    fn sections(&self) -> Vec<(&'static str, Vec<&Array<'_>>)> {
        let mut sections = vec![
            ("PointData", self.of_points.iter().collect()),
            ("CellData", self.of_cells.iter().collect()),
            ("Points", vec![&self.points]),
        ];
        for (name, cells) in [("Verts", &self.vertices), ("Polys", &self.polygons)] {
            sections.extend(cells.as_ref().map(|cells| (name, vec![&cells.connectivity, &cells.offsets])));
        }
        sections
    }
}
