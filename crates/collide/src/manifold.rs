//! What a pair of shapes has to say about its contact.

use rockfall_math::{Isometry, Vec3, hash};

/// Up to four points that share a normal, in the frame of shape A.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Manifold {
    /// Unit vector from A to B.
    pub normal: Vec3,
    /// The first `count` are set.
    pub points: [ContactPoint; 4],
    /// 1 to 4.
    pub count: u32,
}

/// One point of a [`Manifold`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ContactPoint {
    /// Half-way between the two surfaces, metres.
    pub position: Vec3,
    /// Signed distance of the two surfaces along the normal, metres; negative where they overlap.
    pub distance: f32,
    /// Names the features (corner, edge, face) that made the point; stays the same under small motions.
    pub feature: u32,
}

/// What a pair function remembers from one step to the next: a guess that makes it faster; of two boxes, also as parts of compounds, which face and corners
/// made the last manifold; of fields and meshes, and of boxes and hulls that overlap deeply, which points were kept. Those make the next one too while others are no better, so that a contact at rest does not change its mind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cache {
    /// Opaque to everyone but the pair function that wrote it.
    pub word: u32,
    /// Of compounds, fields and meshes, and of boxes and hulls that overlap deeply: digests of the names of the points that were kept, a byte each.
    pub kept: u32,
}

/// A byte of a point's name, not 0.
pub(crate) fn digest(name: u32) -> u8 {
    ((hash::mix(u64::from(name)) >> 56) as u8).max(1)
}

/// Whether a name is among some of which there are digests, as [`Manifold::digests`] has them.
pub(crate) fn is_among(digests: u32, name: u32) -> bool {
    digests.to_le_bytes().contains(&digest(name))
}

impl Manifold {
    /// Digests of the names of the points, a byte each, 0 for none.
    pub(crate) fn digests(&self) -> u32 {
        let mut digests = [0; 4];
        digests.iter_mut().zip(self.points()).for_each(|(to, p)| *to = digest(p.feature));
        u32::from_le_bytes(digests)
    }

    /// The points that are set.
    pub fn points(&self) -> &[ContactPoint] {
        &self.points[..self.count as usize]
    }

    /// The smallest signed distance of the points.
    pub fn deepest(&self) -> f32 {
        self.points().iter().fold(f32::INFINITY, |d, p| d.min(p.distance))
    }

    /// The same for shapes with skins of these thicknesses around them, metres.
    pub(crate) fn grow(&mut self, of_a: f32, of_b: f32) {
        for p in &mut self.points[..self.count as usize] {
            p.distance -= of_a + of_b;
            p.position += 0.5 * (of_a - of_b) * self.normal;
        }
    }

    /// Seen from the frame of the other shape, which becomes A; `b_in_a` places the frame of this one in that.
    pub(crate) fn swap(&mut self, b_in_a: &Isometry) {
        self.normal = -b_in_a.vector(self.normal);
        for p in &mut self.points[..self.count as usize] {
            p.position = b_in_a.point(p.position);
        }
    }
}
