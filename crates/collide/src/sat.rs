//! The axis along which two overlapping polyhedra overlap least.
//!
//! The shortest translation that parts two convex polyhedra is along a face normal of one of them or along the
//! cross product of two edges. Of the edge pairs only those count that make a face of the Minkowski difference: the
//! arcs of their face normals on the sphere cross (Gregorius, "The Separating Axis Test between Convex Polyhedra",
//! GDC 2013). A second filter is ours: at the least overlap the nearest points of the two edges are no further apart
//! than the overlap itself, so an edge that stays further from the other polyhedron's box than the best face axis
//! overlaps can't win.

use crate::poly::Poly;
use rockfall_math::{Aabb, Isometry, Vec3};
use smallvec::SmallVec;

/// A candidate for the contact normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Axis {
    /// Unit vector from A to B.
    pub(crate) normal: Vec3,
    /// Metres, negative where the polyhedra overlap along the axis.
    pub(crate) separation: f32,
    /// What made it.
    pub(crate) kind: Kind,
}

/// Where an [`Axis`] comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    FaceOfA(usize),
    FaceOfB(usize),
    /// An edge of A and one of B.
    Edges(usize, usize),
}

/// How much better, metres, an axis further down the list (face of A, face of B, edges) must be to win. Contacts at
/// rest then do not flicker between axes that differ by rounding. At most 0.2 % of the smaller polyhedron's inner
/// radius and 0.5 % of the overlap.
pub(crate) fn preference(smaller_inner_radius: f32, separation: f32) -> f32 {
    2e-3 * smaller_inner_radius + 5e-3 * separation.abs()
}

/// Lanes of the inner loops; the compiler turns them into whatever registers the target has.
const LANES: usize = 8;

/// The axes to take the normal from.
pub(crate) struct Choice {
    /// Faces before edges and faces of A before those of B, within [`preference`].
    pub(crate) steady: Axis,
    /// That of least overlap.
    pub(crate) least: Axis,
    /// The best pair of edges.
    pub(crate) edges: Option<Axis>,
}

/// The axis of least overlap of two polyhedra, and the one to prefer.
pub(crate) fn least_overlap(a: &Poly, b: &Poly, b_in_a: &Isometry) -> Choice {
    let placed: Points = b.vertices.iter().map(|&v| b_in_a.point(v)).collect();

    let (f, separation, normal) = best_face(a.normals.iter().copied(), a.offsets.iter().copied(), &placed);
    let of_a = Axis { normal, separation, kind: Kind::FaceOfA(f) };

    let normals = b.normals.iter().map(|&n| b_in_a.vector(n));
    let offsets =
        b.normals.iter().zip(b.offsets).map(|(&n, &o)| o + b_in_a.vector(n).dot(b_in_a.translation));
    let (f, separation, normal) = best_face(normals, offsets, a.vertices);
    let of_b = Axis { normal: -normal, separation, kind: Kind::FaceOfB(f) };

    let edges = best_edges(a, b, b_in_a, &placed, of_a.separation.max(of_b.separation));
    let mut choice = Choice { steady: of_a, least: of_a, edges };
    let radius = a.inner_radius.min(b.inner_radius);
    for axis in std::iter::once(of_b).chain(edges) {
        let steady = choice.steady.separation;
        if axis.separation > steady + preference(radius, steady) {
            choice.steady = axis;
        }
        if axis.separation > choice.least.separation {
            choice.least = axis;
        }
    }
    choice
}

/// Points that stay on the stack for hulls of ordinary size.
type Points = SmallVec<[Vec3; 64]>;

/// Index, separation and normal of the face furthest from all `points`.
fn best_face(
    normals: impl Iterator<Item = Vec3>,
    offsets: impl Iterator<Item = f32>,
    points: &[Vec3],
) -> (usize, f32, Vec3) {
    let columns = Columns::new(points);
    let mut best = (0, f32::NEG_INFINITY, Vec3::Z);
    for (f, (normal, offset)) in normals.zip(offsets).enumerate() {
        let separation = columns.least_along(normal) - offset;
        if separation > best.1 {
            best = (f, separation, normal);
        }
    }
    best
}

/// As many vectors as there are lanes, by coordinate.
#[derive(Clone, Copy, Default)]
struct Lanes([[f32; LANES]; 3]);

impl Lanes {
    #[inline]
    fn along(&self, d: Vec3) -> [f32; LANES] {
        let [x, y, z] = &self.0;
        std::array::from_fn(|l| x[l] * d.x + y[l] * d.y + z[l] * d.z)
    }

    fn set(&mut self, lane: usize, v: Vec3) {
        self.0[0][lane] = v.x;
        self.0[1][lane] = v.y;
        self.0[2][lane] = v.z;
    }
}

/// Edges of B in A's frame; empty lanes are zero and cross nothing.
#[derive(Clone, Copy, Default)]
struct EdgeBlock {
    left: Lanes,
    right: Lanes,
    along: Lanes,
}

impl EdgeBlock {
    /// Negative where the arc of A's edge, with the normals `l` and `r` of its faces and the direction `d`, crosses
    /// the mirrored arc of B: each arc has its ends on both sides of the other's plane, and they do so on the same
    /// hemisphere.
    #[inline]
    fn crossing(&self, l: Vec3, r: Vec3, d: Vec3) -> [f32; LANES] {
        let (left_of_b, right_of_b) = (self.left.along(d), self.right.along(d));
        let (left_of_a, right_of_a) = (self.along.along(l), self.along.along(r));
        let max = |x: f32, y: f32| if x > y { x } else { y };
        std::array::from_fn(|k| {
            let (across_b, across_a) = (left_of_b[k] * right_of_b[k], left_of_a[k] * right_of_a[k]);
            max(max(across_b, across_a), left_of_b[k] * right_of_a[k])
        })
    }
}

/// Points by coordinate, the last one repeated to fill the lanes.
struct Columns(SmallVec<[Lanes; 8]>);

impl Columns {
    fn new(points: &[Vec3]) -> Self {
        Columns(
            points
                .chunks(LANES)
                .map(|chunk| {
                    let mut lanes = Lanes::default();
                    (0..LANES).for_each(|l| lanes.set(l, chunk[l.min(chunk.len() - 1)]));
                    lanes
                })
                .collect(),
        )
    }

    fn least_along(&self, direction: Vec3) -> f32 {
        let mut least = [f32::INFINITY; LANES];
        for block in &self.0 {
            let along = block.along(direction);
            for l in 0..LANES {
                least[l] = if along[l] < least[l] { along[l] } else { least[l] };
            }
        }
        least.iter().fold(f32::INFINITY, |m, &x| if x < m { x } else { m })
    }
}

/// The pair of edges whose axis separates most, among those that may beat the separation `least`.
fn best_edges(a: &Poly, b: &Poly, b_in_a: &Isometry, placed: &[Vec3], least: f32) -> Option<Axis> {
    let reach = least.abs();
    let box_of_a = Aabb::from_points(a.vertices.iter().copied()).grown(reach);
    let box_of_b = Aabb::from_points(placed.iter().copied()).grown(reach);
    let ends = |vertices: &[Vec3], e: [u32; 2]| e.map(|v| vertices[v as usize]);
    let near = |[p, q]: [Vec3; 2], other: &Aabb| Aabb::new(p.min(q), p.max(q)).overlaps(other);

    let mut kept: SmallVec<[usize; 64]> = SmallVec::new();
    let mut blocks: SmallVec<[EdgeBlock; 6]> = SmallVec::new();
    for (j, e) in b.edges.iter().enumerate() {
        let [p, q] = ends(placed, e.vertices);
        if near([p, q], &box_of_a) {
            let lane = kept.len() % LANES;
            if lane == 0 {
                blocks.push(EdgeBlock::default());
            }
            let block = blocks.last_mut().expect("one was pushed for lane 0");
            block.left.set(lane, b_in_a.vector(b.normals[e.faces[0] as usize]));
            block.right.set(lane, b_in_a.vector(b.normals[e.faces[1] as usize]));
            block.along.set(lane, q - p);
            kept.push(j);
        }
    }

    let mut best: Option<Axis> = None;
    for (i, e) in a.edges.iter().enumerate() {
        let [p, q] = ends(a.vertices, e.vertices);
        if !near([p, q], &box_of_b) {
            continue;
        }
        let (l, r, d) = (a.normals[e.faces[0] as usize], a.normals[e.faces[1] as usize], q - p);
        for (first, block) in blocks.iter().enumerate() {
            let crossing = block.crossing(l, r, d);
            if crossing.iter().all(|&x| x >= 0.0) {
                continue;
            }
            for k in (0..LANES).filter(|&k| crossing[k] < 0.0) {
                let Some(&j) = kept.get(first * LANES + k) else { break };
                let second = ends(placed, b.edges[j].vertices);
                let Some((normal, separation)) = edge_axis([p, q], second, a.center) else { continue };
                if best.is_none_or(|b| separation > b.separation) {
                    best = Some(Axis { normal, separation, kind: Kind::Edges(i, j) });
                }
            }
        }
    }
    best
}

/// The common perpendicular of two edges that points away from `inside` of the first, and the way along it from
/// the first to the second. In double precision: the cross product of nearly parallel edges has few good digits.
///
/// Nothing for edges that do not cross, seen along it: the nearest points of the polyhedra are then elsewhere, and
/// a normal of this pair would have no point to go with it.
pub(crate) fn edge_axis(first: [Vec3; 2], second: [Vec3; 2], inside: Vec3) -> Option<(Vec3, f32)> {
    let [p, q] = first.map(|v| v.as_dvec3());
    let [s, t] = second.map(|v| v.as_dvec3());
    let cross = (q - p).cross(t - s);
    let squared = cross.length_squared();
    // Edges that are parallel to 0.1 mrad: a face axis is as good.
    if squared <= 1e-8 * (q - p).length_squared() * (t - s).length_squared() {
        return None;
    }
    let along_first = (t - s).cross(p - s).dot(cross) / squared;
    let along_second = (q - p).cross(p - s).dot(cross) / squared;
    let within = 0.0..=1.0;
    if !within.contains(&along_first) || !within.contains(&along_second) {
        return None;
    }
    let normal = cross / squared.sqrt();
    let outward = normal.dot(p - inside.as_dvec3());
    let normal = if outward < 0.0 { -normal } else { normal };
    Some((normal.as_vec3(), normal.dot(s - p) as f32))
}
