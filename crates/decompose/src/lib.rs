//! Convex decomposition: a closed mesh as a compound of hulls.
//!
//! A body may be concave where its parts are not. The cut into parts is that of `parry3d` (V-HACD: Mamou and Ghorbel, "A simple and
//! efficient approach for 3D mesh approximate convex decomposition", ICIP 2009): the mesh is filled with voxels, which are
//! halved along planes until each piece is nearly convex. The hulls are ours, of the mesh's own surface in each piece, so that they
//! lie on the mesh where it bulges and err only where it is hollow. By how much is measured, in both directions.
//!
//! The result depends on mesh and options alone, not on the number of threads.

#![forbid(unsafe_code)]

mod cut;
mod misfit;

pub use misfit::{Misfit, misfit};

use rockfall_math::Pose;
use rockfall_shape::{Compound, CompoundError, Mesh, Shape};
use std::sync::Arc;

/// How finely a mesh is cut up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// Voxels along the longest side of the mesh, 8 to 512. Time and memory grow with the cube.
    pub resolution: u32,
    /// The most hulls there may be, 4 to 1024. Pieces are halved, so that a power of two is made use of: 24 is 16.
    pub max_hulls: u32,
    /// A piece is halved while it lacks more than this share of its hull's volume, as a share of the hull of the whole; 0 to 1.
    pub concavity: f32,
    /// Corners of a hull, 4 to 255: those that stick out farthest are kept.
    pub max_vertices: u32,
}

impl Default for Options {
    fn default() -> Self {
        Options { resolution: 64, max_hulls: 32, concavity: 0.002, max_vertices: 32 }
    }
}

/// A mesh that was cut up.
#[derive(Clone, Debug)]
pub struct Decomposition {
    /// The hulls, with the mass properties of the mesh itself.
    pub compound: Compound,
    /// How far the hulls are from the mesh.
    pub misfit: Misfit,
}

/// Why a mesh is not cut up.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DecomposeError {
    /// An option is out of its range.
    #[error("the {what} is {value}, expected {expected}")]
    Option {
        /// Which.
        what: &'static str,
        /// What it was.
        value: String,
        /// What it may be.
        expected: &'static str,
    },
    /// The mesh has no inside.
    #[error(
        "the mesh has no inside ({open_edges} open edges, {tangled_edges} tangled ones), expected a closed mesh whose \
         triangles are counter-clockwise from outside"
    )]
    NoInside {
        /// Edges of a single triangle.
        open_edges: usize,
        /// Edges of more than two triangles, or of two that disagree in orientation.
        tangled_edges: usize,
    },
    /// The library that cuts gave up.
    #[error("the mesh can't be cut at a resolution of {0}: try another one")]
    Cut(u32),
    /// No piece has a volume.
    #[error("the mesh is thinner than hulls can be: no piece of it has a volume")]
    Flat,
    /// The hulls make no compound.
    #[error(transparent)]
    Compound(#[from] CompoundError),
}

impl Options {
    fn check(&self) -> Result<(), DecomposeError> {
        let refuse = |what, value: String, expected| Err(DecomposeError::Option { what, value, expected });
        if !(8..=512).contains(&self.resolution) {
            return refuse("resolution", self.resolution.to_string(), "8 to 512 voxels");
        }
        if !(4..=1024).contains(&self.max_hulls) {
            return refuse("number of hulls", self.max_hulls.to_string(), "4 to 1024");
        }
        if !(0.0..=1.0).contains(&self.concavity) {
            return refuse("concavity", self.concavity.to_string(), "a share from 0 to 1");
        }
        if !(4..=255).contains(&self.max_vertices) {
            return refuse("number of corners", self.max_vertices.to_string(), "4 to 255");
        }
        Ok(())
    }
}

/// Cuts a closed mesh into hulls, and measures how far they are from it at points as far apart as a voxel is large.
///
/// # Errors
/// An option out of its range, a mesh that has no inside, or of which the pieces have no volume.
///
/// # Examples
/// ```
/// use rockfall_decompose::{Options, decompose};
/// use rockfall_shape::{Hull, Mesh};
/// use rockfall_math::Vec3;
///
/// let cube = Hull::cuboid(Vec3::ONE);
/// let faces = (0..6).map(|f| cube.face(f));
/// let triangles: Vec<[u32; 3]> = faces.flat_map(|f| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]]).collect();
/// let mesh = Mesh::from_triangles(&cube.vertices, &triangles)?;
/// let cut = decompose(&mesh, &Options { resolution: 16, ..Options::default() })?;
/// assert_eq!(cut.compound.parts().len(), 1);
/// assert!(cut.misfit.missing < 1e-5 && cut.misfit.filled < 1e-5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn decompose(mesh: &Mesh, options: &Options) -> Result<Decomposition, DecomposeError> {
    options.check()?;
    let solid = Shape::Mesh(Arc::new(mesh.clone()));
    let Some(mass) = solid.mass_properties(1.0) else {
        let report = mesh.report;
        let (open_edges, tangled_edges) = (report.open_edges, report.tangled_edges);
        return Err(DecomposeError::NoInside { open_edges, tangled_edges });
    };
    let hulls = cut::cut(mesh, mass.mass, options)?;
    let parts = hulls.into_iter().map(|hull| (Shape::Hull(Arc::new(hull)), Pose::default()));
    let compound = Compound::new(parts)?.standing_for(mass);
    let longest = 2.0 * mesh.bounds.half_extents().max_element();
    let misfit = misfit(mesh, &compound, longest / options.resolution as f32);
    Ok(Decomposition { compound, misfit })
}
