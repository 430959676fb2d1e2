//! Signed distance fields: solid bodies of any form, concave ones included, from a closed mesh.
//!
//! What flows in: a closed triangle mesh, and by how much the field may err. What flows out: the signed distance at any place, by
//! interpolation in an octree (`octree.rs`, `build.rs`, `seams.rs`), and points of the surface (`samples.rs`), whose distances from another body tell where the two
//! touch. Mass, bounds and rays take the mesh itself.
//!
//! The mesh decides what is inside: a cavity is a part of its surface that shows the other way. A mesh whose parts cross each other or lie within each other has no clear inside, and is refused (`sound.rs`).

mod build;
mod eight;
mod features;
mod octree;
mod samples;
mod seams;
mod sound;
mod store;

pub use features::{Feature, FeatureEdge, Features, Normals};
pub use samples::{Balls, SAMPLES_IN_A_BALL, Sample, Samples};
pub use store::CacheUse;

use crate::{Mesh, MeshError};
use octree::{Octree, Spot};
use rockfall_math::Vec3;
use std::sync::Arc;

/// By which share of the distance a field may err besides its error.
const FAR: f64 = 0.25;

/// The smallest error of a field, as a share of the longest side of its body.
const FINEST: f32 = 1e-4;

/// The most leaves that a field may have: 512 MiB.
const MOST_CELLS: usize = 1 << 24;

/// The most points of the surface that a field may have.
const MOST_SAMPLES: usize = 1 << 22;

/// Distance of samples as a multiple of the error.
const SPACING: f32 = 4.0;

/// How exact a [`Field`] is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldSettings {
    /// Largest difference of the field's distance from the exact one at the surface, metres; away from it a quarter of the distance is added.
    pub error: f32,
    /// No point of the surface is further than that from a sample, metres: smaller features of two bodies may miss each other.
    pub spacing: f32,
}

impl FieldSettings {
    /// An error, and samples four times as far apart.
    pub fn with_error(error: f32) -> Self {
        FieldSettings { error, spacing: SPACING * error }
    }
}

/// A solid body as its signed distance, with points of its surface. See [`Field::new`].
#[derive(Clone)]
pub struct Field {
    mesh: Arc<Mesh>,
    settings: FieldSettings,
    octree: Octree,
    samples: Samples,
    features: Features,
    /// Middle and radius of a ball that fits inside.
    inner: (Vec3, f32),
    /// See [`Shape::contact_scale`](crate::Shape::contact_scale), metres.
    contact_scale: f32,
    /// Hash of mesh and settings.
    key: u128,
}

/// Why a mesh has no [`Field`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FieldError {
    /// It has no inside.
    #[error(
        "the mesh is not closed, so that it has no inside: {open} of its edges have one triangle only, and {tangled} have more than two or two that \
         show different sides; expected that each edge joins two triangles"
    )]
    Open {
        /// Edges of a single triangle.
        open: usize,
        /// Edges of more than two triangles, or of two that disagree.
        tangled: usize,
    },
    /// Its triangles show their backs.
    #[error("the mesh is inside out: expected triangles that are counter-clockwise from outside")]
    InsideOut,
    /// Parts of its surface lie within each other.
    #[error(
        "the mesh has no clear inside: at {count} of {of} points looked at, one of them {at}, the surface shows one side and a ray through all of it another, because parts of the mesh lie within each other or cross; \
         expected a single surface around the body: join the parts to one (a boolean union or a remesh in a modelling program), or make the shape a decomposition, which takes such a mesh"
    )]
    Crossed {
        /// Points next to the surface at which the two disagree.
        count: usize,
        /// How many were looked at.
        of: usize,
        /// The first of them, metres.
        at: Vec3,
    },
    /// A setting is out of range.
    #[error("the {what} of the field is {value} m, expected {least} m to {most} m for a body of this size")]
    Setting {
        /// Which.
        what: &'static str,
        /// What it was.
        value: f32,
        /// The least that it may be.
        least: f32,
        /// The most that it may be.
        most: f32,
    },
    /// It would not fit into memory.
    #[error("an error of {error} m would take more than {most} cells; a larger error takes fewer")]
    TooFine {
        /// What was asked for, metres.
        error: f32,
        /// How many cells there may be.
        most: usize,
    },
    /// There would be too many samples.
    #[error(
        "a spacing of {spacing} m would take {count} points of the surface, more than {most}; a larger spacing takes fewer"
    )]
    TooMany {
        /// What was asked for, metres.
        spacing: f32,
        /// How many that would be.
        count: usize,
        /// How many there may be.
        most: usize,
    },
}

/// Memory of a [`Field`], bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FieldMemory {
    /// The octree.
    pub cells: usize,
    /// Points of the surface with the balls around them, corners and edges.
    pub samples: usize,
    /// The mesh.
    pub mesh: usize,
}

impl FieldMemory {
    /// All of it.
    pub fn total(&self) -> usize {
        self.cells + self.samples + self.mesh
    }
}

/// What a field says of a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldPoint {
    /// Signed distance, metres.
    pub distance: f32,
    /// Unit vector along which it grows.
    pub normal: Vec3,
}

impl Field {
    /// Samples a mesh. Parallel; the same bits on any number of threads.
    ///
    /// # Errors
    /// A mesh that is not closed, is inside out or cuts through itself, an error or a spacing that does not fit the size of the body, and one that would take too much memory.
    ///
    /// # Examples
    /// ```
    /// use rockfall_math::Vec3;
    /// use rockfall_shape::{Field, FieldSettings, Mesh};
    /// use std::sync::Arc;
    ///
    /// let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z].map(|v| 0.1 * v);
    /// let mesh = Mesh::from_triangles(&corners, &[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])?;
    /// let field = Field::new(Arc::new(mesh), FieldSettings::with_error(1e-3))?;
    /// let below = field.distance(Vec3::new(0.02, 0.02, -0.005));
    /// assert!((below - 0.005).abs() <= field.bound(below));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(mesh: Arc<Mesh>, settings: FieldSettings) -> Result<Field, FieldError> {
        check(&mesh, settings)?;
        let samples = Samples::of(&mesh, settings.spacing)?;
        sound::check(&mesh, &samples, settings.error)?;
        let (mut octree, places) = build::build(&mesh, settings.error)?;
        seams::close(&mut octree, &places);
        let features = Features::of(&mesh, &samples, settings.spacing);
        let inner = deepest(&mesh, &octree, &places);
        let key = store::key(&mesh, settings);
        let contact_scale = contact_scale(&mesh, inner.1);
        Ok(Field { mesh, settings, octree, samples, features, inner, contact_scale, key })
    }

    /// The same body at another size: errors and spacing grow with it.
    ///
    /// # Errors
    /// What mesh cooking says of the scaled corners.
    pub fn scaled(&self, by: f32) -> Result<Field, MeshError> {
        let vertices: Vec<Vec3> = self.mesh.vertices.iter().map(|v| by * *v).collect();
        let mesh = Arc::new(Mesh::from_triangles(&vertices, &self.mesh.triangles)?);
        let FieldSettings { error, spacing } = self.settings;
        let settings = FieldSettings { error: by * error, spacing: by * spacing };
        let key = store::key(&mesh, settings);
        let (octree, samples) = (self.octree.scaled(by), self.samples.scaled(by));
        let inner = (by * self.inner.0, by * self.inner.1);
        let features = self.features.clone();
        let contact_scale = contact_scale(&mesh, inner.1);
        Ok(Field { mesh, settings, octree, samples, features, inner, contact_scale, key })
    }

    /// What it was sampled from.
    pub fn mesh(&self) -> &Arc<Mesh> {
        &self.mesh
    }

    /// How exact it is.
    pub fn settings(&self) -> FieldSettings {
        self.settings
    }

    /// Points of the surface.
    pub fn samples(&self) -> &Samples {
        &self.samples
    }

    /// Corners and edges by which its mesh touches others.
    pub fn features(&self) -> &Features {
        &self.features
    }

    /// Middle and radius, metres, of a ball that fits inside: nearly the largest.
    pub fn inner_ball(&self) -> (Vec3, f32) {
        self.inner
    }

    pub(crate) fn contact_scale(&self) -> f32 {
        self.contact_scale
    }

    /// How much memory it takes.
    pub fn memory(&self) -> FieldMemory {
        let mesh = &self.mesh;
        // Normals, edges and neighbours besides corners.
        let triangles = (12 + 12 + 3 + 12) * mesh.triangles.len();
        FieldMemory {
            cells: self.octree.memory(),
            samples: self.samples.memory() + self.features.memory(),
            mesh: 12 * mesh.vertices.len() + triangles + mesh.tree.memory(),
        }
    }

    /// Number of cells in which it is interpolated.
    pub fn cells(&self) -> usize {
        self.octree.leaves.len()
    }

    /// The largest difference from the exact distance where the field says `distance`, metres.
    pub fn bound(&self, distance: f32) -> f32 {
        // The share is one of the exact distance.
        const SHARE: f32 = (FAR / (1.0 - FAR)) as f32;
        self.settings.error + SHARE * (distance.abs() + self.settings.error)
    }

    /// Signed distance of a point from the surface, metres: within [`Field::bound`] in the box around the body and a rim of about a tenth of its size, an estimate further out.
    #[inline]
    pub fn distance(&self, p: Vec3) -> f32 {
        let (inside, beyond) = self.covered(p);
        let distance = self.octree.value(inside);
        if beyond == Vec3::ZERO { distance } else { self.distance_beyond(inside, beyond) }
    }

    /// A distance that the point has surely, metres.
    #[inline]
    pub fn least_distance(&self, p: Vec3) -> f32 {
        let (inside, beyond) = self.covered(p);
        let distance = self.octree.value(inside);
        match beyond == Vec3::ZERO {
            true => distance - self.bound(distance),
            false => self.surely_beyond(distance, beyond.length()),
        }
    }

    /// A distance that a point surely has which is so `far` out of the covered box, where the nearest point of that has `distance`. All of the body is half a large cell within the box.
    fn surely_beyond(&self, distance: f32, far: f32) -> f32 {
        (far + 0.49 * self.octree.cell).max(distance - self.bound(distance) - far)
    }

    /// Signed distance as [`Field::distance`] has it; or, as the error, a distance that the point has surely, if that is more than `limit`: far out it takes a seventh of the time.
    #[inline]
    pub fn distance_below(&self, p: Vec3, limit: f32) -> Result<f32, f32> {
        let (inside, beyond) = self.covered(p);
        let distance = self.octree.value(inside);
        if beyond == Vec3::ZERO {
            return Ok(distance);
        }
        let surely = self.surely_beyond(distance, beyond.length());
        if surely > limit { Err(surely) } else { Ok(self.distance_beyond(inside, beyond)) }
    }

    /// [`Field::distance_below`], with how it changes along x, y and z within its cell: nearly a unit vector, the way out of the body, where all ways out in the cell are alike, and a shorter one where they are not. Zero outside the covered box.
    #[inline]
    pub fn slope_below(&self, p: Vec3, limit: f32) -> Result<(f32, Vec3), f32> {
        let (inside, beyond) = self.covered(p);
        if beyond != Vec3::ZERO {
            return self.distance_below(p, limit).map(|distance| (distance, Vec3::ZERO));
        }
        Ok(self.octree.slope_at(&self.octree.spot(inside)))
    }

    /// Signed distance and direction out of the body. The direction is that of differences over the width of a cell, which changes smoothly from cell to cell.
    pub fn nearest(&self, p: Vec3) -> FieldPoint {
        let (inside, beyond) = self.covered(p);
        let spot = self.octree.spot(inside);
        let distance = match beyond == Vec3::ZERO {
            true => self.octree.value_at(&spot),
            false => self.distance_beyond(inside, beyond),
        };
        FieldPoint { distance, normal: self.slope(p, &spot) }
    }

    /// The nearest point of the covered box, and the way from there.
    fn covered(&self, p: Vec3) -> (Vec3, Vec3) {
        let inside = p.clamp(self.octree.origin, self.octree.end());
        (inside, p - inside)
    }

    /// Out along the direction that the distance has at the border; never more than the way, and never less than the way is long.
    fn distance_beyond(&self, inside: Vec3, beyond: Vec3) -> f32 {
        let (distance, slope) = self.octree.slope_at(&self.octree.spot(inside));
        let far = beyond.length();
        let along = distance + slope.normalize_or(Vec3::Z).dot(beyond);
        along.max(far).max(distance - far).min(distance + far)
    }

    fn slope(&self, p: Vec3, spot: &Spot) -> Vec3 {
        let step = 0.5 * spot.edge;
        let along = |axis: Vec3| self.distance(p + step * axis) - self.distance(p - step * axis);
        Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z)).normalize_or(Vec3::Z)
    }
}

/// What would be printed of the octree follows from the mesh and the settings, and so does the key.
impl std::fmt::Debug for Field {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let key = format_args!("{:032x}", self.key);
        f.debug_struct("Field").field("key", &key).field("settings", &self.settings).finish_non_exhaustive()
    }
}

/// The inner radius, or a quarter of the outer one, whichever is more: walls may be thin.
fn contact_scale(mesh: &Mesh, inner_radius: f32) -> f32 {
    let center = mesh.bounds.center();
    let squared = mesh.vertices.iter().map(|p| (*p - center).length_squared()).fold(0.0, f32::max);
    inner_radius.max(0.25 * squared.sqrt())
}

fn check(mesh: &Arc<Mesh>, FieldSettings { error, spacing }: FieldSettings) -> Result<(), FieldError> {
    if !mesh.closed {
        let report = &mesh.report;
        return Err(FieldError::Open { open: report.open_edges, tangled: report.tangled_edges });
    }
    if !mesh.encloses() {
        return Err(FieldError::InsideOut);
    }
    let size = (mesh.bounds.max - mesh.bounds.min).max_element();
    for (what, value) in [("error", error), ("spacing", spacing)] {
        let (least, most) = (FINEST * size, size);
        if !(least..=most).contains(&value) {
            return Err(FieldError::Setting { what, value, least, most });
        }
    }
    Ok(())
}

/// The corner of a cell that is deepest in the body, the first of several.
fn deepest(mesh: &Mesh, octree: &Octree, places: &[build::Place]) -> (Vec3, f32) {
    let mut best = (0.0, Vec3::ZERO);
    for (corners, place) in octree.leaves.iter().zip(places) {
        for (k, &distance) in corners.iter().enumerate() {
            if distance < best.0 {
                let unit = octree.cell / (1_u32 << octree::MOST_CUTS) as f32;
                let step = 1_u32 << (octree::MOST_CUTS - place.cuts);
                let at = build::corner(k).map(|bit| bit * step);
                let at = [0, 1, 2].map(|i| (place.low[i] + at[i]) as f32);
                best = (distance, octree.origin + unit * Vec3::from(at));
            }
        }
    }
    let exact = mesh.nearest(best.1.as_dvec3(), f64::INFINITY).map_or(0.0, |near| near.distance);
    (best.1, (-exact).max(0.0) as f32)
}

#[cfg(test)]
mod tests;
