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

/// What is left of `polygon` between the sides of the face with the corners `reference` (counter-clockwise around
/// `normal`), each side moved out by `slack` metres. The sides run along `along`, which is near to the normal or
/// its opposite: what is left meets the face when it moves that way.
pub(crate) fn clip(
    mut polygon: Polygon,
    reference: &[Vec3],
    normal: Vec3,
    along: Vec3,
    slack: f32,
) -> Polygon {
    let shear = along / along.dot(normal);
    let mut from = reference[reference.len() - 1];
    let mut heights: SmallVec<[f32; 24]> = SmallVec::new();
    for (k, &to) in reference.iter().enumerate() {
        let outward = (to - from).cross(normal);
        let length = outward.length();
        if length > 0.0 {
            let outward = outward / length;
            let outward = outward - outward.dot(shear) * normal;
            heights.clear();
            heights.extend(polygon.iter().map(|c| outward.dot(c.position - from) - slack));
            if heights.iter().any(|&h| h > 0.0) {
                polygon = cut(&polygon, &heights, feature::side_tag(k));
            }
        }
        from = to;
    }
    polygon
}

/// The corners of negative height, and new ones where an edge crosses zero.
fn cut(polygon: &[Corner], heights: &[f32], side: u8) -> Polygon {
    let mut left = Polygon::new();
    for (i, here) in polygon.iter().enumerate() {
        let j = if i + 1 == polygon.len() { 0 } else { i + 1 };
        let (h0, h1) = (heights[i], heights[j]);
        if h0 <= 0.0 {
            left.push(*here);
        }
        if (h0 <= 0.0) != (h1 <= 0.0) {
            let position = here.position + (polygon[j].position - here.position) * (h0 / (h0 - h1));
            let (before, after) = if h0 <= 0.0 { (here.after, side) } else { (side, here.after) };
            left.push(Corner { position, before, after });
        }
    }
    left
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

    #[test]
    fn a_large_face_is_cut_to_the_reference() {
        let left = clip(incident(square(5.0, 1.0).into_iter()), &square(1.0, 0.0), Vec3::Z, Vec3::Z, 0.0);
        assert_eq!(left.len(), 4);
        for corner in &left {
            assert!((corner.position.abs() - Vec3::ONE).length() < 1e-6);
            assert!(corner.before & feature::SIDE != 0 && corner.after & feature::SIDE != 0);
        }
    }

    #[test]
    fn a_small_face_stays_whole() {
        let left = clip(incident(square(0.5, 1.0).into_iter()), &square(1.0, 0.0), Vec3::Z, Vec3::Z, 0.0);
        assert_eq!(left.iter().map(|c| c.position).collect::<Vec<_>>(), square(0.5, 1.0));
        assert_eq!(left.iter().map(|c| c.after).collect::<Vec<_>>(), [0, 1, 2, 3]);
    }

    #[test]
    fn sides_follow_the_direction() {
        // Lifted by 1 and moved along x by 0.1, which is where the direction leads.
        let along = Vec3::new(0.1, 0.0, 1.0).normalize();
        let moved = square(1.0, 1.0).map(|p| p + 0.1 * Vec3::X);
        let left = clip(incident(moved.into_iter()), &square(1.0, 0.0), Vec3::Z, along, 1e-6);
        assert_eq!(left.iter().map(|c| c.position).collect::<Vec<_>>(), moved);
    }

    #[test]
    fn a_face_beside_the_reference_is_gone() {
        let moved = square(0.5, 1.0).map(|p| p + 3.0 * Vec3::X);
        assert!(clip(incident(moved.into_iter()), &square(1.0, 0.0), Vec3::Z, Vec3::Z, 0.0).is_empty());
    }
}
