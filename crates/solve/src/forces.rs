//! What contacts did in the last sub-step, all together: the momentum that immovable bodies gave, and how much of Coulomb's bound was used.
//! Nothing here depends on the order of the blocks.

use crate::block::{Block, Column, LANES, get3, tangents_of};
use crate::contacts::Contacts;
use crate::shelf::{Key, Shelf};
use rayon::prelude::*;
use rockfall_math::DVec3;
use rockfall_math::share::Share;

/// Sums over all contacts that are not parked.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Forces {
    /// Units of momentum along x, y, z; whole, so that their sum does not know in which order they are added.
    units: [i128; 3],
    /// The square of the largest share of Coulomb's bound.
    friction: f32,
}

impl Forces {
    fn and(self, other: Forces) -> Forces {
        let [[x, y, z], [u, v, w]] = [self.units, other.units];
        Forces { units: [x + u, y + v, z + w], friction: self.friction.max(other.friction) }
    }

    /// Momentum that bodies which contacts can't move gave to those that they can, N s; `unit` as [`Contacts::forces`] had it.
    pub fn support(&self, unit: f64) -> DVec3 {
        DVec3::from_array(self.units.map(|units| units as f64 * unit))
    }

    /// The largest friction impulse of a contact over its bound, μ times its normal impulses: at most 1, and infinite for friction without
    /// pressure.
    pub fn friction(&self) -> f64 {
        f64::from(self.friction).sqrt()
    }
}

impl Contacts {
    /// Adds up the impulses of the last sub-step, of bodies that are `awake`. Momentum is rounded to whole `unit`s, N s.
    pub fn forces(&self, unit: f64, awake: impl Fn(u32) -> bool + Sync) -> Forces {
        let awake = |row: u32| awake(self.copies.body(row));
        let of_balls = shelf(&self.ball, unit, &awake).and(shelf(&self.one, unit, &awake));
        of_balls.and(shelf(&self.two, unit, &awake)).and(shelf(&self.four, unit, &awake))
    }
}

fn shelf<const P: usize, const T: usize>(
    shelf: &Shelf<P, T>,
    unit: f64,
    awake: &(impl Fn(u32) -> bool + Sync),
) -> Forces {
    let blocks = shelf.blocks.par_iter().zip(&shelf.keys).with_min_len(16).shared();
    let add = |forces: Forces, (block, key): (&Block<P, T>, &Key)| {
        if key.is_parked() { forces } else { forces.and(block_of(block, key.is_one_sided(), unit, awake)) }
    };
    blocks.fold(Forces::default, add).reduce(Forces::default, Forces::and)
}

fn block_of<const P: usize, const T: usize>(
    block: &Block<P, T>,
    one_sided: bool,
    unit: f64,
    awake: &impl Fn(u32) -> bool,
) -> Forces {
    let mut pressed: Column = [0.0; LANES];
    for impulses in &block.impulses {
        pressed = core::array::from_fn(|lane| pressed[lane] + impulses[lane]);
    }
    let [along_s, along_t] = &block.tangent_impulse;
    let shares: Column = core::array::from_fn(|lane| {
        let bound = block.friction[lane] * pressed[lane];
        let squared = along_s[lane] * along_s[lane] + along_t[lane] * along_t[lane];
        if squared > 0.0 { squared / (bound * bound) } else { 0.0 }
    });
    let friction = shares.into_iter().fold(0.0, f32::max);
    let mut forces = Forces { friction, ..Forces::default() };
    if one_sided {
        for lane in (0..LANES).filter(|&lane| block.a[lane] != 0 && awake(block.a[lane])) {
            let n = get3(&block.normal, lane);
            let (s, t) = tangents_of(n);
            // The normal points away from the body that is pushed.
            let j = -(n * pressed[lane] + s * along_s[lane] + t * along_t[lane]).as_dvec3() / unit;
            for (sum, part) in forces.units.iter_mut().zip(j.to_array()) {
                *sum += i128::from(part.round() as i64);
            }
        }
    }
    forces
}
