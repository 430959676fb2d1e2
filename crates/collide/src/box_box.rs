//! Two boxes, the pair that everything waits for.
//!
//! ```text
//!   cached axis ──apart──▶ nothing
//!        │
//!   15 axes ─────apart──▶ nothing            the first axis that separates is remembered
//!        │
//!   best face ──clip──▶ up to 8 points ──▶ 4
//!        │ an edge axis is clearly better, or the boxes are apart and
//!        │ their nearest points are not over the face
//!   edges, or the general way of two polyhedra
//! ```
//!
//! The fifteen axes are the three face normals of A, of B, and the nine cross products of their edges (Gottschalk,
//! Lin and Manocha, "OBBTree", SIGGRAPH 1996); the gaps along them are measured in `gaps`, of many pairs side by side.
//!
//! What touched in the last step goes on with its axis and, of a face, with its corners while others are no better: a box between two
//! faces that takes turns with the corners which hold it is kept rocking by that.
//!
//! The largest separation is a lower bound of the distance. While the boxes are apart it is the distance itself if
//! the point that it leads to lies over the face, which is checked; else the nearest points are searched for.

pub(crate) mod gaps;

use crate::clip::SLACK;
use crate::closest::Closest;
use crate::feature;
use crate::gjk::{self, Proximity};
use crate::poly::BoxPoly;
use crate::polyhedra::{self, Grip};
use crate::reduce::reduce_polygon;
use crate::sat::preference;
use crate::segments;
use crate::{Cache, ContactPoint, Manifold};
use gaps::{Gaps, NEXT, Pair};
use rockfall_math::{Isometry, Vec3};

/// The axis of the last manifold stays while no other separates by more than this share of the [`preference`] of the largest half extent
/// more: of plates the thickness says nothing about how their faces lean.
const HOLD: f32 = 0.3;

/// Appends the manifold of two boxes, given by their half extents, if they come within `margin`. Returns how far apart they
/// are at least, or 0.
pub(crate) fn collide(
    a: Vec3,
    b: Vec3,
    b_in_a: &Isometry,
    margin: f32,
    cache: &mut Cache,
    out: &mut Vec<Manifold>,
) -> f32 {
    let pair = Pair::new(a, b, b_in_a);
    match apart(&pair, margin, *cache) {
        Some(apart) => apart,
        None => collide_with(&gaps::gaps(&pair), &pair, b_in_a, margin, cache, out),
    }
}

/// How far apart two boxes are along the axis that parted them last, if that is beyond the margin.
#[inline]
pub(crate) fn apart(pair: &Pair<f32>, margin: f32, cache: Cache) -> Option<f32> {
    let gap = pair.gap((), Last::of(cache).axis?);
    (gap > margin).then_some(gap)
}

/// As [`collide`], of boxes whose gaps are known.
pub(crate) fn collide_with(
    separations: &Gaps,
    pair: &Pair<f32>,
    b_in_a: &Isometry,
    margin: f32,
    cache: &mut Cache,
    out: &mut Vec<Manifold>,
) -> f32 {
    let last = Last::of(*cache);
    let best = |from: usize, to: usize| {
        (from + 1..to).fold(from, |m, k| if separations[k] > separations[m] { k } else { m })
    };
    let (face_a, face_b, edge) = (best(0, 3), best(3, 6), best(6, 15));
    let (of_a, of_b, of_edge) = (separations[face_a], separations[face_b], separations[edge]);
    let apart = of_a.max(of_b).max(of_edge);
    if apart > margin {
        let axis = [face_a, face_b, edge].into_iter().find(|&k| separations[k] == apart);
        *cache = Last { axis, grip: Grip::default() }.cache();
        return apart;
    }
    let boxes = Boxes::new(pair, b_in_a);
    let (a, b) = (Vec3::from_array(pair.a), Vec3::from_array(pair.b));
    let smaller = a.min_element().min(b.min_element());
    // That of the last manifold, unless another one is clearly better.
    let again = last.axis.filter(|&axis| {
        let hold = HOLD * preference(a.max_element().min(b.max_element()), separations[axis]);
        last.grip.corners != 0 && apart <= separations[axis] + hold
    });
    let face = match again {
        Some(axis) if axis < 6 => axis,
        _ if of_b > of_a + preference(smaller, of_a) => face_b,
        _ => face_a,
    };
    let of_face = separations[face];
    let grip_on = |face: usize| {
        let same = last.axis == Some(face) && last.grip.on_b == (face >= 3);
        Grip { on_b: face >= 3, corners: if same { last.grip.corners } else { 0 } }
    };
    let slack = SLACK * smaller;

    let (axis, grip, manifold) = 'found: {
        if apart <= 0.0 {
            let crossed = again.is_some_and(|axis| axis >= 6);
            if !crossed && of_edge <= of_face + preference(smaller, of_face) {
                let mut grip = grip_on(face);
                let manifold = boxes.over_face(face, slack, margin, of_face, &mut grip);
                // The preferred face must have points to show for it.
                if manifold.deepest() <= of_face + preference(smaller, of_face) || apart == of_face {
                    break 'found (face, grip, manifold);
                }
            }
            if crossed || apart == of_edge {
                let axis = again.filter(|&axis| axis >= 6).unwrap_or(edge);
                let mut grip = if last.axis == Some(axis) { last.grip } else { Grip::default() };
                let (box_a, box_b) = (BoxPoly::new(a), BoxPoly::new(b));
                let (crossing, _) = boxes.crossing(axis, separations[axis]);
                let manifold =
                    polyhedra::around(&box_a.poly(), &box_b.poly(), b_in_a, margin, &crossing, &mut grip);
                break 'found (axis, grip, manifold);
            }
            let face = if apart == of_a { face_a } else { face_b };
            let mut grip = grip_on(face);
            let manifold = boxes.over_face(face, slack, margin, apart, &mut grip);
            break 'found (face, grip, manifold);
        }
        // `apart` is a lower bound of the distance and a point over a face an upper one. Half a micrometre per metre of
        // size between them counts as none.
        let same = 5e-7 * (a.max_element() + b.max_element() + b_in_a.translation.abs().max_element());
        for face in [face, if face < 3 { face_b } else { face_a }] {
            if apart - separations[face] <= preference(smaller, 0.0).max(same)
                && boxes.reaches(face, apart + same)
            {
                let mut grip = grip_on(face);
                let manifold = boxes.over_face(face, slack, margin, apart, &mut grip);
                break 'found (face, grip, manifold);
            }
        }
        let (box_a, box_b) = (BoxPoly::new(a), BoxPoly::new(b));
        let (poly_a, poly_b) = (box_a.poly(), box_b.poly());
        let mut grip = last.grip;
        if apart - of_edge <= same {
            let (closest, cross) = boxes.crossing(edge, apart);
            if cross {
                let manifold = polyhedra::around(&poly_a, &poly_b, b_in_a, margin, &closest, &mut grip);
                break 'found (face, grip, manifold);
            }
        }
        match gjk::proximity(poly_a.vertices, poly_b.vertices, b_in_a, boxes.towards(face), margin) {
            Proximity::Apart(closest) => {
                let manifold = polyhedra::around(&poly_a, &poly_b, b_in_a, margin, &closest, &mut grip);
                (face, grip, manifold)
            }
            Proximity::Beyond(_) => {
                *cache = Last { axis: Some(face), grip: Grip::default() }.cache();
                return margin;
            }
            // Apart by less than rounding.
            Proximity::Overlap => {
                let mut grip = grip_on(face);
                let manifold = boxes.over_face(face, slack, margin, of_face, &mut grip);
                (face, grip, manifold)
            }
        }
    };
    *cache = Last { axis: Some(axis), grip }.cache();
    out.push(manifold);
    0.0
}

/// What the last step found: the axis, and of a manifold what it was made of.
///
/// | bits | in the cache |
/// |---|---|
/// | 0–3 | axis + 1 |
/// | 4–11 | corners that were kept |
/// | 12 | the reference face was B's |
#[derive(Clone, Copy, Debug, PartialEq)]
struct Last {
    axis: Option<usize>,
    grip: Grip,
}

impl Last {
    fn of(Cache { word, .. }: Cache) -> Self {
        let axis = (word & 0xf) as usize;
        let grip = Grip { on_b: word >> 12 & 1 == 1, corners: (word >> 4) as u8 };
        Last { axis: (1..=15).contains(&axis).then(|| axis - 1), grip }
    }

    fn cache(self) -> Cache {
        let axis = self.axis.map_or(0, |axis| axis as u32 + 1);
        let word = axis | u32::from(self.grip.corners) << 4 | u32::from(self.grip.on_b) << 12;
        Cache { word, ..Cache::default() }
    }
}

/// Both boxes in the frame of A.
struct Boxes {
    a: [f32; 3],
    b: [f32; 3],
    /// `r[i][j]`: coordinate i of axis j of B.
    r: [[f32; 3]; 3],
    t: [f32; 3],
    axes_of_b: [Vec3; 3],
}

impl Boxes {
    fn new(&Pair { a, b, r, t }: &Pair<f32>, b_in_a: &Isometry) -> Self {
        let axes_of_b = [b_in_a.rotation.x_axis, b_in_a.rotation.y_axis, b_in_a.rotation.z_axis];
        Boxes { a, b, r, t, axes_of_b }
    }

    /// The normal of face `k` (0–5) that looks from A to B.
    fn towards(&self, k: usize) -> Vec3 {
        let axis = if k < 3 { Vec3::AXES[k] } else { self.axes_of_b[k - 3] };
        if axis.dot(Vec3::from_array(self.t)) < 0.0 { -axis } else { axis }
    }

    /// The incident face seen from reference face `k` (0–5), in the coordinates of that face.
    fn facing(&self, k: usize) -> Facing {
        let reference_is_b = k >= 3;
        let axis = k % 3;
        let t = Vec3::from_array(self.t);
        // The frame of the reference box: axes, own half extents, and the other box's centre, axes, half extents.
        let along: [Vec3; 3] = if reference_is_b { self.axes_of_b } else { [Vec3::X, Vec3::Y, Vec3::Z] };
        let (own, other) = if reference_is_b { (self.b, self.a) } else { (self.a, self.b) };
        let centre = if reference_is_b { -t } else { t };
        let seen = |i: usize, j: usize| if reference_is_b { self.r[j][i] } else { self.r[i][j] };

        let height = along[axis].dot(centre);
        let sign = if height < 0.0 { -1.0 } else { 1.0 };
        // The face of the other box that looks back the most.
        let mut m = 0;
        for j in 1..3 {
            if seen(axis, j).abs() > seen(axis, m).abs() {
                m = j;
            }
        }
        let towards = if sign * seen(axis, m) > 0.0 { -1.0 } else { 1.0 };
        let [x, y] = NEXT[axis];
        let [u, v] = NEXT[m];
        let local = |j: usize, scale: f32| {
            Vec3::new(scale * seen(x, j), scale * seen(y, j), scale * sign * seen(axis, j))
        };
        let origin = Vec3::new(along[x].dot(centre), along[y].dot(centre), sign * height - own[axis]);
        Facing {
            centre: origin + local(m, towards * other[m]),
            u: local(u, other[u]),
            v: local(v, other[v]),
            half: [own[x], own[y]],
            frame: [along[x], along[y], sign * along[axis]],
            plane: own[axis],
            reference_is_b,
            names: feature::faces(
                reference_is_b,
                2 * axis + usize::from(sign > 0.0),
                2 * m + usize::from(towards > 0.0),
            ),
        }
    }

    /// Whether a point of the incident face lies over reference face `k`, no higher than `limit`.
    fn reaches(&self, k: usize, limit: f32) -> bool {
        self.facing(k).clip(0.0).points().iter().any(|c| c.position.z <= limit)
    }

    /// The manifold of reference face `k`, its sides moved out by `slack`; no point is nearer than `least`.
    fn over_face(&self, k: usize, slack: f32, margin: f32, least: f32, grip: &mut Grip) -> Manifold {
        let facing = self.facing(k);
        let polygon = facing.clip(slack);
        let normal = if facing.reference_is_b { -facing.frame[2] } else { facing.frame[2] };
        let mut points = [ContactPoint::default(); 8];
        let mut count = 0;
        let point = |corner: &Corner, distance: f32| {
            // Half-way back to the reference plane.
            let p = corner.position;
            let z = facing.plane + p.z - 0.5 * distance;
            let own = facing.frame[0] * p.x + facing.frame[1] * p.y + facing.frame[2] * z;
            let position = if facing.reference_is_b { own + Vec3::from_array(self.t) } else { own };
            ContactPoint {
                position,
                distance,
                feature: feature::corner(facing.names, corner.before, corner.after),
            }
        };
        for corner in polygon.points() {
            let distance = if corner.position.z > least { corner.position.z } else { least };
            if distance <= margin {
                points[count] = point(corner, distance);
                count += 1;
            }
        }
        if count == 0 {
            // Rounding took the whole face: its lowest corner remains.
            let corners = facing.corners();
            let lowest =
                corners.iter().fold(&corners[0], |m, c| if c.position.z < m.position.z { c } else { m });
            points[0] = point(lowest, least);
            count = 1;
        }
        reduce_polygon(normal, &points[..count], &mut grip.corners)
    }

    /// The nearest points of the edges of axis `k` (6–14), and whether the edges cross, seen along it.
    fn crossing(&self, k: usize, separation: f32) -> (Closest, bool) {
        let (i, j) = ((k - 6) / 3, (k - 6) % 3);
        let t = Vec3::from_array(self.t);
        let axis = Vec3::AXES[i].cross(self.axes_of_b[j]).normalize();
        let normal = if axis.dot(t) < 0.0 { -axis } else { axis };
        // The edge of A furthest along the normal, and the edge of B furthest against it.
        let (mut on_a, mut on_b) = (Vec3::ZERO, t);
        let (mut name_a, mut name_b) = (4 * i, 4 * j);
        for (bit, &m) in NEXT[i].iter().enumerate() {
            let positive = normal[m] > 0.0;
            on_a[m] = if positive { self.a[m] } else { -self.a[m] };
            name_a += usize::from(positive) << bit;
        }
        for (bit, &m) in NEXT[j].iter().enumerate() {
            let positive = normal.dot(self.axes_of_b[m]) < 0.0;
            on_b += if positive { self.b[m] } else { -self.b[m] } * self.axes_of_b[m];
            name_b += usize::from(positive) << bit;
        }
        let reach_a = self.a[i] * Vec3::AXES[i];
        let reach_b = self.b[j] * self.axes_of_b[j];
        let nearest = segments::nearest([on_a - reach_a, on_a + reach_a], [on_b - reach_b, on_b + reach_b]);
        let (on_a, on_b) = nearest.points();
        let cross = [nearest.s, nearest.t].iter().all(|&x| 0.0 < x && x < 1.0);
        let feature = feature::pair(name_a, name_b);
        (Closest { distance: separation, normal, on_a, on_b, feature }, cross)
    }
}

/// The incident face in the frame of the reference face: x and y along its sides, z out of it, zero at its plane.
struct Facing {
    centre: Vec3,
    u: Vec3,
    v: Vec3,
    half: [f32; 2],
    /// The three axes in the frame of A (directions only; for a reference on B the origin is B's centre).
    frame: [Vec3; 3],
    /// Height of the face above the centre of its box.
    plane: f32,
    reference_is_b: bool,
    names: u32,
}

#[derive(Clone, Copy, Default)]
struct Corner {
    position: Vec3,
    before: u8,
    after: u8,
}

/// A quadrilateral, cut by four sides: eight corners at most.
struct Polygon {
    corners: [Corner; 8],
    count: usize,
}

impl Polygon {
    fn points(&self) -> &[Corner] {
        &self.corners[..self.count]
    }

    fn push(&mut self, corner: Corner) {
        // Each side of a convex cut adds one corner; rounding can't add more than the array holds without this.
        if self.count < self.corners.len() {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }
}

impl Facing {
    fn corners(&self) -> [Corner; 4] {
        let Facing { centre, u, v, .. } = *self;
        let at = [centre - u - v, centre + u - v, centre + u + v, centre - u + v];
        std::array::from_fn(|k| Corner {
            position: at[k],
            before: feature::edge_tag((k + 3) % 4),
            after: feature::edge_tag(k),
        })
    }

    /// The incident face between the sides of the reference face, each moved out by `slack`.
    fn clip(&self, slack: f32) -> Polygon {
        let mut polygon = Polygon { corners: [Corner::default(); 8], count: 4 };
        polygon.corners[..4].copy_from_slice(&self.corners());
        for axis in 0..2 {
            let reach = self.half[axis] + slack;
            // Whether the face sticks out at all on this axis.
            let extent = self.u[axis].abs() + self.v[axis].abs();
            for (side, sign) in [(2 * axis, -1.0), (2 * axis + 1, 1.0)] {
                if sign * self.centre[axis] + extent > reach {
                    polygon = cut(&polygon, axis, sign, reach, feature::side_tag(side));
                }
            }
        }
        polygon
    }
}

/// What is left where `sign * position[axis] <= reach`.
fn cut(polygon: &Polygon, axis: usize, sign: f32, reach: f32, side: u8) -> Polygon {
    let mut left = Polygon { corners: [Corner::default(); 8], count: 0 };
    let n = polygon.count;
    for (i, here) in polygon.points().iter().enumerate() {
        let next = &polygon.corners[if i + 1 == n { 0 } else { i + 1 }];
        let h0 = sign * here.position[axis] - reach;
        let h1 = sign * next.position[axis] - reach;
        if h0 <= 0.0 {
            left.push(*here);
        }
        if (h0 <= 0.0) != (h1 <= 0.0) {
            let mut position = here.position + (next.position - here.position) * (h0 / (h0 - h1));
            position[axis] = sign * reach;
            let (before, after) = if h0 <= 0.0 { (here.after, side) } else { (side, here.after) };
            left.push(Corner { position, before, after });
        }
    }
    left
}
