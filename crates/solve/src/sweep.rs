//! Sweeps: one kernel over all blocks, colour after colour.

use crate::advance::{Advance, Body, advance};
use crate::block::{Block, Cold, LANES};
use crate::contacts::Contacts;
use crate::line::{Columns, Drift, Line};
use crate::plan::{Part, Plan, Span, cold_of};
use crate::shelf::{Class, Shelf, Slack, TILE};
use rayon::prelude::*;
use rockfall_math::disjoint::DisjointRows;
use rockfall_math::lanes::{Kernel, Lanes, Lanes3, Row, Width};
use rockfall_math::share::{self, Share};

/// A layer with fewer blocks is not worth waking a second thread for. Results don't depend on it.
const WORTH_SHARING: usize = 12;

/// Spans that a thread takes of a layer at a time, at most, and pieces that a layer is cut into at least: enough to share.
const CHUNK: usize = 8;
const PIECES: usize = 64;

/// A block with no more contacts is visited lane by lane. A plate with 25 balls, whose contacts have 25 colours, takes 26 µs a step so, and 38 with all lanes at
/// once. Results don't depend on it.
const LONELY: usize = 2;

/// The rows that the contacts of a sweep read and write.
pub(crate) struct Rows<'a> {
    pub(crate) lines: DisjointRows<'a, Line>,
    pub(crate) drifts: DisjointRows<'a, Drift>,
}

impl<'a> Rows<'a> {
    fn new(columns: &'a mut Columns<'_>) -> Self {
        Rows { lines: DisjointRows::new(columns.lines), drifts: DisjointRows::new(columns.drifts) }
    }
}

/// What lies beside a block.
pub(crate) struct Beside<'a> {
    pub(crate) cold: Option<&'a mut Cold>,
    pub(crate) slack: &'a mut Slack,
    /// See [`Shelf::follows`].
    pub(crate) follows: &'a mut u16,
}

/// What a sweep does to `L::WIDTH` lanes of a block, from lane `k` on.
pub(crate) trait Visit: Sync {
    /// Whether it reads velocities, and not only how bodies have moved.
    const LINES: bool = true;

    fn visit<L: Lanes, const P: usize, const T: usize>(
        &self,
        token: L::Token,
        rows: &Rows<'_>,
        block: &mut Block<P, T>,
        beside: Beside<'_>,
        k: usize,
        span: &Span,
    );
}

/// Runs `visit` over every block, in the order of the plan, after `change` of every body.
pub(crate) fn sweep<V: Visit, A: Advance>(
    contacts: &mut Contacts,
    columns: &mut Columns<'_>,
    width: Width,
    change: &A,
    visit: &V,
) {
    if contacts.plan.inner.is_empty() {
        advance(columns, change);
    } else {
        visit_inner(contacts, columns, width, change, visit);
    }
    contacts.copies.part(columns);
    visit_outer(contacts, &Rows::new(columns), width, visit);
    contacts.copies.unite(columns);
}

/// Contacts within tiles, each after the bodies of its tile have changed.
fn visit_inner<V: Visit, A: Advance>(
    contacts: &mut Contacts,
    columns: &mut Columns<'_>,
    width: Width,
    change: &A,
    visit: &V,
) {
    let (plan, shelves) = Shelves::open(contacts);
    let &mut Columns { starts, frames, inverse_moments, dampings, roles, locks, .. } = columns;
    let references = DisjointRows::new(columns.references);
    let rotations = DisjointRows::new(columns.rotations);
    let (lines, drifts) = (DisjointRows::new(columns.lines), DisjointRows::new(columns.drifts));
    let rows = &Rows { lines, drifts };
    plan.inner.par_iter().enumerate().with_max_len(1).shared().for_each(|(tile, spans)| {
        for row in tile * TILE..((tile + 1) * TILE).min(roles.len()) {
            // SAFETY: tiles share no rows, a tile is one thread's, and none of these borrows outlives the call.
            let (line, drift) = unsafe { (rows.lines.row(row), rows.drifts.row(row)) };
            // SAFETY: as above.
            let (reference, rotation) = unsafe { (references.row(row), rotations.row(row)) };
            change.advance(Body {
                line,
                drift,
                reference,
                rotation,
                start: &starts[row],
                frame: &frames[row],
                inverse_moments: &inverse_moments[row],
                damping: &dampings[row],
                role: roles[row],
                locks: locks[row],
            });
        }
        let spans = &plan.spans[spans.clone()];
        width.run(OverSpans { spans, shelves: &shelves, rows, visit });
    });
}

/// All other contacts.
fn visit_outer<V: Visit>(contacts: &mut Contacts, rows: &Rows<'_>, width: Width, visit: &V) {
    let (plan, shelves) = Shelves::open(contacts);
    let over = |width: Width, spans| width.run(OverSpans { spans, shelves: &shelves, rows, visit });
    for part in &plan.parts {
        match part {
            Part::Serial(spans) => over(Width::Scalar, spans),
            Part::Layer(spans, blocks) => {
                let spans = &plan.spans[spans.clone()];
                if *blocks < WORTH_SHARING || share::threads() == 1 {
                    over(width, spans);
                } else {
                    let chunk = (spans.len() / PIECES).clamp(1, CHUNK);
                    spans.par_chunks(chunk).with_max_len(1).for_each(|spans| over(width, spans));
                }
            }
            Part::Tiles(tiles) => {
                tiles
                    .par_iter()
                    .with_max_len(1)
                    .shared()
                    .for_each(|spans| over(width, &plan.spans[spans.clone()]));
            }
        }
    }
}

/// Runs `visit`, which writes no bodies, over every block in no order.
pub(crate) fn over_all<V: Visit>(
    contacts: &mut Contacts,
    columns: &mut Columns<'_>,
    width: Width,
    visit: &V,
) {
    contacts.copies.part(columns);
    let rows = Rows::new(columns);
    let (plan, shelves) = Shelves::open(contacts);
    let whole = plan.spans.par_chunks(4).shared();
    whole.for_each(|spans| width.run(OverSpans { spans, shelves: &shelves, rows: &rows, visit }));
    contacts.copies.unite(columns);
}

/// The blocks of a class and the numbers of their cold halves.
struct Blocks<'a, const P: usize, const T: usize> {
    blocks: DisjointRows<'a, Block<P, T>>,
    slacks: DisjointRows<'a, Slack>,
    follows: DisjointRows<'a, u16>,
    colds: &'a [u32],
}

impl<'a, const P: usize, const T: usize> Blocks<'a, P, T> {
    fn new(shelf: &'a mut Shelf<P, T>) -> Self {
        let Shelf { blocks, slacks, follows, colds, .. } = shelf;
        let (blocks, slacks) = (DisjointRows::new(blocks), DisjointRows::new(slacks));
        Blocks { blocks, slacks, follows: DisjointRows::new(follows), colds }
    }
}

struct Shelves<'a> {
    ball: Blocks<'a, 1, 0>,
    one: Blocks<'a, 1, 0>,
    two: Blocks<'a, 2, 1>,
    four: Blocks<'a, 4, 1>,
    colds: DisjointRows<'a, Cold>,
}

impl<'a> Shelves<'a> {
    fn open(contacts: &'a mut Contacts) -> (&'a Plan, Self) {
        let Contacts { ball, one, two, four, colds, plan, .. } = contacts;
        let (ball, one) = (Blocks::new(ball), Blocks::new(one));
        let (two, four) = (Blocks::new(two), Blocks::new(four));
        (plan, Shelves { ball, one, two, four, colds: DisjointRows::new(colds) })
    }
}

struct OverSpans<'a, 'b, V> {
    spans: &'a [Span],
    shelves: &'a Shelves<'b>,
    rows: &'a Rows<'b>,
    visit: &'a V,
}

impl<V: Visit> Kernel for OverSpans<'_, '_, V> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self, token: L::Token) {
        for (i, span) in self.spans.iter().enumerate() {
            let after = self.spans.get(i + 1).filter(|after| after.class == span.class);
            match span.class {
                Class::Ball => self.over::<L, 1, 0>(token, span, after, &self.shelves.ball),
                Class::One => self.over::<L, 1, 0>(token, span, after, &self.shelves.one),
                Class::Two => self.over::<L, 2, 1>(token, span, after, &self.shelves.two),
                Class::Four => self.over::<L, 4, 1>(token, span, after, &self.shelves.four),
            }
        }
    }
}

impl<V: Visit> OverSpans<'_, '_, V> {
    /// Has brought near what comes after block `i`: the one after the next, and the bodies of the next. Contacts are visited in the order of memory
    /// as far as it goes, but the bodies of those between tiles are anywhere. Saves a fifth of a sweep over 100,000 balls.
    #[inline(always)]
    fn fetch<const P: usize, const T: usize>(
        &self,
        i: usize,
        span: &Span,
        after: Option<&Span>,
        shelf: &Blocks<'_, P, T>,
    ) {
        if let Some(block) = span.ahead(i, 2, after) {
            shelf.blocks.fetch(block);
        }
        if let Some(block) = span.ahead(i, 1, after) {
            // SAFETY: as in `over`: the spans are this thread's for now, and no other reference to one of their blocks is alive.
            let Block { a, b, .. } = unsafe { shelf.blocks.get(block) };
            for rows in [a, b] {
                for &row in rows {
                    if V::LINES {
                        self.rows.lines.fetch(row as usize);
                    }
                    self.rows.drifts.fetch(row as usize);
                }
            }
        }
    }

    #[inline(always)]
    fn over<L: Lanes, const P: usize, const T: usize>(
        &self,
        token: L::Token,
        span: &Span,
        after: Option<&Span>,
        shelf: &Blocks<'_, P, T>,
    ) {
        for i in span.from as usize..span.to as usize {
            self.fetch(i, span, after, shelf);
            // SAFETY: spans don't share blocks but those of contacts that are solved one by one, and each span is visited by one thread
            // at a time.
            let (block, slack, follows) =
                unsafe { (shelf.blocks.row(i), shelf.slacks.row(i), shelf.follows.row(i)) };
            let cold = if span.cold { cold_of(shelf.colds, i) } else { None };
            // SAFETY: likewise; every cold half belongs to one block.
            let mut cold = cold.map(|cold| unsafe { self.shelves.colds.row(cold) });
            let (from, to) = span.only.map_or((0, LANES), |k| (usize::from(k), usize::from(k) + 1));
            if L::WIDTH > 1 && block.a.iter().filter(|&&a| a != 0).count() <= LONELY {
                for k in from..to {
                    if block.a[k] == 0 {
                        continue;
                    }
                    let beside =
                        Beside { cold: cold.as_deref_mut(), slack: &mut *slack, follows: &mut *follows };
                    visit_lane(self.visit, self.rows, block, beside, k, span);
                }
                continue;
            }
            for k in (from..to).step_by(L::WIDTH) {
                // The first body of a lane in use is never the world.
                if block.a[k..k + L::WIDTH].iter().all(|&a| a == 0) {
                    continue;
                }
                let beside = Beside { cold: cold.as_deref_mut(), slack: &mut *slack, follows: &mut *follows };
                self.visit.visit::<L, P, T>(token, self.rows, block, beside, k, span);
            }
        }
    }
}

/// One lane by itself, which gives what it gives beside others. Not inlined: it is there once for all widths.
#[inline(never)]
fn visit_lane<V: Visit, const P: usize, const T: usize>(
    visit: &V,
    rows: &Rows<'_>,
    block: &mut Block<P, T>,
    beside: Beside<'_>,
    k: usize,
    span: &Span,
) {
    visit.visit::<f32, P, T>((), rows, block, beside, k, span);
}

/// A body in each lane.
pub(crate) struct BodyLanes<L> {
    pub(crate) v: Lanes3<L>,
    pub(crate) w: Lanes3<L>,
    pub(crate) inverse_mass: L,
    pub(crate) gravity_scale: L,
    pub(crate) inverse_inertia: Symmetric<L>,
}

/// What a contact needs of its bodies.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Take {
    /// All.
    Whole,
    /// All but the inverse inertia, which is zero then: plain balls have it in the block.
    Motion,
    /// Velocities, of bodies that contacts can't move: their inverse mass and inertia are zero.
    Fixed,
}

/// A symmetric matrix in each lane.
pub(crate) struct Symmetric<L>(pub(crate) [L; 6]);

impl<L: Lanes> Symmetric<L> {
    #[inline(always)]
    pub(crate) fn times(&self, v: Lanes3<L>) -> Lanes3<L> {
        let [xx, xy, xz, yy, yz, zz] = self.0;
        Lanes3::new(
            xx * v.x + xy * v.y + xz * v.z,
            xy * v.x + yy * v.y + yz * v.z,
            xz * v.x + yz * v.y + zz * v.z,
        )
    }
}

impl<L: Lanes> BodyLanes<L> {
    /// Reads the bodies `index[k..]`.
    #[inline(always)]
    pub(crate) fn gather(
        token: L::Token,
        rows: &Rows<'_>,
        index: &[u32; LANES],
        k: usize,
        take: Take,
    ) -> Self {
        rows.lines.has(&index[k..k + L::WIDTH]);
        // SAFETY: all of these rows are there. Within a layer no other thread writes a body of these lanes; bodies that can't be moved
        // are written by none.
        let line = |i: usize| unsafe { rows.lines.get_unchecked(index[k + i] as usize) };
        let [vx, vy, vz, wx, wy, wz, inverse_mass, gravity_scale] = L::gather(token, |i| &line(i).motion);
        let inverse_inertia = if take == Take::Whole {
            let [xx, xy, xz, yy, yz, zz, _, _] = L::gather(token, |i| &line(i).inertia);
            Symmetric([xx, xy, xz, yy, yz, zz])
        } else {
            Symmetric([L::splat(token, 0.0); 6])
        };
        BodyLanes {
            v: Lanes3::new(vx, vy, vz),
            w: Lanes3::new(wx, wy, wz),
            inverse_mass: if take == Take::Fixed { L::splat(token, 0.0) } else { inverse_mass },
            gravity_scale,
            inverse_inertia,
        }
    }

    /// Writes the velocities back; lanes that are not in use (row 0) write nothing.
    #[inline(always)]
    pub(crate) fn scatter(self, rows: &Rows<'_>, index: &[u32; LANES], k: usize) {
        let BodyLanes { v, w, inverse_mass, gravity_scale, .. } = self;
        let columns = [v.x, v.y, v.z, w.x, w.y, w.z, inverse_mass, gravity_scale];
        rows.lines.has(&index[k..k + L::WIDTH]);
        L::scatter(columns, |i, motion: Row| {
            let row = index[k + i] as usize;
            if row != 0 {
                // SAFETY: the row is there, and within a layer no two lanes and no two threads hold the same movable body.
                unsafe { rows.lines.row_unchecked(row).motion = motion };
            }
        });
    }

    /// Velocity of the point at `arm` from the centre of mass.
    #[inline(always)]
    pub(crate) fn at(&self, arm: Lanes3<L>) -> Lanes3<L> {
        self.v + self.w.cross(arm)
    }

    /// Takes the impulse `j` at `arm`, times ±1.
    #[inline(always)]
    pub(crate) fn push(&mut self, j: Lanes3<L>, arm: Lanes3<L>) {
        self.v = self.v + j.scale(self.inverse_mass);
        self.w = self.w + self.inverse_inertia.times(arm.cross(j));
    }

    /// Takes the angular impulse `j`.
    #[inline(always)]
    pub(crate) fn turn(&mut self, j: Lanes3<L>) {
        self.w = self.w + self.inverse_inertia.times(j);
    }
}

/// Reads how far the bodies `index[k..]` have moved since the step began: Δp and Δθ.
#[inline(always)]
pub(crate) fn gather_drift<L: Lanes>(
    token: L::Token,
    rows: &Rows<'_>,
    index: &[u32; LANES],
    k: usize,
) -> (Lanes3<L>, Lanes3<L>) {
    rows.drifts.has(&index[k..k + L::WIDTH]);
    // SAFETY: all of these rows are there, and no sweep that reads drifts through this function writes any.
    let drift = |i: usize| unsafe { &rows.drifts.get_unchecked(index[k + i] as usize).0 };
    let [px, py, pz, rx, ry, rz, _, _] = L::gather(token, drift);
    (Lanes3::new(px, py, pz), Lanes3::new(rx, ry, rz))
}
