//! Cuts the incident face of one polyhedron by the sides of the reference face of the other.
//!
//! Sutherland and Hodgman, "Reentrant polygon clipping", CACM 17, 1974. What remains of the incident face are the
//! contact points. Each corner carries the tags of the edges before and after it, which name it.

use crate::feature;
use rockfall_math::Vec3;
use smallvec::SmallVec;

/// A corner of the polygon that is being cut.
#[derive(Clone, Copy)]
pub(crate) struct Corner {
    pub(crate) position: Vec3,
    /// Tag of the edge before the corner.
    pub(crate) before: u8,
    /// Tag of the edge after it.
    pub(crate) after: u8,
}

/// A polygon; faces of ordinary hulls fit without an allocation.
pub(crate) type Polygon = SmallVec<[Corner; 24]>;

/// The sides of a face stand back by this share of the smaller body, so that the corners of two equal boxes, one on
/// the other, keep their names while they tremble.
pub(crate) const SLACK: f32 = 2e-3;

/// A face whose corners have the tags of its edges: edge k leaves corner k.
pub(crate) fn incident(corners: impl ExactSizeIterator<Item = Vec3>) -> Polygon {
    let n = corners.len();
    corners
        .enumerate()
        .map(|(k, position)| Corner {
            position,
            before: feature::edge_tag((k + n - 1) % n),
            after: feature::edge_tag(k),
        })
        .collect()
}

/// Cosine of the angle between two sides' directions outwards beyond which the corner between them is cut off: 120 degrees,
/// where that corner is sharper than 60 and, moved out, is twice `slack` away.
const SHARP: f32 = -0.5;

/// What is left of `polygon` between the sides of the face with the corners `reference` (counter-clockwise around
/// `normal`), each side moved out by `slack` metres and sharp corners by twice as much. The sides run along `along`, which is near to the normal or
/// its opposite: what is left meets the face when it moves that way.
pub(crate) fn clip(polygon: &mut Polygon, reference: &[Vec3], normal: Vec3, along: Vec3, slack: f32) {
    let shear = along / along.dot(normal);
    let n = reference.len();
    let mut from = reference[n - 1];
    let mut before = (from - reference[n - 2]).cross(normal).normalize_or_zero();
    // What was cut is written to the other of two polygons, in turns.
    let mut spare = Polygon::new();
    let (mut whole, mut left) = (&mut *polygon, &mut spare);
    let mut is_spare = false;
    let mut keep = |outward: Vec3, from: Vec3, slack: f32, tag: u8| {
        let outward = outward - outward.dot(shear) * normal;
        let height = |p: Vec3| outward.dot(p - from) - slack;
        if whole.iter().any(|c| height(c.position) > 0.0) {
            cut(whole, height, tag, left);
            std::mem::swap(&mut whole, &mut left);
            is_spare = !is_spare;
        }
    };
    for (k, &to) in reference.iter().enumerate() {
        let outward = (to - from).cross(normal);
        let length = outward.length();
        if length > 0.0 {
            let outward = outward / length;
            keep(outward, from, slack, feature::side_tag(k));
            if outward.dot(before) < SHARP {
                let middle = (outward + before).normalize_or_zero();
                keep(middle, from, 2.0 * slack, feature::side_tag(n + k));
            }
            before = outward;
        }
        from = to;
    }
    if is_spare {
        left.clear();
        left.extend_from_slice(whole);
    }
}

/// Writes the corners of negative height, and new ones where an edge crosses zero.
fn cut(polygon: &[Corner], height: impl Fn(Vec3) -> f32, side: u8, left: &mut Polygon) {
    left.clear();
    let Some(mut here) = polygon.last() else { return };
    let mut h0 = height(here.position);
    for next in polygon {
        let h1 = height(next.position);
        if (h0 <= 0.0) != (h1 <= 0.0) {
            let position = here.position + (next.position - here.position) * (h0 / (h0 - h1));
            let (before, after) = if h0 <= 0.0 { (here.after, side) } else { (side, here.after) };
            left.push(Corner { position, before, after });
        }
        if h1 <= 0.0 {
            left.push(*next);
        }
        (here, h0) = (next, h1);
    }
}

/// An end of what is left of a segment: where, and the tags of what cut it.
#[derive(Clone, Copy)]
pub(crate) struct End {
    pub(crate) t: f32,
    pub(crate) before: u8,
    pub(crate) after: u8,
}

/// What is left of a segment between the sides of a face with this normal, when it moves along `along`; each side, a
/// corner and the direction away from the face (not unit), stands back by `slack`.
pub(crate) fn segment(
    sides: impl Iterator<Item = (Vec3, Vec3)>,
    normal: Vec3,
    along: Vec3,
    core: [Vec3; 2],
    slack: f32,
) -> Option<[End; 2]> {
    let direction = core[1] - core[0];
    let shear = along / normal.dot(along);
    let mut low = End { t: 0.0, before: feature::edge_tag(0), after: 0 };
    let mut high = End { t: 1.0, before: feature::edge_tag(1), after: 1 };
    for (k, (corner, outward)) in sides.enumerate() {
        let stand_back = slack * outward.length();
        let outward = outward - outward.dot(shear) * normal;
        let height = outward.dot(core[0] - corner) - stand_back;
        let slope = outward.dot(direction);
        if slope > 0.0 && -height < slope * high.t {
            high = End { t: -height / slope, before: feature::side_tag(k), ..high };
        } else if slope < 0.0 && height > -slope * low.t {
            low = End { t: height / -slope, before: feature::side_tag(k), ..low };
        } else if slope == 0.0 && height > 0.0 {
            return None;
        }
    }
    (low.t <= high.t).then_some([low, high])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(half: f32, z: f32) -> [Vec3; 4] {
        [
            Vec3::new(-half, -half, z),
            Vec3::new(half, -half, z),
            Vec3::new(half, half, z),
            Vec3::new(-half, half, z),
        ]
    }

    fn left(corners: [Vec3; 4], reference: &[Vec3], along: Vec3, slack: f32) -> Polygon {
        let mut polygon = incident(corners.into_iter());
        clip(&mut polygon, reference, Vec3::Z, along, slack);
        polygon
    }

    #[test]
    fn a_large_face_is_cut_to_the_reference() {
        let left = left(square(5.0, 1.0), &square(1.0, 0.0), Vec3::Z, 0.0);
        assert_eq!(left.len(), 4);
        for corner in &left {
            assert!((corner.position.abs() - Vec3::ONE).length() < 1e-6);
            assert!(corner.before & feature::SIDE != 0 && corner.after & feature::SIDE != 0);
        }
    }

    #[test]
    fn a_small_face_stays_whole() {
        let left = left(square(0.5, 1.0), &square(1.0, 0.0), Vec3::Z, 0.0);
        assert_eq!(left.iter().map(|c| c.position).collect::<Vec<_>>(), square(0.5, 1.0));
        assert_eq!(left.iter().map(|c| c.after).collect::<Vec<_>>(), [0, 1, 2, 3]);
    }

    #[test]
    fn sides_follow_the_direction() {
        // Lifted by 1 and moved along x by 0.1, which is where the direction leads.
        let along = Vec3::new(0.1, 0.0, 1.0).normalize();
        let moved = square(1.0, 1.0).map(|p| p + 0.1 * Vec3::X);
        let left = left(moved, &square(1.0, 0.0), along, 1e-6);
        assert_eq!(left.iter().map(|c| c.position).collect::<Vec<_>>(), moved);
    }

    #[test]
    fn a_sharp_corner_does_not_reach_far() {
        // A splinter 10 m long and 2 mm wide at its end: moved out by 1 mm, its sides meet 10 m further on.
        let splinter = [Vec3::ZERO, Vec3::new(10.0, -1e-3, 0.0), Vec3::new(10.0, 1e-3, 0.0)];
        let left = left(square(50.0, 1.0), &splinter, Vec3::Z, 1e-3);
        assert!(left.iter().all(|c| c.position.x > -2.1e-3 && c.position.x < 10.01), "{}", left.len());
        assert!(left.len() >= 3);
    }

    #[test]
    fn a_face_beside_the_reference_is_gone() {
        let moved = square(0.5, 1.0).map(|p| p + 3.0 * Vec3::X);
        assert!(left(moved, &square(1.0, 0.0), Vec3::Z, 0.0).is_empty());
    }
}
