//! Many pairs at once: those of a kind are gathered until they fill the lanes, and met side by side.
//!
//! ```text
//!   pairs ──▶ two boxes ──────────────▶ apart along the last axis? ──▶ 16: gaps along all axes ──▶ one by one: manifold
//!         ├─▶ a ball and a box, a capsule or a ball ──▶ 16: nearest points ──▶ one by one: manifold
//!         └─▶ all others: one by one; hulls use the lanes for their faces and edges
//! ```
//!
//! What is found is what [`collide`](crate::collide) finds, to the bit.

mod balls;

use crate::box_box::gaps::{Gaps, Measure, Pair, Pairs, SIDE};
use crate::box_box::{apart, collide_with};
use crate::{Cache, Manifold, collide, is_finite};
use balls::Balls;
use rockfall_math::Isometry;
use rockfall_math::lanes::Width;
use rockfall_shape::Shape;
use std::ops::Range;

/// Two shapes that are to be met; see [`collide`](crate::collide).
#[derive(Clone, Copy, Debug)]
pub struct Meeting<'a> {
    /// Shape A.
    pub a: &'a Shape,
    /// Shape B.
    pub b: &'a Shape,
    /// Places B in A's frame.
    pub b_in_a: &'a Isometry,
    /// Points of a larger signed distance do not count, metres.
    pub margin: f32,
}

/// What came of a [`Meeting`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Met {
    /// How far apart the two are at least, metres; 0 where that is not known.
    pub apart: f32,
    /// Their manifolds.
    pub manifolds: Range<usize>,
}

/// Meets many pairs. `meeting(i)` is the one that `caches[i]` belongs to; pairs that are none are left alone. `mets[i]` tells which of the manifolds in
/// `out` are theirs; both are cleared first. `width` changes no bit.
///
/// # Examples
/// ```
/// use rockfall_collide::{Cache, Meeting, collide_all};
/// use rockfall_math::{Isometry, Vec3, lanes::Width};
/// use rockfall_shape::Shape;
///
/// let ball = Shape::Sphere { radius: 1.0 };
/// let places = [1.9, 2.1].map(|x| Isometry { translation: Vec3::X * x, ..Isometry::IDENTITY });
/// let meeting = |i: usize| Some(Meeting { a: &ball, b: &ball, b_in_a: &places[i], margin: 0.01 });
/// let (mut mets, mut out) = (Vec::new(), Vec::new());
/// collide_all(Width::native(), meeting, &mut [Cache::default(); 2], &mut mets, &mut out);
/// assert_eq!(out[mets[0].manifolds.clone()].len(), 1);
/// assert!(mets[1].manifolds.is_empty() && (mets[1].apart - 0.1).abs() < 1e-6);
/// ```
pub fn collide_all<'a>(
    width: Width,
    meeting: impl Fn(usize) -> Option<Meeting<'a>>,
    caches: &mut [Cache],
    mets: &mut Vec<Met>,
    out: &mut Vec<Manifold>,
) {
    out.clear();
    mets.clear();
    mets.resize(caches.len(), Met::default());
    let mut found = Found { caches, mets, out };
    let (mut boxes, mut balls) = (Boxes::default(), Balls::default());
    for i in 0..found.caches.len() {
        let Some(pair) = meeting(i).filter(|pair| is_finite(pair.b_in_a)) else { continue };
        match (pair.a, pair.b) {
            (Shape::Box { half: a }, Shape::Box { half: b }) => {
                let own = Pair::new(*a, *b, pair.b_in_a);
                if let Some(apart) = apart(&own, pair.margin, found.caches[i]) {
                    found.put(i, |_, _| apart);
                } else if boxes.add(i, &own) {
                    boxes.meet(width, &meeting, &mut found);
                }
            }
            _ if balls.takes(i, &pair) => {
                if balls.is_full() {
                    balls.meet(width, &meeting, &mut found);
                }
            }
            _ => found.one(i, &pair),
        }
    }
    boxes.meet(width, &meeting, &mut found);
    balls.meet(width, &meeting, &mut found);
}

/// What was found of all pairs.
struct Found<'a> {
    caches: &'a mut [Cache],
    mets: &'a mut [Met],
    out: &'a mut Vec<Manifold>,
}

impl Found<'_> {
    /// Takes down what `find` appends, and the distance that it returns.
    fn put(&mut self, i: usize, find: impl FnOnce(&mut Cache, &mut Vec<Manifold>) -> f32) {
        let first = self.out.len();
        let apart = find(&mut self.caches[i], self.out);
        self.mets[i] = Met { apart, manifolds: first..self.out.len() };
    }

    /// A pair by itself.
    fn one(&mut self, i: usize, pair: &Meeting<'_>) {
        self.put(i, |cache, out| collide(pair.a, pair.b, pair.b_in_a, pair.margin, cache, out));
    }
}

/// Pairs of boxes that wait for the lanes to fill.
#[derive(Default)]
struct Boxes {
    pairs: Pairs,
    /// Numbers of the pairs.
    who: [usize; SIDE],
    count: usize,
}

impl Boxes {
    /// Whether the lanes are full with this one.
    fn add(&mut self, i: usize, pair: &Pair<f32>) -> bool {
        self.pairs.set(self.count, pair);
        self.who[self.count] = i;
        self.count += 1;
        self.count == SIDE
    }

    fn meet<'a>(
        &mut self,
        width: Width,
        meeting: &impl Fn(usize) -> Option<Meeting<'a>>,
        found: &mut Found<'_>,
    ) {
        if self.count == 0 {
            return;
        }
        let mut gaps = [[0.0; SIDE]; 15];
        width.run(Measure { pairs: &self.pairs, gaps: &mut gaps });
        for (lane, &i) in self.who[..self.count].iter().enumerate() {
            let Some(Meeting { b_in_a, margin, .. }) = meeting(i) else { continue };
            let own: Gaps = std::array::from_fn(|k| gaps[k][lane]);
            let pair = self.pairs.get(lane);
            found.put(i, |cache, out| collide_with(&own, &pair, b_in_a, margin, cache, out));
        }
        self.count = 0;
    }
}
