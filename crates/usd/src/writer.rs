//! Writing a file: values as they come, then what points at them.

use crate::layer::{Attribute, Layer, Metadata, Prim, Property, Relationship};
use crate::tables::{Rep, Tables};
use crate::value::{Kind, kind_of_type};
use crate::{Array, Error, ListOp, Value, path};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs::{self, File};
use std::io::{BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use xxhash_rust::xxh3::Xxh3;

/// The version of the format, which all readers since 2019 know.
const VERSION: [u8; 3] = [0, 8, 0];

/// Bytes before the first value: magic, version, place of the table of contents, and room.
const HEAD: usize = 88;

/// Kinds of things that have fields.
const ATTRIBUTE: u32 = 1;
const PRIM: u32 = 6;
const LAYER: u32 = 7;
const RELATIONSHIP: u32 = 8;

/// Writes a file.
///
/// It grows under a hidden name and moves into place when it is finished; one that is not finished is removed.
#[derive(Debug)]
pub struct Writer {
    path: PathBuf,
    part: PathBuf,
    /// `None` once the file is in place.
    file: Option<BufWriter<File>>,
    /// Bytes so far.
    at: u64,
    pub(crate) tables: Tables,
    /// Values that are in the file, by their kind and a hash of their bytes. 128 bits: no two values share one.
    known: HashMap<(Kind, u128), Rep>,
    samples: BTreeMap<String, Samples>,
}

/// The values of an attribute in time.
#[derive(Debug)]
struct Samples {
    kind: Kind,
    times: Vec<f64>,
    reps: Vec<Rep>,
}

impl Writer {
    /// Starts the file `path`, usually `….usdc` or `….usd`.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn create(path: &Path) -> Result<Self, Error> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let part = path.with_file_name(format!(".{name}.part"));
        let file = File::create(&part).map_err(|error| Error::io(path, &error))?;
        let mut writer = Writer {
            path: path.to_owned(),
            part,
            file: Some(BufWriter::with_capacity(1 << 20, file)),
            at: 0,
            tables: Tables::new(),
            known: HashMap::new(),
            samples: BTreeMap::new(),
        };
        writer.put(&[0; HEAD])?;
        Ok(writer)
    }

    /// Adds a sample of the attribute at `path`, as in `/World/Rocks.positions`, at a time code. The values go to the file at once, unless
    /// equal ones are there already. Times ascend for each attribute.
    ///
    /// # Errors
    /// [`Error::Time`], [`Error::Type`] where an earlier sample was of another type, [`Error::Io`].
    pub fn sample(&mut self, path: &str, time: f64, array: &Array) -> Result<(), Error> {
        let rep = self.array(array)?;
        let kind = array.kind();
        let new = || Samples { kind, times: Vec::new(), reps: Vec::new() };
        let samples = self.samples.entry(path.to_owned()).or_insert_with(new);
        if samples.kind != kind {
            let type_name = format!("{:?}[]", samples.kind);
            return Err(Error::Type { path: path.to_owned(), type_name });
        }
        if !time.is_finite() || samples.times.last().is_some_and(|&last| last >= time) {
            return Err(Error::Time { path: path.to_owned(), time });
        }
        samples.times.push(time);
        samples.reps.push(rep);
        Ok(())
    }

    /// Bytes that the file has so far.
    pub fn bytes(&self) -> u64 {
        self.at
    }

    /// Writes what the layer says, and puts the file into its place. Returns its bytes.
    ///
    /// # Errors
    /// [`Error::Name`], [`Error::Path`], [`Error::Twice`], [`Error::Type`], [`Error::UnknownType`], [`Error::NoAttribute`] and others where the
    /// layer is wrong; [`Error::Io`].
    pub fn finish(mut self, layer: &Layer) -> Result<u64, Error> {
        self.layer(layer)?;
        if let Some((path, _)) = self.samples.pop_first() {
            return Err(Error::NoAttribute(path));
        }
        let mut contents = Vec::new();
        let sections = self.tables.sections()?;
        contents.extend((sections.len() as u64).to_le_bytes());
        for (name, bytes) in sections {
            let mut label = [0; 16];
            label[..name.len()].copy_from_slice(name.as_bytes());
            contents.extend(label);
            contents.extend(self.at.to_le_bytes());
            contents.extend((bytes.len() as u64).to_le_bytes());
            self.put(&bytes)?;
        }
        let place = self.at;
        self.put(&contents)?;

        let [major, minor, patch] = VERSION;
        let mut head = b"PXR-USDC".to_vec();
        head.extend([major, minor, patch, 0, 0, 0, 0, 0]);
        head.extend(place.to_le_bytes());
        let Some(mut file) = self.file.take() else { return Ok(self.at) };
        let done = file
            .seek(SeekFrom::Start(0))
            .and_then(|_| file.write_all(&head))
            .and_then(|()| file.flush())
            .and_then(|()| fs::rename(&self.part, &self.path));
        if let Err(error) = done {
            self.file = Some(file);
            return Err(Error::io(&self.path, &error));
        }
        Ok(self.at)
    }

    fn layer(&mut self, layer: &Layer) -> Result<(), Error> {
        let mut fields = self.metadata(&layer.metadata)?;
        fields.extend(self.children("primChildren", path::ROOT, &names(&layer.prims))?);
        self.tables.spec(path::ROOT, LAYER, &fields)?;
        layer.prims.iter().try_for_each(|prim| self.prim(path::ROOT, prim))
    }

    fn prim(&mut self, parent: &str, prim: &Prim) -> Result<(), Error> {
        let path = path::below(parent, &prim.name)?;
        let mut fields = vec![("specifier", Rep::inline(Kind::Specifier, prim.specifier as u32))];
        if !prim.type_name.is_empty() {
            fields.push(("typeName", self.value(&Value::Token(prim.type_name.to_owned()))?));
        }
        fields.extend(self.metadata(&prim.metadata)?);
        fields.extend(self.children("primChildren", &path, &names(&prim.children))?);
        let properties: Vec<&str> = prim.properties.iter().map(Property::name).collect();
        fields.extend(self.children("properties", &path, &properties)?);
        self.tables.spec(&path, PRIM, &fields)?;
        for property in &prim.properties {
            match property {
                Property::Attribute(attribute) => self.attribute(&path, attribute)?,
                Property::Relationship(relationship) => self.relationship(&path, relationship)?,
            }
        }
        prim.children.iter().try_for_each(|child| self.prim(&path, child))
    }

    fn attribute(&mut self, prim: &str, attribute: &Attribute) -> Result<(), Error> {
        let path = path::property(prim, &attribute.name)?;
        let type_name = attribute.type_name.to_owned();
        let Some(stored) = kind_of_type(&type_name) else {
            return Err(Error::UnknownType { path, type_name });
        };
        let samples = self.samples.remove(&path);
        let default = attribute.default.as_ref();
        let fits = default.is_none_or(|value| value.kind() == stored)
            && samples.as_ref().is_none_or(|samples| (samples.kind, true) == stored);
        if !fits {
            return Err(Error::Type { path, type_name });
        }
        let mut fields =
            vec![("typeName", self.value(&Value::Token(type_name))?), variability(attribute.uniform)];
        if let Some(value) = default {
            fields.push(("default", self.value(value)?));
        }
        if let Some(samples) = samples {
            fields.push(("timeSamples", self.time_samples(&samples.times, &samples.reps)?));
        }
        if !attribute.connections.is_empty() {
            let paths = Value::Paths(ListOp::Explicit(attribute.connections.clone()));
            fields.push(("connectionPaths", self.value(&paths)?));
        }
        fields.extend(self.metadata(&attribute.metadata)?);
        self.tables.spec(&path, ATTRIBUTE, &fields)
    }

    fn relationship(&mut self, prim: &str, relationship: &Relationship) -> Result<(), Error> {
        let path = path::property(prim, &relationship.name)?;
        let targets = Value::Paths(ListOp::Explicit(relationship.targets.clone()));
        let fields = [variability(true), ("targetPaths", self.value(&targets)?)];
        self.tables.spec(&path, RELATIONSHIP, &fields)
    }

    fn metadata<'a>(&mut self, metadata: &'a Metadata) -> Result<Vec<(&'a str, Rep)>, Error> {
        metadata.iter().map(|(key, value)| Ok((*key, self.value(value)?))).collect()
    }

    /// The field that lists what is below a path; none where nothing is.
    fn children(
        &mut self,
        field: &'static str,
        path: &str,
        names: &[&str],
    ) -> Result<Option<(&'static str, Rep)>, Error> {
        let mut seen = BTreeSet::new();
        if let Some(twice) = names.iter().find(|&name| !seen.insert(name)) {
            let between = if field == "properties" { "." } else { "/" };
            return Err(Error::Twice(format!("{}{between}{twice}", path.trim_end_matches('/'))));
        }
        match names.is_empty() {
            true => Ok(None),
            false => Ok(Some((field, self.tokens(names)?))),
        }
    }

    /// Writes a value at a multiple of `align` bytes, unless it is there already.
    pub(crate) fn place(&mut self, kind: Kind, bytes: &[u8], align: u64) -> Result<Rep, Error> {
        let mut hash = Xxh3::new();
        hash.update(&[align as u8]);
        hash.update(bytes);
        let key = (kind, hash.digest128());
        if let Some(&rep) = self.known.get(&key) {
            return Ok(rep);
        }
        let gap = self.at.next_multiple_of(align) - self.at;
        self.put(&[0; 8][..gap as usize])?;
        let rep = Rep::at(kind, self.at);
        self.put(bytes)?;
        self.known.insert(key, rep);
        Ok(rep)
    }

    fn put(&mut self, bytes: &[u8]) -> Result<(), Error> {
        if let Some(file) = &mut self.file {
            file.write_all(bytes).map_err(|error| Error::io(&self.path, &error))?;
            self.at += bytes.len() as u64;
        }
        Ok(())
    }
}

impl Drop for Writer {
    fn drop(&mut self) {
        if let Some(file) = self.file.take() {
            // What the buffer holds is of no use any more.
            drop(file.into_parts());
            let _ = fs::remove_file(&self.part);
        }
    }
}

impl Property {
    fn name(&self) -> &str {
        match self {
            Property::Attribute(attribute) => &attribute.name,
            Property::Relationship(relationship) => &relationship.name,
        }
    }
}

fn names(prims: &[Prim]) -> Vec<&str> {
    prims.iter().map(|prim| prim.name.as_str()).collect()
}

fn variability(uniform: bool) -> (&'static str, Rep) {
    ("variability", Rep::inline(Kind::Variability, uniform.into()))
}
