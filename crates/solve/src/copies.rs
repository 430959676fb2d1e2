//! Bodies with very many contacts, split into copies: mass splitting.
//!
//! A slab on a hundred thousand stones has a contact with each of them, and within a colour a body may stand only once: its
//! contacts would be solved one after the other. So a body with more than [`WHOLE`] contacts gets copies, each with some of its contacts
//! and a share of its mass. Copies are rows of their own, behind those of the bodies, and contacts know no difference. A sweep begins with
//! copies that move as their body does and ends with the body moving as the mean of them, weighted by their shares: so no momentum
//! is lost, whatever the shares are (Tonge, Benevolenski and Voroshilov, "Mass Splitting for Jitter-Free Parallel Rigid Body
//! Simulation", ACM Trans. Graph. 31(4), 2012).
//!
//! Equal shares would make a contact as soft as if all the others pressed as hard, also where a slab lies on three of its
//! thousand stones. So shares follow the contacts that press, counted anew in every step.
//!
//! | rows | of |
//! |---|---|
//! | 0 .. n | bodies |
//! | n .. n + k₁ | the copies of the first body that is split |
//! | n + k₁ .. n + k₁ + k₂ | of the second, and so on |

use crate::block::{Block, LANES};
use crate::contacts::Contacts;
use crate::line::{Columns, Drift, Line};
use crate::manifold::FIXED;
use crate::shelf::Class;
use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;
use rockfall_math::hash::{combine, mix};
use rockfall_math::lanes::Row;
use rockfall_math::share::Share;
use rockfall_math::snapshot::{Error, Reader, Writer};
use rockfall_math::stored_plain;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// A body with so many contacts, of one side, is left whole: they find colours.
const WHOLE: u32 = 48;

/// Contacts of a copy, on the average, when copies are made: half of it to all. They may become as few as a quarter before there are
/// fewer copies. Of twice as many, which chance may bring to a copy, each still finds a colour.
const CROWD: u32 = 24;

/// Share of the contacts that do not press, together, in the mass of a body. They may do so later in the step.
const SPARE: f64 = 0.1;

/// Contacts of a copy that press, and of those that don't: counts in two halves of a number.
const PRESSING: u64 = 1 << 32;
const IDLE: u64 = 1;

/// A body that is split.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
struct Split {
    /// Of the body.
    row: u32,
    /// Of its first copy, counted from the first copy of all.
    first: u32,
    /// Copies, a power of two.
    count: u32,
}

stored_plain!(Split: "split");

/// The copies of all bodies that are split.
#[derive(Clone, Debug, Default)]
pub(crate) struct Copies {
    /// Rows of bodies.
    bodies: u32,
    /// By row.
    splits: Vec<Split>,
    /// Row of the body of each copy.
    owners: Vec<u32>,
    /// Share of each copy in the mass of its body; 0 for one without contacts.
    shares: Vec<f32>,
    /// Motion and drift of each split body; room for [`Copies::unite`].
    means: Vec<(Row, Row)>,
}

/// Number of copies of a body with `degree` contacts that has `count` now, 1 for one that is whole.
fn wanted(degree: u32, count: u32) -> u32 {
    let fits = count > 1 && degree > CROWD / 4 * count && degree <= CROWD * count;
    match degree {
        _ if fits => count,
        0..=WHOLE => 1,
        _ => degree.div_ceil(CROWD).next_power_of_two(),
    }
}

impl Copies {
    /// No copies, of so many rows.
    pub(crate) fn none(bodies: usize) -> Self {
        Copies { bodies: bodies as u32, ..Copies::default() }
    }

    /// Bodies by row, with their contacts of the one side and of the other: those that have to be split now. `renamed` tells the new row of a body.
    pub(crate) fn next(&self, degrees: &[[u32; 2]], renamed: impl Fn(u32) -> u32) -> Self {
        let mut counts: Vec<(u32, u32)> =
            self.splits.iter().map(|split| (renamed(split.row), split.count)).collect();
        counts.retain(|&(row, _)| (row as usize) < degrees.len());
        counts.sort_unstable();
        let before = |row: u32| counts.binary_search_by_key(&row, |&(row, _)| row).map_or(1, |i| counts[i].1);
        let mut next = Copies::none(degrees.len());
        next.splits = (degrees, 0..next.bodies)
            .into_par_iter()
            .shared()
            .filter(|([pairs, grounds], _)| pairs.max(grounds) > &CROWD)
            .map(|(&[pairs, grounds], row)| {
                let count = wanted(pairs.max(grounds), before(row));
                Split { row, first: 0, count }
            })
            .filter(|split| split.count > 1)
            .collect();
        for split in &mut next.splits {
            split.first = next.owners.len() as u32;
            next.owners.extend(std::iter::repeat_n(split.row, split.count as usize));
        }
        next.shares = vec![0.0; next.owners.len()];
        next
    }

    /// Rows of bodies and copies.
    pub(crate) fn rows(&self) -> usize {
        self.bodies as usize + self.owners.len()
    }

    /// Writes them.
    pub(crate) fn save(&self, to: &mut Writer<'_>) -> Result<(), Error> {
        let Copies { bodies: _, splits, owners: _, shares, means: _ } = self;
        to.column("copies.splits", splits)?;
        to.column("copies.shares", shares)
    }

    /// Reads those of so many bodies, of which no more than `most` copies may be.
    pub(crate) fn load(from: &mut Reader<'_>, bodies: usize, most: usize) -> Result<Self, Error> {
        let mut copies = Copies::none(bodies);
        copies.splits = from.column("copies.splits")?;
        let mut next = 1;
        for &Split { row, first, count } in &copies.splits {
            let sound = row >= next && (row as usize) < bodies && first as usize == copies.owners.len();
            let few = count > 1 && copies.owners.len() + count as usize <= most;
            Error::unless(sound && few, "copies.splits", "a body that can't be split so")?;
            copies.owners.extend(std::iter::repeat_n(row, count as usize));
            next = row + 1;
        }
        let rows = copies.rows() < FIXED as usize;
        Error::unless(rows, "copies.splits", "more copies than rows can be told apart")?;
        copies.shares = from.column_of("copies.shares", copies.owners.len())?;
        Ok(copies)
    }

    /// Number of bodies that are split.
    pub(crate) fn len(&self) -> usize {
        self.splits.len()
    }

    /// Whether no body is split.
    pub(crate) fn is_empty(&self) -> bool {
        self.splits.is_empty()
    }

    /// Whether the same bodies are split into as many copies each.
    pub(crate) fn is_like(&self, other: &Copies) -> bool {
        self.splits == other.splits
    }

    /// Rows of bodies become more at the end.
    pub(crate) fn resize(&mut self, bodies: usize) {
        debug_assert!(self.is_empty() || self.bodies as usize == bodies, "copies stand behind all bodies");
        self.bodies = bodies as u32;
    }

    /// Bytes held.
    pub(crate) fn memory(&self) -> usize {
        self.splits.capacity() * size_of::<Split>()
            + self.owners.capacity() * size_of::<u32>()
            + self.shares.capacity() * size_of::<f32>()
            + self.means.capacity() * size_of::<(Row, Row)>()
    }

    /// First row that is a copy's.
    pub(crate) fn first(&self) -> u32 {
        self.bodies
    }

    fn split(&self, row: u32) -> Option<&Split> {
        self.splits.binary_search_by_key(&row, |split| split.row).ok().map(|i| &self.splits[i])
    }

    /// The body of a row, which may be a copy.
    pub(crate) fn body(&self, row: u32) -> u32 {
        row.checked_sub(self.bodies).map_or(row, |copy| self.owners[copy as usize])
    }

    /// Number of a copy among those of its body, and how many there are.
    fn number(&self, row: u32) -> Option<(u32, u32)> {
        let copy = row.checked_sub(self.bodies)?;
        let split = self.split(self.owners[copy as usize])?;
        Some((copy - split.first, split.count))
    }

    /// The row of a body's copy that has a contact: the one whose number `old`, and how many there were, is the same, where the body has as many
    /// now; otherwise one by chance. The second is whether it is the same.
    fn find(&self, row: u32, old: Option<(u32, u32)>, chance: u64) -> (u32, bool) {
        let Some(split) = self.split(row) else { return (row, old.is_none()) };
        let first = self.bodies + split.first;
        match old {
            Some((number, count)) if count == split.count => (first + number, true),
            _ => (first + (chance % u64::from(split.count)) as u32, false),
        }
    }

    /// Rows of the copies that a contact of two bodies gets, the mark of the second kept; `chance` is different for each contact.
    pub(crate) fn place(&self, a: u32, b: u32, chance: u64) -> (u32, u32) {
        if self.is_empty() {
            return (a, b);
        }
        let chance = combine(mix(u64::from(a) << 32 | u64::from(b)), chance);
        let copy_b = if b & FIXED == 0 { self.find(b, None, chance >> 32).0 } else { b };
        (self.find(a, None, chance).0, copy_b)
    }

    /// The same for a contact that had the rows `old` among the copies `from`. The last is whether both are the same copies as
    /// before, so that its colour is still free for it.
    pub(crate) fn keep(
        &self,
        (a, b): (u32, u32),
        from: &Copies,
        old: (u32, u32),
        chance: u64,
    ) -> (u32, u32, bool) {
        if self.is_empty() && from.is_empty() {
            return (a, b, true);
        }
        let (copy_a, same_a) = self.find(a, from.number(old.0), chance);
        let (copy_b, same_b) =
            if b & FIXED == 0 { self.find(b, from.number(old.1), mix(chance)) } else { (b, true) };
        (copy_a, copy_b, same_a && same_b)
    }

    /// What contacts read of a row.
    pub(crate) fn line(&self, row: u32, lines: &[Line]) -> Line {
        let line = lines[self.body(row) as usize];
        row.checked_sub(self.bodies).map_or(line, |copy| share_of(line, self.shares[copy as usize]))
    }

    /// Puts the copies behind the bodies, each moving as its body.
    pub(crate) fn part(&self, columns: &mut Columns<'_>) {
        let bodies = self.bodies as usize;
        if self.is_empty() {
            return;
        }
        columns.lines.reserve_exact(self.owners.len());
        columns.drifts.reserve_exact(self.owners.len());
        columns.lines.resize(self.rows(), Line::default());
        columns.drifts.resize(self.rows(), Drift::default());
        let (lines, copied_lines) = columns.lines.split_at_mut(bodies);
        let (drifts, copied_drifts) = columns.drifts.split_at_mut(bodies);
        (copied_lines, copied_drifts, &self.owners, &self.shares)
            .into_par_iter()
            .with_min_len(1024)
            .shared()
            .for_each(|(line, drift, &owner, &share)| {
                *line = share_of(lines[owner as usize], share);
                *drift = drifts[owner as usize];
            });
    }

    /// Takes the copies away again; the bodies move as the weighted mean of theirs.
    pub(crate) fn unite(&mut self, columns: &mut Columns<'_>) {
        let bodies = self.bodies as usize;
        if self.is_empty() {
            return;
        }
        let Copies { splits, shares, means, .. } = self;
        let (lines, copied_lines) = columns.lines.split_at(bodies);
        let (drifts, copied_drifts) = columns.drifts.split_at(bodies);
        splits
            .par_iter()
            .shared()
            .map(|split| {
                let copies = split.first as usize..(split.first + split.count) as usize;
                let row = split.row as usize;
                let motions = copied_lines[copies.clone()].iter().map(|line| &line.motion);
                let ways = copied_drifts[copies.clone()].iter().map(|drift| &drift.0);
                let shares = &shares[copies];
                (mean(lines[row].motion, motions, shares), mean(drifts[row].0, ways, shares))
            })
            .collect_into_vec(means);
        for (split, (motion, drift)) in splits.iter().zip(means) {
            columns.lines[split.row as usize].motion = *motion;
            columns.drifts[split.row as usize].0 = *drift;
        }
        columns.lines.truncate(bodies);
        columns.drifts.truncate(bodies);
    }
}

/// A line with a share of the mass.
fn share_of(mut line: Line, share: f32) -> Line {
    let scale = if share > 0.0 { 1.0 / share } else { 0.0 };
    line.motion[6] *= scale;
    line.inertia = line.inertia.map(|x| x * scale);
    line
}

/// The first six numbers of `row` with what copies differ from it, each by its share.
fn mean<'a>(row: Row, copies: impl Iterator<Item = &'a Row>, shares: &[f32]) -> Row {
    let mut sums = [0.0_f64; 6];
    for (copy, &share) in copies.zip(shares) {
        for ((sum, x), from) in sums.iter_mut().zip(copy).zip(row) {
            *sum += f64::from(share) * (f64::from(*x) - f64::from(from));
        }
    }
    let mut row = row;
    for (x, sum) in row.iter_mut().zip(sums) {
        *x = (f64::from(*x) + sum) as f32;
    }
    row
}

impl Contacts {
    /// Shares the masses of split bodies out among the contacts that press.
    pub(crate) fn weigh(&mut self) {
        if self.copies.is_empty() {
            return;
        }
        // Whole numbers: their sums don't know in which order they are added.
        let counts: Vec<AtomicU64> = self.copies.owners.iter().map(|_| AtomicU64::new(0)).collect();
        let (first, counts) = (self.copies.bodies, &counts[..]);
        let buckets: Vec<_> = self.buckets.iter().filter(|(key, _)| key.is_of_copies()).collect();
        buckets.into_par_iter().shared().for_each(|(key, bucket)| {
            bucket.blocks.iter().for_each(|&block| match key.class() {
                Class::Ball => count(&self.ball.blocks[block as usize], first, counts),
                Class::One => count(&self.one.blocks[block as usize], first, counts),
                Class::Two => count(&self.two.blocks[block as usize], first, counts),
                Class::Four => count(&self.four.blocks[block as usize], first, counts),
            });
        });
        let Copies { splits, shares, .. } = &mut self.copies;
        for split in splits {
            let copies = split.first as usize..(split.first + split.count) as usize;
            let counts = counts[copies.clone()].iter().map(|count| {
                let count = count.load(Relaxed);
                [(count / PRESSING) as f64, (count % PRESSING) as f64]
            });
            let [pressing, idle] = counts.clone().fold([0.0, 0.0], |a, b| [a[0] + b[0], a[1] + b[1]]);
            // As heavy as the others where no contact presses, or few don't.
            let spare = if pressing > 0.0 { (SPARE * pressing / idle.max(1.0)).min(1.0) } else { 1.0 };
            let whole = (pressing + spare * idle).max(1.0);
            for (share, [pressing, idle]) in shares[copies].iter_mut().zip(counts) {
                *share = ((pressing + spare * idle) / whole) as f32;
            }
        }
    }
}

fn count<const P: usize, const T: usize>(block: &Block<P, T>, first: u32, counts: &[AtomicU64]) {
    for lane in (0..LANES).filter(|&lane| block.a[lane] != 0) {
        let presses = (0..P).any(|p| {
            let used = block.masses[p][lane] != 0.0;
            used && (block.impulses[p][lane] > 0.0 || block.distances[p][lane] <= 0.0)
        });
        for copy in [block.a[lane], block.b[lane]].into_iter().filter_map(|row| row.checked_sub(first)) {
            counts[copy as usize].fetch_add(if presses { PRESSING } else { IDLE }, Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::line::Bodies;
    use rockfall_math::{Mat3, Vec3};

    #[test]
    fn bodies_are_split_late_and_made_whole_later() {
        let mut count = 1;
        let counts: Vec<u32> = [10, 48, 49, 96, 97, 49, 48, 100_000, 50_000, 49_000, 20]
            .into_iter()
            .map(|degree| {
                count = wanted(degree, count);
                count
            })
            .collect();
        assert_eq!(counts, [1, 1, 4, 4, 8, 8, 1, 8192, 8192, 2048, 1]);
    }

    #[test]
    fn copies_keep_their_contacts_when_rows_are_renamed() {
        let degrees = |hub: usize, row: usize| if row == hub { [100, 0] } else { [2, 1] };
        let before =
            Copies::none(10).next(&(0..10).map(|row| degrees(3, row)).collect::<Vec<_>>(), |row| row);
        assert_eq!((before.rows(), before.first(), before.body(12), before.body(9)), (18, 10, 3, 9));
        // Row 3 becomes row 7, and there are two rows more.
        let table: Vec<_> = (0..12).map(|row| degrees(7, row)).collect();
        let after = before.next(&table, |row| if row == 3 { 7 } else { row });
        for chance in 0..100 {
            let (a, b) = before.place(3, 5, chance);
            assert!((10..18).contains(&a) && b == 5);
            assert_eq!(after.keep((7, 5), &before, (a, b), chance), (a + 2, 5, true));
            let ground = 5 | FIXED;
            assert_eq!(after.keep((7, ground), &before, (a, ground), chance), (a + 2, ground, true));
        }
        // Of more copies any one may be the new one.
        let table: Vec<_> = (0..12).map(|row| degrees(7, row).map(|n| 10 * n)).collect();
        let more = before.next(&table, |row| if row == 3 { 7 } else { row });
        let (a, b, same) = more.keep((7, 5), &before, before.place(3, 5, 0), 1);
        assert!((12..12 + 64).contains(&a) && b == 5 && !same);
    }

    /// Copies of unequal shares, each pushed by itself: the body gains the sum of the momenta.
    #[test]
    fn momentum_is_the_sum_of_what_copies_got() {
        let mut copies = Copies::none(3).next(&[[0, 0], [0, 200], [1, 0]], |row| row);
        let count = copies.owners.len();
        let total: usize = (1..=count).sum();
        copies.shares = (1..=count).map(|i| i as f32 / total as f32).collect();
        let mut line = Line { motion: [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 0.5, 1.0], ..Line::default() };
        line.set_inverse_inertia(&Mat3::from_diagonal(Vec3::splat(0.25)));
        let mut bodies = Bodies::new(3);
        bodies.lines.fill(line);
        let mut columns = bodies.columns();
        copies.part(&mut columns);
        let mut given = 0.0;
        for (i, copy) in columns.lines[3..].iter_mut().enumerate() {
            let impulse = 0.01 * i as f32;
            given += impulse;
            copy.motion[0] += impulse * copy.motion[6];
            copy.motion[3] += impulse * copy.inertia[0];
        }
        copies.unite(&mut columns);
        let Bodies { lines, drifts, .. } = bodies;
        assert_eq!((lines.len(), drifts.len()), (3, 3));
        assert!((lines[1].motion[0] - (1.0 + given * 0.5)).abs() < 1e-5);
        assert!((lines[1].motion[3] - (4.0 + given * 0.25)).abs() < 1e-5);
        assert_eq!((lines[1].motion[1], lines[2], drifts[1]), (2.0, line, Drift::default()));
    }
}
