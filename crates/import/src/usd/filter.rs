//! Who does not collide with whom: `PhysicsCollisionGroup` and `PhysicsFilteredPairsAPI`, as groups and masks of 32 bits.
//!
//! Bodies that are filtered from the same others are one class. Whether two bodies collide depends on their classes alone, so a bit for each class
//! says it exactly: a body is in the group of its class, and its mask lacks the classes that it is filtered from.

use super::values::{flag, said, targets, word};
use crate::build::Builder;
use openusd::usd::Prim;
use std::collections::{BTreeMap, BTreeSet};

/// What has been found of filters while a stage is read.
#[derive(Debug, Default)]
pub(super) struct Filters {
    groups: Vec<Group>,
    /// Each prim with filtered pairs, and what it is filtered from.
    pairs: Vec<(String, String)>,
    /// Bodies, as their prims are called.
    bodies: Vec<String>,
    /// Prims that are bodies or belong to one: index of the body.
    owners: BTreeMap<String, u32>,
}

#[derive(Debug)]
struct Group {
    name: String,
    /// Groups of the same name here are one.
    merged: Option<String>,
    includes: Vec<String>,
    excludes: Vec<String>,
    filtered: Vec<String>,
    /// It collides with those that it names, and with no others.
    inverted: bool,
}

/// Group and mask of a body.
pub(super) type Bits = (u32, u32);

/// What a class is: the groups of its bodies, and the bodies from which they are filtered one by one.
type Class = (BTreeSet<u32>, BTreeSet<u32>);

impl Filters {
    /// Adds a body with the prims of its colliders; returns its index. What is read again, as prototypes are at other scales, keeps it.
    pub(super) fn body<'a>(&mut self, name: &'a str, colliders: impl Iterator<Item = &'a str>) -> u32 {
        if let Some(&known) = self.owners.get(name).filter(|known| self.bodies[**known as usize] == name) {
            return known;
        }
        let index = self.bodies.len() as u32;
        self.bodies.push(name.to_owned());
        for prim in colliders.chain([name]) {
            self.owners.insert(prim.to_owned(), index);
        }
        index
    }

    /// Reads the filtered pairs of a prim.
    pub(super) fn pairs(&mut self, prim: &Prim) -> Result<(), String> {
        for target in targets(prim, "physics:filteredPairs")? {
            self.pairs.push((prim.path().as_str().to_owned(), target.as_str().to_owned()));
        }
        Ok(())
    }

    /// Reads a collision group.
    pub(super) fn group(&mut self, prim: &Prim, builder: &mut Builder) -> Result<(), String> {
        let paths = |name: &str| -> Result<Vec<String>, String> {
            Ok(targets(prim, name)?.iter().map(|path| path.as_str().to_owned()).collect())
        };
        let name = prim.path().as_str();
        let rule = word(prim, "collection:colliders:expansionRule")?;
        let expression = prim.attribute("collection:colliders:membershipExpression");
        if rule.as_deref() == Some("explicitOnly")
            || flag(prim, "collection:colliders:includeRoot", false)?
            || expression.get::<openusd::sdf::Value>().map_err(said)?.is_some()
        {
            builder.note(
                "a collection that is not made of prims and all below them is taken as if it were",
                name,
            );
        }
        self.groups.push(Group {
            name: name.to_owned(),
            merged: word(prim, "physics:mergeGroup")?.filter(|name| !name.is_empty()),
            includes: paths("collection:colliders:includes")?,
            excludes: paths("collection:colliders:excludes")?,
            filtered: paths("physics:filteredGroups")?,
            inverted: flag(prim, "physics:invertFilteredGroups", false)?,
        });
        Ok(())
    }

    /// Bits of each body, in the order in which they were added.
    pub(super) fn bits(&self, builder: &mut Builder) -> Vec<Bits> {
        let mut classes: BTreeMap<u32, Class> = BTreeMap::new();
        for (index, group) in (0..).zip(&self.groups) {
            for body in self.members(group) {
                classes.entry(body).or_default().0.insert(index);
            }
        }
        for (one, other) in &self.pairs {
            for a in self.under(one) {
                for b in self.under(other).into_iter().filter(|b| *b != a) {
                    classes.entry(a).or_default().1.insert(b);
                    classes.entry(b).or_default().1.insert(a);
                }
            }
        }
        let apart = self.apart();
        // Bodies of no class have the first bit.
        let mut bits: BTreeMap<&Class, u32> = BTreeMap::new();
        let mut bit_of = vec![0; self.bodies.len()];
        for (&body, class) in &classes {
            let next = bits.len() as u32 + 1;
            let bit = *bits.entry(class).or_insert(next);
            if bit < 32 {
                bit_of[body as usize] = bit;
            } else {
                builder
                    .note("more than 31 kinds of filters: a filter is not kept", &self.bodies[body as usize]);
            }
        }
        let mut masks = [u32::MAX; 32];
        for (one, &a) in bits.iter().filter(|(_, bit)| **bit < 32) {
            for (other, &b) in bits.iter().filter(|(_, bit)| **bit < 32) {
                let by_group = one.0.iter().any(|&g| other.0.iter().any(|&h| apart.contains(&(g, h))));
                let by_pair = one.1.iter().any(|&body| bit_of[body as usize] == b);
                if by_group || by_pair {
                    masks[a as usize] &= !(1 << b);
                    masks[b as usize] &= !(1 << a);
                }
            }
        }
        bit_of.iter().map(|&bit| (1 << bit, masks[bit as usize])).collect()
    }

    /// Bodies of a group.
    fn members(&self, group: &Group) -> BTreeSet<u32> {
        let prims =
            |paths: &[String]| -> BTreeSet<u32> { paths.iter().flat_map(|p| self.under(p)).collect() };
        let excluded = prims(&group.excludes);
        prims(&group.includes).difference(&excluded).copied().collect()
    }

    /// Bodies that are at a path, below it, or have a collider there.
    fn under(&self, path: &str) -> BTreeSet<u32> {
        let below = self.owners.range(path.to_owned()..).take_while(|(name, _)| {
            name.strip_prefix(path).is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
        });
        below.map(|(_, &body)| body).collect()
    }

    /// Pairs of groups that don't collide, both ways round.
    fn apart(&self) -> BTreeSet<(u32, u32)> {
        let same = |a: &Group, b: &Group| a.name == b.name || (a.merged.is_some() && a.merged == b.merged);
        let mut apart = BTreeSet::new();
        for (i, group) in (0..).zip(&self.groups) {
            // What one of a merged group filters all of it filter.
            let kin: Vec<&Group> = self.groups.iter().filter(|other| same(group, other)).collect();
            let inverted = kin.iter().any(|g| g.inverted);
            for (j, other) in (0..).zip(&self.groups) {
                let names = self.groups.iter().filter(|g| same(g, other));
                let named = names.into_iter().any(|g| kin.iter().any(|k| k.filtered.contains(&g.name)));
                if named != inverted {
                    apart.insert((i, j));
                    apart.insert((j, i));
                }
            }
        }
        apart
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn collide(a: Bits, b: Bits) -> bool {
        a.0 & b.1 != 0 && b.0 & a.1 != 0
    }

    fn group(name: &str, includes: &[&str], filtered: &[&str], inverted: bool) -> Group {
        let owned = |all: &[&str]| all.iter().map(|s| (*s).to_owned()).collect();
        Group {
            name: name.to_owned(),
            merged: None,
            includes: owned(includes),
            excludes: Vec::new(),
            filtered: owned(filtered),
            inverted,
        }
    }

    /// Which of the first letters collide.
    fn table(filters: &Filters) -> Vec<(usize, usize)> {
        let mut builder = Builder::default();
        let bits = filters.bits(&mut builder);
        let n = bits.len();
        let all = (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b)));
        all.filter(|&(a, b)| !collide(bits[a], bits[b])).collect()
    }

    fn bodies(count: usize) -> Filters {
        let mut filters = Filters::default();
        for k in 0..count {
            let name = format!("/w/b{k}");
            let collider = format!("{name}/shape");
            filters.body(&name, [collider.as_str()].into_iter());
        }
        filters
    }

    #[test]
    fn pairs_are_filtered_both_ways_and_nothing_else_is() {
        let mut filters = bodies(5);
        filters.pairs.push(("/w/b0".into(), "/w/b1".into()));
        filters.pairs.push(("/w/b3/shape".into(), "/w/b1".into()));
        assert_eq!(table(&filters), [(0, 1), (1, 3)]);
    }

    #[test]
    fn what_is_read_twice_is_one_body() {
        let mut filters = bodies(2);
        assert_eq!(filters.body("/w/b0", ["/w/b0/shape"].into_iter()), 0);
        assert_eq!(filters.body("/w/b2", [].into_iter()), 2);
    }

    #[test]
    fn a_star_of_pairs_takes_two_classes_however_large_it_is() {
        let mut filters = bodies(200);
        filters.pairs.extend((1..200).map(|k| ("/w/b0".to_owned(), format!("/w/b{k}"))));
        let expected: Vec<(usize, usize)> = (1..200).map(|k| (0, k)).collect();
        assert_eq!(table(&filters), expected);
    }

    #[test]
    fn groups_filter_groups_and_an_inverted_one_all_but_those() {
        let mut filters = bodies(4);
        filters.groups.push(group("/A", &["/w/b0"], &["/B"], false));
        filters.groups.push(group("/B", &["/w/b1", "/w/b2"], &[], false));
        assert_eq!(table(&filters), [(0, 1), (0, 2)]);
        let mut filters = bodies(4);
        filters.groups.push(group("/A", &["/w/b0", "/w/b1"], &["/A"], true));
        filters.groups.push(group("/B", &["/w/b2"], &[], false));
        assert_eq!(table(&filters), [(0, 2), (1, 2)], "of no group is filtered from none");
    }

    #[test]
    fn filters_that_do_not_fit_are_said() {
        let mut filters = bodies(80);
        filters.pairs.extend((0..40).map(|k| (format!("/w/b{k}"), format!("/w/b{}", k + 40))));
        let mut builder = Builder::default();
        filters.bits(&mut builder);
        let notes = builder.finish(Vec::new()).notes;
        assert_eq!((notes.len(), notes[0].count), (1, 80 - 31));
    }
}
