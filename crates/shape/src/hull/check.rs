//! Does a hull keep its promises? Everything that the pair functions rely on, derived anew.

use super::blocks::HullBlocks;
use super::{Hull, slack};
use rockfall_math::{Aabb, DVec3};

/// A promise that a [`Hull`] breaks.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum HullDefect {
    /// A number is NaN or infinite.
    #[error("a number is not finite")]
    NotFinite,
    /// The columns do not fit each other, or an index points nowhere.
    #[error("its columns do not fit each other")]
    Layout,
    /// A face has less than three corners or one corner twice.
    #[error("the loop of face {0} is no polygon")]
    Loop(usize),
    /// An edge does not run exactly once each way, or the edge list differs from the loops.
    #[error("an edge of face {0} does not join exactly two faces")]
    Edge(usize),
    /// V - E + F is not 2, or a corner has less than three faces.
    #[error("its {vertices} corners, {edges} edges and {faces} faces do not close a surface")]
    Euler {
        /// Corners.
        vertices: usize,
        /// Edges.
        edges: usize,
        /// Faces.
        faces: usize,
    },
    /// A normal is not a unit vector.
    #[error("the normal of face {0} is not of unit length")]
    Normal(usize),
    /// A corner lies off the plane of its face, or outside of another face's.
    #[error("corner {vertex} is off the plane of face {face}")]
    Plane {
        /// Face.
        face: usize,
        /// Corner.
        vertex: usize,
    },
    /// The polygon of a face is not convex.
    #[error("face {0} is not convex")]
    Reflex(usize),
    /// The box, centre or inner radius do not belong to the corners.
    #[error("its box, centre or inner radius are wrong")]
    Summary,
    /// The blocks say something else than the columns.
    #[error("its blocks differ from its columns")]
    Blocks,
}

impl Hull {
    /// Derives every promise of a hull anew: closed loops, each edge in exactly two faces, V - E + F = 2,
    /// planes that touch their own corners and have all others below them, convex faces, a centre inside.
    /// Lengths may be off by a few millionths of the extent. Costs corners × faces.
    ///
    /// # Errors
    /// The first promise that is broken.
    pub fn check(&self) -> Result<(), HullDefect> {
        self.check_layout()?;
        self.check_edges()?;
        self.check_planes()?;
        let deepest =
            |f: usize| f64::from(self.offsets[f]) - self.normals[f].as_dvec3().dot(self.center.as_dvec3());
        let inner = (0..self.normals.len()).map(deepest).fold(f64::INFINITY, f64::min);
        let fits = (inner - f64::from(self.inner_radius)).abs() <= slack(&self.vertices);
        if inner <= 0.0 || !fits || self.bounds != Aabb::from_points(self.vertices.iter().copied()) {
            return Err(HullDefect::Summary);
        }
        if self.blocks == HullBlocks::of(self) { Ok(()) } else { Err(HullDefect::Blocks) }
    }

    fn check_layout(&self) -> Result<(), HullDefect> {
        let finite = self.vertices.iter().chain(&self.normals).all(|v| v.is_finite())
            && self.offsets.iter().all(|o| o.is_finite())
            && self.center.is_finite()
            && self.inner_radius.is_finite();
        if !finite {
            return Err(HullDefect::NotFinite);
        }
        let faces = self.normals.len();
        let layout = self.offsets.len() == faces
            && self.loop_starts.len() == faces + 1
            && self.loop_starts[0] == 0
            && self.loop_starts[faces] as usize == self.loops.len()
            && self.loop_starts.is_sorted()
            && self.loops.iter().all(|&c| (c as usize) < self.vertices.len());
        if !layout {
            return Err(HullDefect::Layout);
        }
        for f in 0..faces {
            let mut corners = self.face(f).to_vec();
            corners.sort_unstable();
            corners.dedup();
            if corners.len() < 3 || corners.len() != self.face(f).len() {
                return Err(HullDefect::Loop(f));
            }
        }
        Ok(())
    }

    fn check_edges(&self) -> Result<(), HullDefect> {
        let halves = self.half_edges();
        for pair in halves.windows(2) {
            if pair[0][..2] == pair[1][..2] {
                return Err(HullDefect::Edge(pair[1][2] as usize));
            }
        }
        let mut listed = Vec::with_capacity(halves.len());
        for e in &self.edges {
            let ([u, v], [left, right]) = (e.vertices, e.faces);
            listed.extend([[u, v, left], [v, u, right]]);
        }
        listed.sort_unstable();
        if listed != halves {
            let at = listed.iter().zip(&halves).find(|(l, h)| l != h).map_or(0, |(_, h)| h[2]);
            return Err(HullDefect::Edge(at as usize));
        }
        let mut faces_at = vec![0; self.vertices.len()];
        self.loops.iter().for_each(|&c| faces_at[c as usize] += 1);
        let [vertices, edges, faces] = [self.vertices.len(), self.edges.len(), self.normals.len()];
        if vertices + faces != edges + 2 || faces_at.iter().any(|&n| n < 3) {
            return Err(HullDefect::Euler { vertices, edges, faces });
        }
        Ok(())
    }

    fn check_planes(&self) -> Result<(), HullDefect> {
        let slack = slack(&self.vertices);
        let points: Vec<DVec3> = self.vertices.iter().map(|v| v.as_dvec3()).collect();
        for (f, (normal, &offset)) in self.normals.iter().zip(&self.offsets).enumerate() {
            let normal = normal.as_dvec3();
            if (normal.length_squared() - 1.0).abs() > 1e-6 {
                return Err(HullDefect::Normal(f));
            }
            let height = |p: DVec3| normal.dot(p) - f64::from(offset);
            if let Some(vertex) = points.iter().position(|&p| height(p) > slack) {
                return Err(HullDefect::Plane { face: f, vertex });
            }
            let corners = self.face(f);
            if let Some(&c) = corners.iter().find(|&&c| height(points[c as usize]) < -slack) {
                return Err(HullDefect::Plane { face: f, vertex: c as usize });
            }
            for (i, &u) in corners.iter().enumerate() {
                let [a, b] = [u, corners[(i + 1) % corners.len()]].map(|c| points[c as usize]);
                let inwards = normal.cross(b - a).normalize_or_zero();
                if corners.iter().any(|&c| inwards.dot(points[c as usize] - a) < -slack) {
                    return Err(HullDefect::Reflex(f));
                }
            }
        }
        Ok(())
    }
}
