//! Triangle surfaces; closed ones are solids, which move.

mod adjacency;
mod clean;
mod inner;
mod nearest;
mod turned;
mod winding;

pub use nearest::{NearestOnMesh, TrianglePart, nearest_on_triangle};

use crate::{LARGEST, polyhedron};
use rockfall_math::{Aabb, DVec3, Vec3};
use rockfall_tree::Tree;

/// A triangle surface with what the pair functions need to avoid bumps at internal edges.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Corners, metres.
    pub vertices: Vec<Vec3>,
    /// Corners of each triangle, counter-clockwise from the outside.
    pub triangles: Vec<[u32; 3]>,
    /// Unit normal of each triangle.
    pub normals: Vec<Vec3>,
    /// Edge i of a triangle runs from corner i to corner (i + 1) % 3.
    pub edges: Vec<[EdgeKind; 3]>,
    /// Neighbour over each edge, `u32::MAX` where there is none.
    pub neighbours: Vec<[u32; 3]>,
    /// Broad phase over the triangles' boxes.
    pub tree: Tree,
    /// Box around the vertices.
    pub bounds: Aabb,
    /// Every edge joins exactly two triangles that agree in orientation, so that the inside is defined.
    pub closed: bool,
    /// Middle and radius, metres, of a ball that fits inside: a large one, of a cube two thirds of the largest; a radius of 0 where the mesh is open or inside out.
    pub inner_ball: (Vec3, f32),
    /// What was found and mended on the way.
    pub report: MeshReport,
}

/// How the surface bends at an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeKind {
    /// Only one triangle, or more than two: the edge collides by itself.
    Boundary,
    /// The surface bends away: the edge collides, with normals between those of its two triangles.
    Convex,
    /// The two triangles lie in one plane, up to a thousandth of a radian: no body ever touches the edge
    /// alone.
    Flat,
    /// The surface bends inwards: the edge is out of reach.
    Concave,
}

/// What [`Mesh::from_triangles`] found: nothing of it is an error, but a person who expects a clean, closed
/// mesh wants to know.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MeshReport {
    /// Vertices that another one with the same coordinates replaced, or that no triangle uses.
    pub dropped_vertices: usize,
    /// Triangles without area, left out.
    pub degenerate_triangles: usize,
    /// Triangles that were there already with the same corners and orientation, left out.
    pub duplicate_triangles: usize,
    /// Edges of a single triangle.
    pub open_edges: usize,
    /// Edges of more than two triangles, or of two that disagree in orientation.
    pub tangled_edges: usize,
}

/// Why triangles make no mesh.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshError {
    /// Nothing there.
    #[error("the mesh has no triangles")]
    Empty,
    /// More than a 32-bit index can name.
    #[error("the mesh has more than 1431655764 triangles or 4294967294 vertices")]
    TooMany,
    /// A coordinate is NaN or infinite.
    #[error("vertex {0} of the mesh is not finite")]
    NotFinite(usize),
    /// A coordinate is beyond [`LARGEST`].
    #[error("vertex {0} of the mesh is more than 1000 km from the origin")]
    TooFar(usize),
    /// A corner that is not there.
    #[error("triangle {triangle} of the mesh names vertex {vertex}, but there are only {count}")]
    Index {
        /// The triangle.
        triangle: usize,
        /// What it names.
        vertex: u32,
        /// How many there are.
        count: usize,
    },
    /// All triangles are degenerate.
    #[error("none of the {0} triangles of the mesh has an area")]
    NoArea(usize),
    /// The columns of a mesh that was put together by hand do not fit each other.
    #[error("the columns of the mesh do not fit each other")]
    Layout,
}

impl Mesh {
    /// Cooks a triangle surface, corners counter-clockwise from outside, metres. Vertices with equal
    /// coordinates become one, triangles without area or there twice are left out (see [`MeshReport`]); the
    /// order of the rest stays.
    ///
    /// A triangle has no area when it is more than ten million times as long as it is high: its normal
    /// would be rounding.
    ///
    /// # Errors
    /// No triangle, coordinates that are not finite or beyond [`LARGEST`], corners that are not there.
    ///
    /// # Examples
    /// ```
    /// use rockfall_math::Vec3;
    /// use rockfall_shape::{EdgeKind, Mesh};
    ///
    /// let square = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
    /// let mesh = Mesh::from_triangles(&square, &[[0, 1, 2], [0, 2, 3]])?;
    /// assert_eq!(mesh.edges[0], [EdgeKind::Boundary, EdgeKind::Boundary, EdgeKind::Flat]);
    /// assert!(!mesh.closed);
    /// # Ok::<(), rockfall_shape::MeshError>(())
    /// ```
    pub fn from_triangles(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Result<Mesh, MeshError> {
        check_input(vertices, triangles)?;
        let mut report = MeshReport::default();
        let (vertices, triangles) = clean::clean(vertices, triangles, &mut report);
        if triangles.is_empty() {
            return Err(MeshError::NoArea(report.degenerate_triangles));
        }
        let corners = |t: &[u32; 3]| t.map(|c| vertices[c as usize]);
        let exact: Vec<DVec3> =
            triangles.iter().map(|t| clean::doubled_area(corners(t)).normalize()).collect();
        let (edges, neighbours) = adjacency::join(&vertices, &triangles, &exact, &mut report);
        let boxes: Vec<Aabb> = triangles.iter().map(|t| Aabb::from_points(corners(t))).collect();
        let mut mesh = Mesh {
            normals: exact.iter().map(|n| n.as_vec3()).collect(),
            edges,
            neighbours,
            tree: Tree::build(&boxes),
            bounds: Aabb::from_points(vertices.iter().copied()),
            closed: report.open_edges == 0 && report.tangled_edges == 0,
            inner_ball: (Vec3::ZERO, 0.0),
            vertices,
            triangles,
            report,
        };
        if mesh.encloses() {
            mesh.inner_ball = inner::inner_ball(&mesh);
        }
        Ok(mesh)
    }

    /// Whether there is an inside: the mesh is closed, and its normals point outwards.
    pub fn encloses(&self) -> bool {
        self.closed && polyhedron::moments(self.corners()).volume > 0.0
    }

    /// Corners of triangle `t`, counter-clockwise from outside.
    pub fn triangle(&self, t: usize) -> [Vec3; 3] {
        self.triangles[t].map(|c| self.vertices[c as usize])
    }

    /// Corners of all triangles in double precision.
    pub(crate) fn corners(&self) -> impl Iterator<Item = [DVec3; 3]> {
        self.triangles.iter().map(|t| t.map(|c| self.vertices[c as usize].as_dvec3()))
    }

    /// Whether the columns fit each other; always so for a mesh from [`Mesh::from_triangles`].
    ///
    /// # Errors
    /// The first thing that does not fit.
    pub fn check(&self) -> Result<(), MeshError> {
        check_input(&self.vertices, &self.triangles)?;
        let count = self.triangles.len();
        let fits = [self.normals.len(), self.edges.len(), self.neighbours.len(), self.tree.len()]
            == [count; 4]
            && self.neighbours.as_flattened().iter().all(|&n| n == u32::MAX || (n as usize) < count)
            && self.normals.iter().all(|n| (n.length_squared() - 1.0).abs() < 1e-5);
        if fits { Ok(()) } else { Err(MeshError::Layout) }
    }
}

fn check_input(vertices: &[Vec3], triangles: &[[u32; 3]]) -> Result<(), MeshError> {
    if triangles.is_empty() {
        return Err(MeshError::Empty);
    }
    // Half-edges, three per triangle, must be countable as well.
    if triangles.len() > (u32::MAX / 3 - 1) as usize || vertices.len() >= u32::MAX as usize {
        return Err(MeshError::TooMany);
    }
    if let Some(i) = vertices.iter().position(|v| !v.is_finite()) {
        return Err(MeshError::NotFinite(i));
    }
    if let Some(i) = vertices.iter().position(|v| v.abs().max_element() > LARGEST) {
        return Err(MeshError::TooFar(i));
    }
    let count = vertices.len();
    match triangles.as_flattened().iter().position(|&c| c as usize >= count) {
        Some(i) => Err(MeshError::Index { triangle: i / 3, vertex: triangles[i / 3][i % 3], count }),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests;
