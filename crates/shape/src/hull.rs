//! Convex polyhedra: the cooked form that the pair functions read.
//!
//! Cooking goes: points → triangles of their exact convex hull → polygon faces → the columns of [`Hull`] → a
//! check of every promise. Faces merge by a tolerance; should the outcome break a promise, which no known
//! points make it do, cooking starts again without, and all faces are triangles.

mod blocks;
mod check;
mod merge;
mod quickhull;

pub use blocks::{CornerBlock, EdgeBlock, FaceBlock, HULL_LANES, HullBlocks};
pub use check::HullDefect;

use crate::polyhedron::moments;
use crate::{LARGEST, SMALLEST};
use merge::{Merged, merge};
use quickhull::{Goal, quickhull};
use rockfall_math::{Aabb, DVec3, Vec3};

/// A convex polyhedron, faces merged where they are coplanar.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    /// Corners, metres, in the user's frame.
    pub vertices: Vec<Vec3>,
    /// Outward unit normal of each face.
    pub normals: Vec<Vec3>,
    /// `normals[f] · p == offsets[f]` for every point p of face f.
    pub offsets: Vec<f32>,
    /// `loops[loop_starts[f]..loop_starts[f + 1]]` are the corners of face f, counter-clockwise from outside.
    pub loop_starts: Vec<u32>,
    /// Vertex indices, see `loop_starts`.
    pub loops: Vec<u32>,
    /// Every edge once.
    pub edges: Vec<HullEdge>,
    /// Box around the vertices.
    pub bounds: Aabb,
    /// A point well inside: the centroid of the volume.
    pub center: Vec3,
    /// Distance from `center` to the nearest face.
    pub inner_radius: f32,
    /// Corners and faces once more, sixteen side by side.
    pub blocks: HullBlocks,
}

/// An edge of a [`Hull`] with the two faces that it joins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HullEdge {
    /// The edge runs from `vertices[0]` to `vertices[1]`, counter-clockwise around `faces[0]`.
    pub vertices: [u32; 2],
    /// The face on the left, seen from outside, and the one on the right.
    pub faces: [u32; 2],
}

/// Why points make no hull.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HullError {
    /// Less than four points.
    #[error("a hull needs at least 4 points, not {0}")]
    TooFew(usize),
    /// More points than a 32-bit index can name.
    #[error("a hull can be made of at most 4294967294 points, not {0}")]
    TooMany(usize),
    /// A coordinate is NaN or infinite.
    #[error("point {0} of the hull is not finite")]
    NotFinite(usize),
    /// A coordinate is beyond [`LARGEST`].
    #[error("point {0} of the hull is more than 1000 km from the origin")]
    TooFar(usize),
    /// All points are the same.
    #[error("all points of the hull coincide, or are less than a micrometre apart")]
    Coincident,
    /// All points are on one line.
    #[error("all points of the hull lie on a line")]
    Collinear,
    /// All points are in one plane.
    #[error("all points of the hull lie in a plane, or within a hundred-thousandth of their extent of one")]
    Coplanar,
    /// More corners than a body can carry.
    #[error("the hull has more than {MAX_CORNERS} corners: simplify it")]
    TooManyCorners,
    /// The hull that was built breaks a promise.
    #[error("the hull of these points is broken: {0}")]
    Broken(HullDefect),
}

/// The most corners that a hull may have. Contact between hulls costs time for each corner; a few dozen serve
/// well.
pub const MAX_CORNERS: usize = 8192;

/// Corners closer than this to a common plane make one face, and no corner sticks out of a face's plane by
/// much more, metres: one millionth of the extent, which is some ten times the rounding of coordinates that
/// have been rotated; but at least four units in the last place of the largest coordinate.
fn tolerance(bounds: &Aabb) -> f64 {
    let extent = (bounds.max.as_dvec3() - bounds.min.as_dvec3()).max_element();
    let largest = f64::from(bounds.min.abs().max(bounds.max.abs()).max_element());
    (1e-6 * extent).max(largest / f64::from(1 << 22))
}

/// How far lengths of a hull with these corners may be off, metres.
fn slack(vertices: &[Vec3]) -> f64 {
    4.0 * tolerance(&Aabb::from_points(vertices.iter().copied()))
}

impl Hull {
    /// The convex hull of `points`, metres. Points inside, duplicates, and corners that stick out by less
    /// than about a millionth of the extent leave no trace; corners keep the order that their points have.
    /// The same points give the same hull, bit by bit, on every machine.
    ///
    /// # Errors
    /// Points that are not finite, are farther than [`LARGEST`] from the origin, or span no volume: less than
    /// [`SMALLEST`] across, or flatter than a hundred-thousandth of their extent. Hulls of more than
    /// [`MAX_CORNERS`] corners: see [`Hull::from_points_at_most`].
    ///
    /// # Examples
    /// ```
    /// use rockfall_math::Vec3;
    /// use rockfall_shape::Hull;
    ///
    /// let corners = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z, 0.1 * Vec3::ONE];
    /// let hull = Hull::from_points(&corners)?;
    /// assert_eq!((hull.vertices.len(), hull.edges.len(), hull.normals.len()), (4, 6, 4));
    /// # Ok::<(), rockfall_shape::HullError>(())
    /// ```
    pub fn from_points(points: &[Vec3]) -> Result<Hull, HullError> {
        Self::cook(points, usize::MAX)
    }

    /// The convex hull of `points` with at most `max_vertices` corners, at least 4: those that stick out
    /// farthest, chosen greedily, so that the hull lies inside the full one and is near to it.
    ///
    /// # Errors
    /// As for [`Hull::from_points`].
    pub fn from_points_at_most(points: &[Vec3], max_vertices: usize) -> Result<Hull, HullError> {
        Self::cook(points, max_vertices.clamp(4, MAX_CORNERS))
    }

    /// This hull with at most `max_vertices` corners (at least 4), a part of its own: those that stick out
    /// farthest, chosen greedily. The outcome is convex and inside this hull.
    ///
    /// # Errors
    /// [`HullError::Coplanar`] when so few corners are left that they span no volume.
    pub fn simplified(&self, max_vertices: usize) -> Result<Hull, HullError> {
        if self.vertices.len() <= max_vertices.max(4) {
            return Ok(self.clone());
        }
        Self::cook(&self.vertices, max_vertices.max(4))
    }

    /// The box with half edge lengths `half`, metres, positive, around the origin.
    pub fn cuboid(half: Vec3) -> Hull {
        let sign = |bit: bool| if bit { 1.0 } else { -1.0 };
        let corner = |i: usize| half * Vec3::new(sign(i & 1 != 0), sign(i & 2 != 0), sign(i & 4 != 0));
        let faces = [[0, 1, 5, 4], [0, 2, 3, 1], [0, 4, 6, 2], [1, 3, 7, 5], [2, 6, 7, 3], [4, 5, 7, 6]];
        Self::assemble((0..8).map(corner).collect(), &faces.map(|f| f.to_vec()))
    }

    /// Corners of face `f`, counter-clockwise from outside.
    pub fn face(&self, f: usize) -> &[u32] {
        &self.loops[self.loop_starts[f] as usize..self.loop_starts[f + 1] as usize]
    }

    /// The surface cut into triangles: each face as a fan around its first corner.
    pub(crate) fn triangles(&self) -> impl Iterator<Item = [DVec3; 3]> {
        let at = |c: u32| self.vertices[c as usize].as_dvec3();
        (0..self.normals.len()).flat_map(move |f| {
            let corners = self.face(f);
            corners[1..].windows(2).map(move |w| [at(corners[0]), at(w[0]), at(w[1])])
        })
    }

    fn cook(points: &[Vec3], max_vertices: usize) -> Result<Hull, HullError> {
        if points.len() < 4 {
            return Err(HullError::TooFew(points.len()));
        }
        if points.len() >= u32::MAX as usize {
            return Err(HullError::TooMany(points.len()));
        }
        if let Some(i) = points.iter().position(|p| !p.is_finite()) {
            return Err(HullError::NotFinite(i));
        }
        if let Some(i) = points.iter().position(|p| p.abs().max_element() > LARGEST) {
            return Err(HullError::TooFar(i));
        }
        let bounds = Aabb::from_points(points.iter().copied());
        if (bounds.max - bounds.min).max_element() < SMALLEST {
            return Err(HullError::Coincident);
        }
        let whole = tolerance(&bounds);
        let mut broken = HullDefect::Layout;
        for tolerance in [whole, 0.0] {
            let Some((corners, faces)) = polyhedron(points, max_vertices, whole, tolerance)? else {
                continue;
            };
            if corners.len() > MAX_CORNERS {
                return Err(HullError::TooManyCorners);
            }
            let hull = Self::assemble(corners, &faces);
            match hull.check() {
                Ok(()) => return Ok(hull),
                Err(defect) => broken = defect,
            }
        }
        Err(HullError::Broken(broken))
    }

    /// Fills all columns from corners and loops. Promises nothing: see [`Hull::check`].
    fn assemble(vertices: Vec<Vec3>, faces: &[Vec<u32>]) -> Hull {
        let mut hull = Hull {
            bounds: Aabb::from_points(vertices.iter().copied()),
            vertices,
            normals: Vec::with_capacity(faces.len()),
            offsets: Vec::with_capacity(faces.len()),
            loop_starts: vec![0],
            loops: faces.concat(),
            edges: Vec::new(),
            center: Vec3::ZERO,
            inner_radius: 0.0,
            blocks: HullBlocks::default(),
        };
        let points: Vec<DVec3> = hull.vertices.iter().map(|v| v.as_dvec3()).collect();
        for corners in faces {
            // Newell's normal, seen from the first corner so that nothing is lost far from the origin.
            let origin = points[corners[0] as usize];
            let fan = corners.windows(2).map(|w| {
                let [a, b] = [w[0], w[1]].map(|c| points[c as usize] - origin);
                a.cross(b)
            });
            let normal = fan.sum::<DVec3>().normalize_or_zero().as_vec3();
            // No corner may be outside, so that the offset belongs to the rounded normal and the farthest
            // corner.
            let reach = |p: &DVec3| normal.as_dvec3().dot(*p);
            hull.normals.push(normal);
            hull.offsets.push(points.iter().map(reach).fold(f64::NEG_INFINITY, f64::max) as f32);
            hull.loop_starts.push(hull.loop_starts[hull.loop_starts.len() - 1] + corners.len() as u32);
        }
        let halves = hull.half_edges();
        for &[u, v, left] in halves.iter().filter(|h| h[0] < h[1]) {
            let back = halves.partition_point(|h| h[..2] < [v, u][..]);
            if let Some(&[_, _, right]) = halves.get(back).filter(|h| h[..2] == [v, u]) {
                hull.edges.push(HullEdge { vertices: [u, v], faces: [left, right] });
            }
        }
        let center = moments(hull.triangles()).center;
        hull.center = center.as_vec3();
        let depth =
            hull.normals.iter().zip(&hull.offsets).map(|(n, &o)| f64::from(o) - n.as_dvec3().dot(center));
        hull.inner_radius = depth.fold(f64::INFINITY, f64::min) as f32;
        hull.blocks = HullBlocks::of(&hull);
        hull
    }

    /// Start, end and face of every edge in both directions, sorted.
    fn half_edges(&self) -> Vec<[u32; 3]> {
        let mut halves = Vec::with_capacity(self.loops.len());
        for f in 0..self.normals.len() {
            let corners = self.face(f);
            let ends = corners.iter().cycle().skip(1);
            halves.extend(corners.iter().zip(ends).map(|(&u, &v)| [u, v, f as u32]));
        }
        halves.sort_unstable();
        halves
    }
}

/// Corners and the loops of the faces.
type Faceted = (Vec<Vec3>, Vec<Vec<u32>>);

/// Corners and loops of the convex hull, `None` if no faces can be merged at this tolerance.
fn polyhedron(
    points: &[Vec3],
    max_vertices: usize,
    whole: f64,
    tolerance: f64,
) -> Result<Option<Faceted>, HullError> {
    // Adding zero turns -0 into 0, so that equal points have equal bits.
    let mut kept: Vec<DVec3> = points.iter().map(|p| (*p + Vec3::ZERO).as_dvec3()).collect();
    loop {
        // Far more than there may be in the end: merging takes few away.
        let corners = max_vertices.min(2 * MAX_CORNERS + 1);
        let goal = Goal { corners, near: 0.5 * tolerance, flat: 10.0 * whole };
        let triangles = quickhull(&kept, goal)?;
        let used = renumber(&mut kept, triangles);
        if kept.len() > 2 * MAX_CORNERS {
            return Err(HullError::TooManyCorners);
        }
        match merge(&kept, &used, tolerance) {
            Ok(Merged::Faces(mut faces)) => {
                for corners in &mut faces {
                    let lowest = (0..corners.len()).min_by_key(|&i| corners[i]).unwrap_or(0);
                    corners.rotate_left(lowest);
                }
                faces.sort_unstable();
                return Ok(Some((kept.iter().map(|p| p.as_vec3()).collect(), faces)));
            }
            Ok(Merged::Drop(idle)) => {
                let mut i = 0;
                kept.retain(|_| {
                    i += 1;
                    idle.binary_search(&(i - 1)).is_err()
                });
            }
            Err(_) => return Ok(None),
        }
    }
}

/// Keeps the points that the triangles use, in their order, and names them anew.
fn renumber(points: &mut Vec<DVec3>, mut triangles: Vec<[u32; 3]>) -> Vec<[u32; 3]> {
    let mut used: Vec<u32> = triangles.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    for c in triangles.as_flattened_mut() {
        *c = used.partition_point(|u| u < c) as u32;
    }
    *points = used.iter().map(|&u| points[u as usize]).collect();
    triangles
}

#[cfg(test)]
mod tests;
