//! Fields on disk, so that each is sampled once.
//!
//! A file is named by a hash of all that the field follows from: the mesh, the settings, and the version of the way in which it is made. It is a snapshot, column by column with checksums (`math::snapshot`);
//! one that is torn or does not belong is made anew. It comes into being under another name and is renamed when it is whole, so that nobody reads half of it.

use super::octree::{LEAF, Octree};
use super::samples::{Sample, Samples};
use super::{Features, Field, FieldError, FieldSettings, check};
use crate::Mesh;
use rockfall_math::Vec3;
use rockfall_math::snapshot::{Error, Reader, Writer};
use std::fs::File;
use std::io::{BufReader, BufWriter};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use xxhash_rust::xxh3::Xxh3;

/// Has to change whenever the same mesh and settings give other bits.
const VERSION: u32 = 2;

/// Where [`Field::cached`] had a field from.
#[derive(Debug)]
pub enum CacheUse {
    /// Read from this file.
    Read(PathBuf),
    /// Made, and written to this file.
    Written(PathBuf),
    /// Made; it could not be written for this reason.
    Kept(std::io::Error),
}

impl Field {
    /// [`Field::new`], or the same field from a file that was written by an earlier call with the same mesh and settings. Folders that are missing are made; a file
    /// that is torn or wrong is replaced.
    ///
    /// # Errors
    /// As [`Field::new`]. A folder that can't be written is no error.
    pub fn cached(
        mesh: Arc<Mesh>,
        settings: FieldSettings,
        folder: &Path,
    ) -> Result<(Field, CacheUse), FieldError> {
        check(&mesh, settings)?;
        let path = folder.join(format!("{:032x}.field", key(&mesh, settings)));
        if let Ok(field) = read(&path, &mesh, settings) {
            return Ok((field, CacheUse::Read(path)));
        }
        let field = Field::new(mesh, settings)?;
        let how = match write(&path, &field) {
            Ok(()) => CacheUse::Written(path),
            Err(error) => CacheUse::Kept(error),
        };
        Ok((field, how))
    }
}

/// Hash of all that a field follows from.
pub(super) fn key(mesh: &Mesh, settings: FieldSettings) -> u128 {
    let mut hash = Xxh3::new();
    hash.update(&VERSION.to_le_bytes());
    let FieldSettings { error, spacing } = settings;
    [error, spacing].iter().for_each(|x| hash.update(&x.to_le_bytes()));
    hash.update(&(mesh.vertices.len() as u64).to_le_bytes());
    mesh.vertices.iter().flat_map(|v| v.to_array()).for_each(|x| hash.update(&x.to_le_bytes()));
    mesh.triangles.as_flattened().iter().for_each(|c| hash.update(&c.to_le_bytes()));
    hash.digest128()
}

fn write(path: &Path, field: &Field) -> std::io::Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder)?;
    let mut file = tempfile::NamedTempFile::new_in(folder)?;
    let mut to = BufWriter::new(file.as_file_mut());
    put(field, &mut to).map_err(std::io::Error::other)?;
    drop(to);
    file.as_file().sync_all()?;
    file.persist(path)?;
    Ok(())
}

fn put(field: &Field, to: &mut BufWriter<&mut File>) -> Result<(), Error> {
    let Field { mesh: _, settings: _, octree, samples, features: _, inner, contact_scale: _, key } = field;
    let Octree { origin, cell, size, roots, nodes, leaves } = octree;
    let mut writer = Writer::new(to)?;
    writer.text("key", &format!("{key:032x}"))?;
    writer.one("origin", *origin)?;
    writer.one("cell", *cell)?;
    writer.column("size", size)?;
    writer.column("roots", roots)?;
    writer.column("nodes", nodes.as_flattened())?;
    writer.column("leaves", leaves.as_flattened())?;
    let column = |of: fn(&Sample) -> Vec3| samples.points().iter().map(of).collect::<Vec<Vec3>>();
    writer.column("points", &column(|sample| sample.position))?;
    writer.column("normals", &column(|sample| sample.normal))?;
    writer.column("cones", &samples.points().iter().map(|sample| sample.cone).collect::<Vec<f32>>())?;
    writer.one("middle", inner.0)?;
    writer.one("radius", inner.1)?;
    writer.finish()?;
    Ok(())
}

fn read(path: &Path, mesh: &Arc<Mesh>, settings: FieldSettings) -> Result<Field, Error> {
    let mut from = BufReader::new(File::open(path)?);
    let mut reader = Reader::new(&mut from)?;
    let key = key(mesh, settings);
    if reader.text("key")? != format!("{key:032x}") {
        return Err(Error::invalid("key", "that of another field"));
    }
    let (origin, cell) = (reader.one("origin")?, reader.one("cell")?);
    let size = reader.column_of("size", 3)?;
    let octree = Octree {
        origin,
        cell,
        size: [size[0], size[1], size[2]],
        roots: reader.column("roots")?,
        nodes: eights("nodes", &reader.column("nodes")?)?,
        leaves: eights("leaves", &reader.column("leaves")?)?,
    };
    let positions: Vec<Vec3> = reader.column("points")?;
    let normals: Vec<Vec3> = reader.column_of("normals", positions.len())?;
    let cones: Vec<f32> = reader.column_of("cones", positions.len())?;
    let inner: (Vec3, f32) = (reader.one("middle")?, reader.one("radius")?);
    reader.finish()?;
    // Checksums tell what was torn; what somebody wrote by hand must do no harm either.
    let finite = positions.iter().chain(&normals).all(|v| v.is_finite()) && inner.0.is_finite();
    if !finite || !is_sound(&octree) {
        return Err(Error::invalid("nodes", "an octree that does not fit together"));
    }
    let points = positions.into_iter().zip(normals).zip(cones);
    let samples = points.map(|((position, normal), cone)| Sample { position, normal, cone }).collect();
    let samples = Samples::in_order(samples);
    let features = Features::of(mesh, &samples, settings.spacing);
    let contact_scale = super::contact_scale(mesh, inner.1);
    Ok(Field { mesh: mesh.clone(), settings, octree, samples, features, inner, contact_scale, key })
}

fn eights<T: Copy + Default>(name: &str, column: &[T]) -> Result<Vec<[T; 8]>, Error> {
    match column.as_chunks() {
        (eights, []) => Ok(eights.to_vec()),
        _ => Err(Error::invalid(name, "no multiple of eight")),
    }
}

/// Whether every way down the octree ends in a leaf.
pub(super) fn is_sound(octree: &Octree) -> bool {
    let Octree { origin, cell, size, roots, nodes, leaves } = octree;
    let count = size.iter().try_fold(1_usize, |n, &s| n.checked_mul(s as usize));
    // Cells come before those that they are cut into.
    let ends = |link: u32, from: Option<usize>| match link & LEAF {
        0 => (link as usize) < nodes.len() && from.is_none_or(|from| link as usize > from),
        _ => ((link & !LEAF) as usize) < leaves.len(),
    };
    count == Some(roots.len())
        && !roots.is_empty()
        && origin.is_finite()
        && cell.is_finite()
        && *cell > 0.0
        && roots.iter().all(|&link| ends(link, None))
        && nodes.iter().enumerate().all(|(n, links)| links.iter().all(|&link| ends(link, Some(n))))
        && leaves.as_flattened().iter().all(|d| d.is_finite())
}
