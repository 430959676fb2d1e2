//! Manifolds of contacts that look the same way.
//!
//! A manifold holds a body by four points that share a normal; so contacts are sorted by normal alone: of those that look the same way, the four that span the largest area
//! carry as much as all, wherever they are; and of many manifolds only so many points are kept as a pair needs (`few`), those of the last step while they serve (`keep`). Points that touch come first, by name, so that the same ones lead from step to step.

use super::few::keep_few;
use super::gather::Contact;
use super::keep::{Digests, serves};
use crate::reduce::{first_max, reduce_within, start};
use crate::{Cache, ContactPoint, Manifold};
use rockfall_math::Vec3;

/// Cosine of the largest angle between a contact and the one that leads its manifold, in one place: 25°. There, corners and edges of a surface that bends look many ways, and push one.
const ALIKE: f32 = 0.906;

/// The same for contacts further apart: 8°. Around a bowl in a bowl each pushes its own way.
const SAME: f32 = 0.99;

/// Contacts no further apart than so many spacings of the samples are in one place.
const PLACE: f32 = 3.0;

/// Points of fields that are open by more than this share of the manifold's span beyond the deepest of their place bear no load but on flat ground, and never take the place of one that does: next to a line of contact, on a surface that bends away, they would span the larger area.
pub(super) const BEARING: f32 = 1.5e-3;

/// Cosine of the largest angle between the normal of a manifold and that of a point of flat ground: 2°.
const FLAT: f32 = 0.999_4;

/// Points no further from the line between two of them than this share of its length lie on it.
const ON_LINE: f32 = 0.05;

/// Depths that differ by less than this share of the span are equal.
pub(super) const EQUAL: f32 = 2.5e-4;

/// Appends the manifolds of contacts that are no further apart than `margin`. Those that are open by more than the share `bearing` of their span beyond the deepest come in only where the others leave room; `measure` is called for those that are kept.
/// What `cache` says was kept the last time is kept while it serves as well.
pub(crate) fn manifolds(
    contacts: &[Contact],
    margin: f32,
    spacing: f32,
    bearing: f32,
    cache: &mut Cache,
    measure: impl Fn(&Contact, &mut ContactPoint),
    out: &mut Vec<Manifold>,
) {
    let first = out.len();
    let digests = Digests::of(cache);
    let old: Vec<Contact> = contacts.iter().filter(|contact| digests.has(contact.name)).copied().collect();
    choose(contacts, margin, spacing, bearing, out);
    if !old.is_empty() && old.len() < contacts.len() {
        let mut kept = Vec::new();
        choose(&old, margin, spacing, bearing, &mut kept);
        if serves(contacts, &kept, &out[first..]) {
            out.truncate(first);
            out.append(&mut kept);
        }
    }
    *cache = Digests::new(&out[first..]).cache();
    for manifold in &mut out[first..] {
        for point in &mut manifold.points[..manifold.count as usize] {
            if let Some(contact) = contacts.iter().find(|contact| contact.name == point.feature) {
                measure(contact, point);
            }
        }
    }
}

/// Appends the manifolds that contacts make if nothing is known of the last step.
fn choose(contacts: &[Contact], margin: f32, spacing: f32, bearing: f32, out: &mut Vec<Manifold>) {
    let mut order: Vec<&Contact> = contacts.iter().collect();
    order.sort_by_key(|contact| (contact.distance > 0.0, contact.name));
    let mut clusters: Vec<Vec<&Contact>> = Vec::new();
    for contact in order {
        let nearest = clusters
            .iter_mut()
            .map(|cluster| (cluster[0].normal.dot(contact.normal), cluster))
            .filter(|(cosine, cluster)| {
                let near = cluster[0].position.distance(contact.position) <= PLACE * spacing;
                *cosine > if near { ALIKE } else { SAME }
            })
            .max_by(|(a, _), (b, _)| a.total_cmp(b));
        match nearest {
            Some((_, cluster)) => cluster.push(contact),
            None => clusters.push(vec![contact]),
        }
    }
    let first = out.len();
    out.extend(clusters.iter().map(|cluster| manifold(cluster, margin, spacing, bearing)));
    keep_few(out, first);
}

fn manifold(cluster: &[&Contact], margin: f32, spacing: f32, bearing: f32) -> Manifold {
    let deepest = cluster.iter().fold(f32::INFINITY, |least, c| least.min(c.distance));
    // What is deep says most of the direction, and what only just came near nothing at all.
    let scale = (margin - deepest).max(f32::MIN_POSITIVE);
    let weight = |c: &Contact| {
        let share = (margin - c.distance) / scale;
        share * share * share * share
    };
    let sum: Vec3 = cluster.iter().map(|c| weight(c) * c.normal).sum();
    let normal = sum.normalize_or(cluster[0].normal);
    let first = cluster[0].position;
    let span = cluster.iter().fold(0.0_f32, |far, c| far.max(c.position.distance(first)));
    let point = |c: &&Contact| ContactPoint { position: c.position, distance: c.distance, feature: c.name };
    let is_flat = |c: &Contact| c.normal.dot(normal) >= FLAT;
    // On flat ground all that overlaps bears: were a ring that is pressed into a floor held by the deepest part of its tube alone, it would swing from one side to the other.
    let on_flat_ground = cluster.iter().filter(|c| c.distance <= 0.0).all(|c| is_flat(c));
    // Elsewhere the deepest in each place does. Two rings on each other touch on two sides, mostly one of them deeper: were they held there alone, they would fall on the other side, until that is the deeper one, and rock for ever.
    let leads = |c: &Contact| {
        let is_beside = |other: &&&Contact| other.position.distance(c.position) <= PLACE * spacing;
        cluster.iter().filter(is_beside).all(|other| c.distance - other.distance <= bearing * span)
    };
    let bears = |c: &&&Contact| {
        c.distance - deepest <= bearing * span || c.distance <= 0.0 && (on_flat_ground || leads(c))
    };
    let loaded: Vec<ContactPoint> = cluster.iter().filter(bears).map(point).collect();
    let mut manifold = ends(reduce_within(normal, &loaded, start(normal), EQUAL * span), EQUAL * span);
    // Room that is left goes to those that will bear when the body tips: on flat ground, where they look exactly the same way.
    let mut open: Vec<ContactPoint> = cluster.iter().filter(|c| !bears(c) && is_flat(c)).map(point).collect();
    while manifold.count < 4 && !open.is_empty() {
        let apart = |p: &ContactPoint| {
            let to = |q: &ContactPoint| q.position.distance_squared(p.position);
            manifold.points().iter().map(to).fold(f32::INFINITY, f32::min)
        };
        let farthest = first_max(&open, apart);
        manifold.points[manifold.count as usize] = open.swap_remove(farthest);
        manifold.count += 1;
    }
    manifold
}

/// Of points on a line the two at its ends, which carry as much as all and leave room; and the deepest, if that is deeper than both by more than `tie` metres.
fn ends(manifold: Manifold, tie: f32) -> Manifold {
    let points = manifold.points();
    let pairs = (0..points.len()).flat_map(|i| (0..i).map(move |j| (points[j], points[i])));
    let length = |&(p, q): &(ContactPoint, ContactPoint)| p.position.distance_squared(q.position);
    let Some((from, to)) = pairs.max_by(|a, b| length(a).total_cmp(&length(b))) else { return manifold };
    let along = to.position - from.position;
    let beside = |p: &ContactPoint| (p.position - from.position).cross(along).length();
    if points.len() < 3 || points.iter().any(|p| beside(p) > ON_LINE * along.length_squared()) {
        return manifold;
    }
    let deepest = points[first_max(points, |p| -p.distance)];
    let mut line = Manifold { count: 2, ..manifold };
    (line.points[0], line.points[1]) = (from, to);
    if deepest.distance < from.distance.min(to.distance) - tie {
        line.points[2] = deepest;
        line.count = 3;
    }
    line
}

#[cfg(test)]
mod tests {
    use super::super::side::Near;
    use super::*;
    use rockfall_math::trig;

    const SPACING: f32 = 4e-3;

    /// Six contacts in a place of two tubes: the deepest in the middle, normals that lean by an angle (radians) and bend away from it.
    fn place(x: f32, depth: f32, lean: f32, names: u32) -> impl Iterator<Item = Contact> {
        (0..6).map(move |k| {
            let along = 2e-3 * (k as f32 - 2.5);
            let (sin, cos) = trig::sin_cos(lean + 0.02 * (k as f32 - 2.5));
            let near = Near { distance: -depth + 40.0 * along * along, normal: Vec3::new(sin, 0.0, cos) };
            Contact::new(true, Vec3::new(x + along, 1e-3 * (k % 2) as f32, 0.0), near, names + k)
        })
    }

    fn chosen(contacts: &[Contact]) -> Vec<Manifold> {
        let mut out = Vec::new();
        manifolds(contacts, 8e-3, SPACING, BEARING, &mut Cache::default(), |_, _| (), &mut out);
        out
    }

    #[test]
    fn a_place_that_is_less_deep_than_another_one_has_points_of_its_own() {
        for shallow in [2.6e-3, 1.8e-3, 0.9e-3, 0.3e-3] {
            let both: Vec<Contact> =
                place(0.0, 2.7e-3, 0.04, 0).chain(place(0.06, shallow, -0.04, 6)).collect();
            let found = chosen(&both);
            let deepest_at = |x: f32| {
                let points = found.iter().flat_map(|m| m.points());
                let here = points.filter(|p| (p.position.x - x).abs() < PLACE * SPACING);
                here.fold(f32::INFINITY, |least, p| least.min(p.distance))
            };
            assert!(deepest_at(0.0) < -2.6e-3, "{found:?}");
            assert!(deepest_at(0.06) < -0.5 * shallow, "{shallow}: {found:?}");
        }
    }

    #[test]
    fn what_bends_away_from_the_deepest_of_its_place_bears_no_load() {
        // Of a tube on a floor only the line of contact is held, although others of its points lie in the floor.
        let one: Vec<Contact> = place(0.0, 1e-3, 0.0, 0).collect();
        let held = |found: &[Manifold]| -> Vec<f32> {
            found.iter().flat_map(|m| m.points().iter().map(|p| p.position.x)).collect()
        };
        let found = held(&chosen(&one));
        assert!(found.iter().all(|x| x.abs() < 4e-3), "{found:?}");
    }
}
