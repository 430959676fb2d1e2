//! Which points of a pair go on being its points.
//!
//! What flows in: all contacts of a pair, the manifolds that a choice among all of them makes, and those that the points of the last step make. What flows out: which.
//!
//! Each point is a spring to the solver. A choice that is made anew in every step takes one point or its neighbour, three or four in one place, as rounding and the last tremor have it; each time other springs push, with other
//! depths, and bodies that could lie still are kept trembling by it.

use super::cluster::EQUAL;
use super::few::MOST;
use super::gather::Contact;
use crate::manifold::digest;
use crate::{Cache, Manifold};

/// What was kept may hide so much of the depth, as a share of it.
const HIDDEN: f32 = 0.1;

/// What touches may be so many times as far from what was kept as from what would be chosen.
const LOOSE: f32 = 1.5;

/// Whether the points of `kept` hold a body as well as those of `fresh`, which were chosen anew from `contacts`: they are nearly as deep, and nothing that touches is much further from all of them.
pub(super) fn serves(contacts: &[Contact], kept: &[Manifold], fresh: &[Manifold]) -> bool {
    let touching = || contacts.iter().filter(|contact| contact.distance <= 0.0);
    let Some(from) = touching().next() else { return false };
    let span = touching().fold(0.0_f32, |span, c| span.max(c.position.distance(from.position)));
    let deepest = touching().fold(0.0_f32, |least, c| least.min(c.distance));
    let shown = kept.iter().map(Manifold::deepest).fold(f32::INFINITY, f32::min);
    if shown > deepest + (EQUAL * span).max(HIDDEN * -deepest) {
        return false;
    }
    let apart = |one: &Contact, two: &Contact| {
        one.position.distance_squared(two.position) + span * span * one.normal.distance_squared(two.normal)
    };
    // How far what touches is from a choice, at most, squared.
    let gap = |choice: &[Manifold]| {
        let is_in = |c: &&Contact| choice.iter().any(|m| m.points().iter().any(|p| p.feature == c.name));
        let chosen: Vec<&Contact> = contacts.iter().filter(is_in).collect();
        let near = |c: &Contact| chosen.iter().fold(f32::INFINITY, |near, other| near.min(apart(c, other)));
        touching().fold(0.0_f32, |gap, c| gap.max(near(c)))
    };
    gap(kept) <= (LOOSE * LOOSE * gap(fresh)).max(EQUAL * EQUAL * span * span)
}

/// Digests of the names of points, a byte each, 0 for none.
pub(super) struct Digests([u8; MOST]);

impl Digests {
    pub(super) fn of(cache: &Cache) -> Self {
        Digests((u64::from(cache.word) | u64::from(cache.kept) << 32).to_le_bytes())
    }

    pub(super) fn new(manifolds: &[Manifold]) -> Self {
        let mut digests = [0; MOST];
        let names = manifolds.iter().flat_map(|m| m.points().iter().map(|p| p.feature));
        digests.iter_mut().zip(names).for_each(|(place, name)| *place = digest(name));
        Digests(digests)
    }

    pub(super) fn cache(&self) -> Cache {
        let all = u64::from_le_bytes(self.0);
        Cache { word: all as u32, kept: (all >> 32) as u32 }
    }

    pub(super) fn has(&self, name: u32) -> bool {
        self.0.contains(&digest(name))
    }
}

#[cfg(test)]
mod tests {
    use super::super::cluster::{BEARING, manifolds};
    use super::super::side::Near;
    use super::*;
    use rockfall_math::Vec3;

    /// Contacts on a plane at places of a circle, each so deep, named by their order.
    fn circle(depths: &[f32]) -> Vec<Contact> {
        let at = |k: usize| {
            let (sin, cos) =
                rockfall_math::trig::sin_cos(std::f32::consts::TAU * k as f32 / depths.len() as f32);
            Vec3::new(cos, sin, 0.0)
        };
        let contact = |(k, depth): (usize, &f32)| {
            Contact::new(true, at(k), Near { distance: -depth, normal: Vec3::Z }, k as u32)
        };
        depths.iter().enumerate().map(contact).collect()
    }

    fn names(contacts: &[Contact], cache: &mut Cache) -> Vec<u32> {
        let mut out = Vec::new();
        manifolds(contacts, 0.1, 0.1, BEARING, cache, |_, _| (), &mut out);
        out.iter().flat_map(|m| m.points().iter().map(|p| p.feature & 0xff)).collect()
    }

    #[test]
    fn points_stay_while_they_serve() {
        let even = circle(&[1e-3; 24]);
        let mut cache = Cache::default();
        let first = names(&even, &mut cache);
        assert_eq!((first.len(), names(&even, &mut cache)), (4, first.clone()));
        // Those that are chosen where the others are not stay when these come back.
        let rest: Vec<Contact> = even.iter().filter(|c| !first.contains(&(c.name & 0xff))).copied().collect();
        let mut cache = Cache::default();
        let others = names(&rest, &mut cache);
        assert!(others.len() == 4 && others != first, "{others:?}");
        assert_eq!(names(&even, &mut cache), others);
    }

    #[test]
    fn what_is_deeper_or_far_from_all_of_them_is_not_hidden() {
        // Two neighbours were all that touched.
        let mut depths = [-1e-2; 24];
        (depths[0], depths[1]) = (1e-3, 1e-3);
        let mut cache = Cache::default();
        let pair: Vec<Contact> = circle(&depths).into_iter().take(2).collect();
        assert_eq!(names(&pair, &mut cache), [0, 1]);
        let kept = cache;
        depths[12] = 1e-3;
        assert!(names(&circle(&depths), &mut cache).contains(&12));
        depths[12] = -1e-2;
        depths[3] = 1.5e-3;
        let mut cache = kept;
        assert!(names(&circle(&depths), &mut cache).contains(&3));
    }
}
