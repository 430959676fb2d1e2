//! Which corners and edges of two surfaces are near each other.

use crate::surface::Surface;
use rockfall_math::{Aabb, Isometry, Mat3, Vec3};
use rockfall_shape::EdgeKind;
use smallvec::SmallVec;

/// A corner: its name, and a triangle that has it, with its place there.
pub(super) type Corner = (u64, u64, usize);

/// An edge at which the surface bends away or ends: the names of its ends, the lower one first, and a triangle that has it, with its place there.
pub(super) type Edge = ([u64; 2], u64, usize);

/// Corners at sharp edges, and sharp edges: a corner with no edge that bends away, and an edge that does not, touch nobody, since the surface around them sticks out as far.
#[derive(Debug, Default)]
pub(super) struct Features {
    /// Of both surfaces, by name.
    pub(super) corners: [Vec<Corner>; 2],
    pub(super) edges: [Vec<Edge>; 2],
    /// Places in `edges` of those of triangles that are near each other.
    pub(super) crossings: Vec<(u32, u32)>,
    any: bool,
}

impl Features {
    /// Of triangles whose boxes, in the frame of the first surface, come within `reach` of each other. `bounds` are those of each in its own frame.
    pub(super) fn near<A: Surface, B: Surface>(
        a: &A,
        b: &B,
        bounds: [Aabb; 2],
        b_in_a: &Isometry,
        reach: f32,
    ) -> Self {
        let mut pairs: Vec<(u64, u64)> = Vec::new();
        let around = seen(&bounds[0], &b_in_a.inverse()).grown(reach);
        let meets = |one: &Aabb, two: &Aabb| one.min.cmple(two.max).all() && two.min.cmple(one.max).all();
        if meets(&around, &bounds[1]) {
            let mut of_b = Vec::new();
            b.near(&around, |triangle| of_b.push(triangle));
            for triangle in of_b {
                let corners = b.corners(triangle).map(|c| b_in_a.point(c));
                let area = Aabb::from_points(corners).grown(reach);
                a.near(&area, |other| {
                    if meets(&Aabb::from_points(a.corners(other)), &area) {
                        pairs.push((other, triangle));
                    }
                });
            }
        }
        // A height field may name a triangle twice.
        pairs.sort_unstable();
        pairs.dedup();
        let mut features = Features { any: !pairs.is_empty(), ..Features::default() };
        let (mut of_a, mut of_b): (Vec<u64>, Vec<u64>) = pairs.iter().copied().unzip();
        features.collect(0, a, &mut of_a);
        features.collect(1, b, &mut of_b);
        for &(one, two) in &pairs {
            let [ones, twos] = [features.edges_of(0, a, one), features.edges_of(1, b, two)];
            for one in ones {
                features.crossings.extend(twos.iter().map(|&two| (one, two)));
            }
        }
        features.crossings.sort_unstable();
        features.crossings.dedup();
        features
    }

    /// Whether no triangles are near each other.
    pub(super) fn is_empty(&self) -> bool {
        !self.any
    }

    /// Notes the features of some triangles of one surface.
    fn collect<S: Surface>(&mut self, side: usize, surface: &S, triangles: &mut Vec<u64>) {
        triangles.sort_unstable();
        triangles.dedup();
        for &triangle in &*triangles {
            let ids = surface.ids(triangle);
            for edge in sharp(surface, triangle) {
                let ends = [edge, (edge + 1) % 3];
                self.corners[side].extend(ends.map(|k| (ids[k], triangle, k)));
                self.edges[side].push((ends_of(ids, edge), triangle, edge));
            }
        }
        self.corners[side].sort_unstable();
        self.corners[side].dedup_by_key(|corner| corner.0);
        self.edges[side].sort_unstable();
        self.edges[side].dedup_by_key(|edge| edge.0);
    }

    /// Places of a triangle's sharp edges among all.
    fn edges_of<S: Surface>(&self, side: usize, surface: &S, triangle: u64) -> SmallVec<[u32; 3]> {
        let ids = surface.ids(triangle);
        let place = |edge: usize| self.edges[side].binary_search_by_key(&ends_of(ids, edge), |edge| edge.0);
        sharp(surface, triangle).filter_map(|edge| place(edge).ok().map(|i| i as u32)).collect()
    }
}

/// Corners at sharp edges of triangles that may touch `area`, by name.
pub(super) fn sharp_corners<S: Surface>(surface: &S, area: &Aabb) -> Vec<Corner> {
    let mut triangles = Vec::new();
    surface.near(area, |triangle| triangles.push(triangle));
    let mut features = Features::default();
    features.collect(0, surface, &mut triangles);
    std::mem::take(&mut features.corners[0])
}

/// Edges of a triangle at which the surface bends away or ends.
fn sharp<S: Surface>(surface: &S, triangle: u64) -> impl Iterator<Item = usize> {
    let (corners, normal) = (surface.corners(triangle), surface.normal(triangle));
    let kinds = [0, 1, 2].map(|edge| surface.beyond(triangle, edge, &corners, normal).0);
    (0..3).filter(move |&edge| matches!(kinds[edge], EdgeKind::Convex | EdgeKind::Boundary))
}

fn ends_of(ids: [u64; 3], edge: usize) -> [u64; 2] {
    let [a, b] = [ids[edge], ids[(edge + 1) % 3]];
    [a.min(b), a.max(b)]
}

/// The box around a box, seen from where `place` puts its frame, rounded outwards.
fn seen(bounds: &Aabb, place: &Isometry) -> Aabb {
    let r = &place.rotation;
    let reach = Mat3::from_cols(r.x_axis.abs(), r.y_axis.abs(), r.z_axis.abs());
    let (center, half) = (place.point(bounds.center()), reach * bounds.half_extents());
    let slack = 1e-6 * (half + center.abs() + Vec3::splat(bounds.center().abs().max_element()));
    Aabb::new(center - half - slack, center + half + slack)
}
