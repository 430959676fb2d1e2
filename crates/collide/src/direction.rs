//! Directions in 32 bits, for the pair cache.
//!
//! The sphere is folded on an octahedron and that on a square (Meyer et al., "On floating-point normal vectors",
//! EGSR 2010). Two steps of 15 bits each and a mark that tells a direction from an empty cache: exact to a tenth of
//! a milliradian, which is plenty for a guess.

use rockfall_math::Vec3;

const STEPS: f32 = 32766.0;
const MARK: u32 = 1 << 31;

/// Packs a direction of any finite length, not zero.
pub(crate) fn pack(d: Vec3) -> u32 {
    let d = d / d.abs().element_sum();
    let (x, y) = if d.z < 0.0 {
        ((1.0 - d.y.abs()) * d.x.signum(), (1.0 - d.x.abs()) * d.y.signum())
    } else {
        (d.x, d.y)
    };
    let step = |v: f32| ((0.5 * v + 0.5) * STEPS + 0.5) as u32 & 0x7fff;
    MARK | step(x) << 15 | step(y)
}

/// The direction in a word, of unit length; nothing if the word holds none.
pub(crate) fn unpack(word: u32) -> Option<Vec3> {
    if word & MARK == 0 {
        return None;
    }
    let back = |steps: u32| 2.0 * ((steps & 0x7fff) as f32 / STEPS) - 1.0;
    let (x, y) = (back(word >> 15), back(word));
    let z = 1.0 - x.abs() - y.abs();
    let folded = if z < 0.0 {
        Vec3::new((1.0 - y.abs()) * x.signum(), (1.0 - x.abs()) * y.signum(), z)
    } else {
        Vec3::new(x, y, z)
    };
    Some(folded.normalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comes_back_within_a_tenth_of_a_milliradian() {
        for x in -5..=5 {
            for y in -5..=5 {
                for z in -5..=5 {
                    let d = Vec3::new(x as f32, y as f32, z as f32);
                    if d != Vec3::ZERO {
                        let back = unpack(pack(3.0 * d)).unwrap();
                        assert!((back - d.normalize()).length() < 1.5e-4, "{d} {back}");
                    }
                }
            }
        }
        assert_eq!(unpack(0), None);
    }
}
