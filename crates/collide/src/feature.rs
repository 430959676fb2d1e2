//! Names of the pairs of features that make a contact point.
//!
//! | bits | face against face | other pairs |
//! |---|---|---|
//! | 31 | the reference face is B's | 0 |
//! | 16–30 | the two faces | the feature of A |
//! | 8–15 | edge before the point: an edge of the incident face, or (bit 7) a side of the reference face | [`PAIR`] |
//! | 0–7 | edge after the point, likewise | the feature of B |
//!
//! Numbers are cut to the bits that they have: names of very large hulls may coincide between manifolds, which
//! costs a warm start and nothing else.

/// Marks the pairs that do not come from clipping a face.
const PAIR: u32 = 0x7f << 8;

/// Set in the tag of an edge that a side of the reference face made.
pub(crate) const SIDE: u8 = 0x80;

/// The bits that all points of two faces share.
#[inline]
pub(crate) fn faces(reference_is_b: bool, reference: usize, incident: usize) -> u32 {
    let pair = (reference as u32).wrapping_mul(181).wrapping_add(incident as u32) & 0x7fff;
    u32::from(reference_is_b) << 31 | pair << 16
}

/// A point of two faces, by the tags of the edges before and after it.
#[inline]
pub(crate) fn corner(faces: u32, before: u8, after: u8) -> u32 {
    faces | u32::from(before) << 8 | u32::from(after)
}

/// The tag of edge `k` of the incident face.
#[inline]
pub(crate) fn edge_tag(k: usize) -> u8 {
    // 0x7f is kept for `PAIR`.
    (k % 0x7f) as u8
}

/// The tag of side `k` of the reference face.
#[inline]
pub(crate) fn side_tag(k: usize) -> u8 {
    SIDE | edge_tag(k)
}

/// A bit for each corner of two quadrilaterals, by the edge after it: no two corners of what is left of one within the other share
/// that. None for other pairs.
#[inline]
pub(crate) fn corner_bit(name: u32) -> u8 {
    let after = name as u8;
    let side = if after & SIDE != 0 { 4 } else { 0 };
    if name & PAIR == PAIR { 0 } else { 1 << ((after & 3) + side) }
}

/// Any other pair: corner or edge numbers of A and B.
#[inline]
pub(crate) fn pair(of_a: usize, of_b: usize) -> u32 {
    (of_a as u32 & 0x7fff) << 16 | PAIR | (of_b as u32 & 0xff)
}

/// A corner of A that lies in B.
pub(crate) fn corner_of_a(vertex: usize) -> u32 {
    pair(vertex, 0xfd)
}

/// A corner of B that lies in A.
pub(crate) fn corner_of_b(vertex: usize) -> u32 {
    pair(vertex, 0xfc)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_quadrilaterals_have_bits_of_their_own() {
        let tags = (0..4).map(edge_tag).chain((0..4).map(side_tag));
        let bits = tags.map(|after| corner_bit(corner(faces(true, 5, 3), edge_tag(2), after)));
        assert_eq!(bits.fold(0, |all, bit| if all & bit == 0 { all | bit } else { 0 }), 0xff);
        assert_eq!(corner_bit(pair(7, 9)), 0);
    }

    #[test]
    fn points_of_one_pair_of_boxes_have_different_names() {
        let mut seen = std::collections::BTreeSet::new();
        for flag in [false, true] {
            for reference in 0..6 {
                for incident in 0..6 {
                    let common = faces(flag, reference, incident);
                    let tags: Vec<u8> = (0..4).map(edge_tag).chain((0..4).map(side_tag)).collect();
                    for &before in &tags {
                        for &after in &tags {
                            assert!(seen.insert(corner(common, before, after)));
                        }
                    }
                }
            }
        }
        for a in 0..12 {
            for b in 0..12 {
                assert!(seen.insert(pair(a, b)));
            }
        }
    }
}
