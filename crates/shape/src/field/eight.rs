//! Distances of eight places at a time, as many side by side as the machine has lanes: the samples in a ball, or the balls in a larger one.
//!
//! The same bits as [`Field::distance`] and its kin give. The way down the octree is each place's own; all else is done for all of them.

use super::octree::{MOST_CUTS, Octree, WHOLE, whole_bits};
use super::samples::Balls;
use super::{Field, SAMPLES_IN_A_BALL};
use rockfall_math::lanes::{Kernel, Lanes, Lanes3, Width};
use rockfall_math::{Isometry, Vec3};

const EIGHT: usize = SAMPLES_IN_A_BALL;

impl Field {
    /// For eight places what [`Field::least_distance`] says of each, metres. `own` takes them to a frame to which `here` takes what is in this field's.
    pub fn least_distances(&self, places: &Balls, own: &Isometry, here: &Isometry) -> [f32; EIGHT] {
        let seen = self.seen(places, own, here);
        std::array::from_fn(|i| match seen.beyond(i) {
            Vec3::ZERO => seen.distances[i] - self.bound(seen.distances[i]),
            beyond => self.surely_beyond(seen.distances[i], beyond.length()),
        })
    }

    /// For eight places what [`Field::distance_below`] says of each, metres. See [`Field::least_distances`].
    pub fn distances_below(
        &self,
        places: &Balls,
        own: &Isometry,
        here: &Isometry,
        limit: f32,
    ) -> [Result<f32, f32>; EIGHT] {
        let seen = self.seen(places, own, here);
        std::array::from_fn(|i| {
            let beyond = seen.beyond(i);
            if beyond == Vec3::ZERO {
                return Ok(seen.distances[i]);
            }
            let surely = self.surely_beyond(seen.distances[i], beyond.length());
            let inside = || Vec3::new(seen.inside[0][i], seen.inside[1][i], seen.inside[2][i]);
            if surely > limit { Err(surely) } else { Ok(self.distance_beyond(inside(), beyond)) }
        })
    }

    fn seen(&self, places: &Balls, own: &Isometry, here: &Isometry) -> Seen {
        Width::native().at_most(EIGHT).run(See { octree: &self.octree, places, own, here })
    }
}

/// What the octree says of eight places.
#[derive(Default)]
struct Seen {
    /// x, y and z of the nearest places in the covered box.
    inside: [[f32; EIGHT]; 3],
    /// The ways from there, metres.
    beyond: [[f32; EIGHT]; 3],
    /// The distances there, metres.
    distances: [f32; EIGHT],
}

impl Seen {
    fn beyond(&self, i: usize) -> Vec3 {
        Vec3::new(self.beyond[0][i], self.beyond[1][i], self.beyond[2][i])
    }
}

struct See<'a> {
    octree: &'a Octree,
    places: &'a Balls,
    own: &'a Isometry,
    here: &'a Isometry,
}

impl Kernel for See<'_> {
    type Output = Seen;

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::Token) -> Seen {
        let See { octree, places, own, here } = self;
        let [right, up, out, origin] = axes::<L>(token, own);
        let [x_axis, y_axis, z_axis, center] = axes::<L>(token, here);
        let (low, high) = (Lanes3::<L>::splat(token, octree.origin), Lanes3::<L>::splat(token, octree.end()));
        let size = Lanes3::<L>::splat(token, octree.extent());
        let cell = L::splat(token, octree.cell);
        let mut seen = Seen::default();
        for l in (0..EIGHT).step_by(L::WIDTH) {
            let (x, y) = (L::load(token, &places[0][l..]), L::load(token, &places[1][l..]));
            let z = L::load(token, &places[2][l..]);
            let p = right.scale(x) + up.scale(y) + out.scale(z) + origin - center;
            let p = Lanes3::new(x_axis.dot(p), y_axis.dot(p), z_axis.dot(p));
            let inside = Lanes3::new(
                p.x.max(low.x).min(high.x),
                p.y.max(low.y).min(high.y),
                p.z.max(low.z).min(high.z),
            );
            put(inside, &mut seen.inside, l);
            put(p - inside, &mut seen.beyond, l);
            // See `Octree::spot`.
            let from = inside - low;
            let scaled = Lanes3::new(
                scaled::<L>(token, from.x / cell, size.x),
                scaled::<L>(token, from.y / cell, size.y),
                scaled::<L>(token, from.z / cell, size.z),
            );
            let cells = Lanes3::new(
                finest::<L>(token, scaled.x, size.x),
                finest::<L>(token, scaled.y, size.y),
                finest::<L>(token, scaled.z, size.z),
            );
            let mut rows = [[0.0; EIGHT]; 3];
            put(cells, &mut rows, 0);
            let (mut leaves, mut lows, mut counts) = ([0; EIGHT], [[0.0; EIGHT]; 3], [0.0; EIGHT]);
            for i in 0..L::WIDTH {
                let cell = [whole_bits(rows[0][i]), whole_bits(rows[1][i]), whole_bits(rows[2][i])];
                let (leaf, below) = octree.leaf(cell);
                leaves[i] = leaf;
                counts[i] = (1_u32 << (MOST_CUTS - below)) as f32;
                for k in 0..3 {
                    lows[k][i] = (cell[k] >> below) as f32;
                }
            }
            let low =
                Lanes3::new(L::load(token, &lows[0]), L::load(token, &lows[1]), L::load(token, &lows[2]));
            let at = scaled.scale(L::load(token, &counts)) - low;
            let c = L::gather(token, |i| &octree.leaves[leaves[i]]);
            let lower = between(between(c[0], c[1], at.x), between(c[2], c[3], at.x), at.y);
            let upper = between(between(c[4], c[5], at.x), between(c[6], c[7], at.x), at.y);
            between(lower, upper, at.z).store(&mut seen.distances[l..]);
        }
        seen
    }
}

/// The axes of a frame, and its origin.
#[inline(always)]
fn axes<L: Lanes>(token: L::Token, pose: &Isometry) -> [Lanes3<L>; 4] {
    let r = &pose.rotation;
    [
        Lanes3::splat(token, r.x_axis),
        Lanes3::splat(token, r.y_axis),
        Lanes3::splat(token, r.z_axis),
        Lanes3::splat(token, pose.translation),
    ]
}

/// A coordinate in large cells, of which there are `size`.
#[inline(always)]
fn scaled<L: Lanes>(token: L::Token, x: L, size: L) -> L {
    x.max(L::splat(token, 0.0)).min(size)
}

/// The number of the smallest cell that holds it, above 2²³.
#[inline(always)]
fn finest<L: Lanes>(token: L::Token, x: L, size: L) -> L {
    let (finest, whole) = (L::splat(token, (1 << MOST_CUTS) as f32), L::splat(token, WHOLE));
    let one = L::splat(token, 1.0);
    let x = (finest * x).min(finest * size - one);
    let near = x + whole;
    L::select(x.lt(near - whole), near - one, near)
}

#[inline(always)]
fn between<L: Lanes>(a: L, b: L, t: L) -> L {
    a + t * (b - a)
}

#[inline(always)]
fn put<L: Lanes>(v: Lanes3<L>, to: &mut [[f32; EIGHT]; 3], l: usize) {
    v.x.store(&mut to[0][l..]);
    v.y.store(&mut to[1][l..]);
    v.z.store(&mut to[2][l..]);
}
