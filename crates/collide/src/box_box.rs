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
//!   edges, or the walk of two polyhedra, and what lies over a face that looks their way
//! ```
//!
//! The fifteen axes are the three face normals of A, of B, and the nine cross products of their edges (Gottschalk,
//! Lin and Manocha, "OBBTree", SIGGRAPH 1996); the gaps along them are measured in `gaps`, of many pairs side by side; what lies over a face is found in `facing`.
//!
//! What touched in the last step goes on with its axis and, of a face, with its corners while others are no better: a box between two
//! faces that takes turns with the corners which hold it is kept rocking by that.
//!
//! The largest separation is a lower bound of the distance. While the boxes are apart it is the distance itself if
//! the point that it leads to lies over the face, which is checked; else the nearest points are searched for.

mod facing;
pub(crate) mod gaps;

use crate::clip::SLACK;
use crate::closest::Closest;
use crate::feature;
use crate::gjk::{self, Proximity};
use crate::poly::box_corners;
use crate::polyhedra::FACE_COSINE;
use crate::sat::preference;
use crate::segments;
use crate::{Cache, Manifold};
use facing::Facing;
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
                let (crossing, _) = boxes.crossing(axis, separations[axis]);
                let manifold = boxes.around(&crossing, slack, margin, &mut grip);
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
        let mut grip = last.grip;
        if apart - of_edge <= same {
            let (closest, cross) = boxes.crossing(edge, apart);
            if cross {
                let manifold = boxes.around(&closest, slack, margin, &mut grip);
                break 'found (face, grip, manifold);
            }
        }
        match gjk::proximity(&box_corners(a), &box_corners(b), b_in_a, boxes.towards(face), margin) {
            Proximity::Apart(closest) => {
                let manifold = boxes.around(&closest, slack, margin, &mut grip);
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

/// What a manifold of two boxes was made of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Grip {
    /// Whether the reference face was B's.
    on_b: bool,
    /// Bits of the corners that were kept, see [`feature::corner_bit`]; 0 where there was none.
    corners: u8,
}

/// How a contact is seen.
struct Seen {
    /// Unit vector from A to B.
    normal: Vec3,
    /// Signed distance of the boxes along it, metres.
    distance: f32,
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

    /// The incident face seen from reference face `k` (0–5).
    fn over(&self, k: usize) -> Facing {
        let (reference_is_b, axis) = (k >= 3, k % 3);
        let seen = |j: usize| if reference_is_b { self.r[j][axis] } else { self.r[axis][j] };
        let t = Vec3::from_array(self.t);
        let height = if reference_is_b { -self.axes_of_b[axis].dot(t) } else { t[axis] };
        let sign = if height < 0.0 { -1.0 } else { 1.0 };
        // The face of the other box that looks back the most.
        let m = largest([seen(0), seen(1), seen(2)]);
        let towards = if sign * seen(m) > 0.0 { -1.0 } else { 1.0 };
        self.facing(reference_is_b, (axis, sign), (m, towards), sign * Vec3::AXES[axis])
    }

    /// Whether a point of the incident face lies over reference face `k`, no higher than `limit`.
    fn reaches(&self, k: usize, limit: f32) -> bool {
        self.over(k).clip(0.0).reach(limit)
    }

    /// The manifold of reference face `k`, its sides moved out by `slack`; no point is nearer than `least`.
    fn over_face(&self, k: usize, slack: f32, margin: f32, least: f32, grip: &mut Grip) -> Manifold {
        let facing = self.over(k);
        let seen = Seen { normal: facing.normal(), distance: least };
        facing.manifold(seen, slack, margin, None, grip)
    }

    /// The manifold around the nearest points: these, and where a face looks along the normal, what lies over that face. Of faces and corners
    /// that are as good as each other, those of the last `grip`, which becomes that of this manifold.
    fn around(&self, closest: &Closest, slack: f32, margin: f32, grip: &mut Grip) -> Manifold {
        let normal = closest.normal;
        let back = self.axes_of_b.map(|axis| -axis.dot(normal));
        let (i, j) = (largest(normal.to_array()), largest(back));
        let (of_a, of_b) = (normal[i], back[j]);
        if of_a.abs().max(of_b.abs()) < FACE_COSINE {
            *grip = Grip::default();
            return closest.manifold();
        }
        // A's face unless B's is nearer by more than two degrees at a right contact, or the last one: the choice must not flicker.
        let same = if grip.on_b && grip.corners != 0 { -1e-3 } else { 1e-3 };
        let on_b = of_b.abs() > of_a.abs() + same;
        if grip.on_b != on_b {
            *grip = Grip { on_b, corners: 0 };
        }
        let (face_of_a, face_of_b) = ((i, 1.0_f32.copysign(of_a)), (j, 1.0_f32.copysign(of_b)));
        let facing = if on_b {
            self.facing(true, face_of_b, face_of_a, Vec3::from_array(back))
        } else {
            self.facing(false, face_of_a, face_of_b, normal)
        };
        // Distances of these boxes that differ by less are equal.
        let rounding =
            2e-7 * [self.a, self.b, self.t].map(|v| Vec3::from_array(v).length()).iter().sum::<f32>();
        let nearest = Some((closest.point(), closest.distance + rounding));
        facing.manifold(Seen { normal, distance: closest.distance }, slack, margin, nearest, grip)
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

/// The first component that is largest without its sign.
fn largest(v: [f32; 3]) -> usize {
    (1..3).fold(0, |m, k| if v[k].abs() > v[m].abs() { k } else { m })
}
