//! Sweeps: one kernel over all blocks, colour after colour.

use crate::batch::{Batches, Class, Span};
use crate::block::{Block, Cold, LANES};
use crate::line::{Columns, Drift, Line};
use rayon::prelude::*;
use rockfall_math::disjoint::DisjointRows;
use rockfall_math::lanes::{Kernel, Lanes, Lanes3, Row, Width};

/// A layer with fewer blocks is not worth waking a second thread for. Results don't depend on it.
const WORTH_SHARING: usize = 12;

/// The rows that the contacts of a sweep read and write.
pub(crate) struct Rows<'a> {
    pub(crate) lines: DisjointRows<'a, Line>,
    pub(crate) drifts: DisjointRows<'a, Drift>,
}

impl<'a> Rows<'a> {
    pub(crate) fn new(columns: &'a mut Columns<'_>) -> Self {
        Rows { lines: DisjointRows::new(columns.lines), drifts: DisjointRows::new(columns.drifts) }
    }
}

/// What a sweep does to `L::WIDTH` lanes of a block, from lane `k` on.
pub(crate) trait Visit: Sync {
    fn visit<L: Lanes, const P: usize, const T: usize>(
        &self,
        token: L::Token,
        rows: &Rows<'_>,
        block: &mut Block<P, T>,
        cold: Option<&mut Cold>,
        k: usize,
        one_sided: bool,
    );
}

/// Runs `visit` over every block of `batches`, in their order.
pub(crate) fn sweep<V: Visit>(batches: &mut Batches, rows: &Rows<'_>, width: Width, visit: &V) {
    let Batches { one, two, four, colds, spans, layers, .. } = batches;
    let shelves = Shelves {
        one: DisjointRows::new(&mut one.blocks),
        two: DisjointRows::new(&mut two.blocks),
        four: DisjointRows::new(&mut four.blocks),
        colds: DisjointRows::new(colds),
    };
    for layer in layers.iter() {
        let spans = &spans[layer.spans.clone()];
        if layer.serial {
            for span in spans {
                Width::Scalar.run(OverSpan { span, shelves: &shelves, rows, visit });
            }
        } else if layer.blocks < WORTH_SHARING || rayon::current_num_threads() == 1 {
            for span in spans {
                width.run(OverSpan { span, shelves: &shelves, rows, visit });
            }
        } else {
            spans
                .par_iter()
                .with_max_len(1)
                .for_each(|span| width.run(OverSpan { span, shelves: &shelves, rows, visit }));
        }
    }
}

struct Shelves<'a> {
    one: DisjointRows<'a, Block<1, 0>>,
    two: DisjointRows<'a, Block<2, 1>>,
    four: DisjointRows<'a, Block<4, 1>>,
    colds: DisjointRows<'a, Cold>,
}

struct OverSpan<'a, 'b, V> {
    span: &'a Span,
    shelves: &'a Shelves<'b>,
    rows: &'a Rows<'b>,
    visit: &'a V,
}

impl<V: Visit> Kernel for OverSpan<'_, '_, V> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self, token: L::Token) {
        match self.span.class {
            Class::One => self.over::<L, 1, 0>(token, &self.shelves.one),
            Class::Two => self.over::<L, 2, 1>(token, &self.shelves.two),
            Class::Four => self.over::<L, 4, 1>(token, &self.shelves.four),
        }
    }
}

impl<V: Visit> OverSpan<'_, '_, V> {
    #[inline(always)]
    fn over<L: Lanes, const P: usize, const T: usize>(
        &self,
        token: L::Token,
        shelf: &DisjointRows<'_, Block<P, T>>,
    ) {
        let span = self.span;
        for i in span.from..span.to {
            // SAFETY: spans don't share blocks, and each span is visited by one thread at a time.
            let block = unsafe { shelf.row(i) };
            // SAFETY: likewise; cold halves are numbered along the spans.
            let mut cold = span.cold.map(|from| unsafe { self.shelves.colds.row(from + i - span.from) });
            for k in (0..LANES).step_by(L::WIDTH) {
                // Lanes are filled from the front; the first body of one in use is never the world.
                if block.a[k] == 0 {
                    break;
                }
                self.visit.visit::<L, P, T>(token, self.rows, block, cold.as_deref_mut(), k, span.one_sided);
            }
        }
    }
}

/// A body in each lane.
pub(crate) struct BodyLanes<L> {
    pub(crate) v: Lanes3<L>,
    pub(crate) w: Lanes3<L>,
    pub(crate) inverse_mass: L,
    pub(crate) gravity_scale: L,
    pub(crate) inverse_inertia: Symmetric<L>,
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
    /// Reads the bodies `index[k..]`. Bodies that contacts can't move keep an inverse inertia of zero.
    #[inline(always)]
    pub(crate) fn gather(
        token: L::Token,
        rows: &Rows<'_>,
        index: &[u32; LANES],
        k: usize,
        movable: bool,
    ) -> Self {
        // SAFETY: within a layer no other thread writes a body of these lanes; bodies that can't be moved are written
        // by none.
        let line = |i: usize| unsafe { rows.lines.get(index[k + i] as usize) };
        let [vx, vy, vz, wx, wy, wz, inverse_mass, gravity_scale] = L::gather(token, |i| &line(i).motion);
        let inverse_inertia = if movable {
            let [xx, xy, xz, yy, yz, zz, _, _] = L::gather(token, |i| &line(i).inertia);
            Symmetric([xx, xy, xz, yy, yz, zz])
        } else {
            Symmetric([L::splat(token, 0.0); 6])
        };
        BodyLanes {
            v: Lanes3::new(vx, vy, vz),
            w: Lanes3::new(wx, wy, wz),
            inverse_mass: if movable { inverse_mass } else { L::splat(token, 0.0) },
            gravity_scale,
            inverse_inertia,
        }
    }

    /// Writes the velocities back; lanes that are not in use (row 0) write nothing.
    #[inline(always)]
    pub(crate) fn scatter(self, rows: &Rows<'_>, index: &[u32; LANES], k: usize) {
        let BodyLanes { v, w, inverse_mass, gravity_scale, .. } = self;
        let columns = [v.x, v.y, v.z, w.x, w.y, w.z, inverse_mass, gravity_scale];
        L::scatter(columns, |i, motion: Row| {
            let row = index[k + i] as usize;
            if row != 0 {
                // SAFETY: within a layer no two lanes and no two threads hold the same movable body.
                unsafe { rows.lines.row(row).motion = motion };
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
    // SAFETY: no sweep that reads drifts through this function writes any.
    let drift = |i: usize| unsafe { &rows.drifts.get(index[k + i] as usize).0 };
    let [px, py, pz, rx, ry, rz, _, _] = L::gather(token, drift);
    (Lanes3::new(px, py, pz), Lanes3::new(rx, ry, rz))
}
