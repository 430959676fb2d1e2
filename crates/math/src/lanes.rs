//! Equations once: arithmetic generic over the number of lanes, chosen at run time.
//!
//! A kernel is written against [`Lanes`] and wrapped in a [`Kernel`]; [`Width::run`] calls it with 1, 4, 8 or 16 lanes.
//! Only operations that IEEE 754 rounds the same way everywhere are offered: no fused multiply-add, no approximate
//! reciprocal, and minimum and maximum by comparison, so that each lane gives the bits that a scalar gives.

mod vector;
mod width;

pub use vector::Lanes3;
pub use width::{Kernel, Width};

use core::ops::{Add, Div, Mul, Neg, Sub};
use fearless_simd::{Simd, SimdBase, SimdFloat, f32x4, f32x8, f32x16, prelude::*};

/// Rows that [`Lanes::gather`] reads: eight numbers, half a cache line.
pub type Row = [f32; 8];

/// A vector of `WIDTH` single-precision numbers.
pub trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// Number of lanes: 1, 4, 8 or 16.
    const WIDTH: usize;
    /// Proof that the machine has the instructions.
    type Token: Copy + Send + Sync;
    /// One truth value per lane.
    type Mask: Copy;

    /// The same number in every lane.
    fn splat(token: Self::Token, x: f32) -> Self;
    /// The first `WIDTH` numbers of `from`.
    fn load(token: Self::Token, from: &[f32]) -> Self;
    /// Writes to the first `WIDTH` numbers of `to`.
    fn store(self, to: &mut [f32]);
    /// Square root, correctly rounded.
    fn sqrt(self) -> Self;
    /// Without its sign.
    fn abs(self) -> Self;
    /// self < other.
    fn lt(self, other: Self) -> Self::Mask;
    /// `yes` where the mask holds, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// Bit i tells whether the mask holds in lane i.
    fn bits(mask: Self::Mask) -> u16;
    /// Transposes `WIDTH` rows: lane i of column k is `row(i)[k]`.
    fn gather<'a>(token: Self::Token, row: impl Fn(usize) -> &'a Row) -> [Self; 8];
    /// The opposite of [`Lanes::gather`]: calls `row` once for each lane.
    fn scatter(columns: [Self; 8], row: impl FnMut(usize, Row));

    /// The smaller one in each lane, `other` where they can't be compared.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(self.lt(other), self, other)
    }

    /// The larger one in each lane, `other` where they can't be compared.
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(other.lt(self), self, other)
    }
}

impl Lanes for f32 {
    const WIDTH: usize = 1;
    type Token = ();
    type Mask = bool;

    #[inline(always)]
    fn splat(_: (), x: f32) -> Self {
        x
    }
    #[inline(always)]
    fn load(_: (), from: &[f32]) -> Self {
        from[0]
    }
    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        to[0] = self;
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f32::sqrt(self)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f32::abs(self)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self < other
    }
    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
    #[inline(always)]
    fn bits(mask: bool) -> u16 {
        mask.into()
    }
    #[inline(always)]
    fn gather<'a>(_: (), row: impl Fn(usize) -> &'a Row) -> [Self; 8] {
        *row(0)
    }
    #[inline(always)]
    fn scatter(columns: [Self; 8], mut row: impl FnMut(usize, Row)) {
        row(0, columns);
    }
}

/// The parts of [`Lanes`] that read the same for every vector type of `fearless_simd`.
macro_rules! vector_lanes {
    ($vector:ident, $width:literal) => {
        const WIDTH: usize = $width;
        type Token = S;
        type Mask = <$vector<S> as SimdBase<S>>::Mask;

        #[inline(always)]
        fn splat(token: S, x: f32) -> Self {
            $vector::simd_from(token, x)
        }
        #[inline(always)]
        fn load(token: S, from: &[f32]) -> Self {
            $vector::from_slice(token, &from[..$width])
        }
        #[inline(always)]
        fn store(self, to: &mut [f32]) {
            self.store_slice(&mut to[..$width]);
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            SimdFloat::sqrt(self)
        }
        #[inline(always)]
        fn abs(self) -> Self {
            SimdBase::abs(self)
        }
        #[inline(always)]
        fn lt(self, other: Self) -> Self::Mask {
            self.simd_lt(other)
        }
        #[inline(always)]
        fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
            mask.select(yes, no)
        }
        #[inline(always)]
        fn bits(mask: Self::Mask) -> u16 {
            mask.to_bitmask() as u16
        }
    };
}

/// One round of a transposition: neighbours in the two halves of the list become neighbours in a vector. After log2(n)
/// rounds n vectors of n lanes are transposed.
#[inline(always)]
fn shuffle<S: Simd, V: SimdBase<S>, const N: usize>(rows: [V; N]) -> [V; N] {
    core::array::from_fn(|k| {
        let (a, b) = (rows[k / 2], rows[k / 2 + N / 2]);
        if k % 2 == 0 { a.zip_low(b) } else { a.zip_high(b) }
    })
}

impl<S: Simd> Lanes for f32x4<S> {
    vector_lanes!(f32x4, 4);

    #[inline(always)]
    fn gather<'a>(token: S, row: impl Fn(usize) -> &'a Row) -> [Self; 8] {
        let half = |from: usize| {
            let rows: [Self; 4] = core::array::from_fn(|i| Self::from_slice(token, &row(i)[from..from + 4]));
            shuffle(shuffle(rows))
        };
        let (low, high) = (half(0), half(4));
        core::array::from_fn(|k| if k < 4 { low[k] } else { high[k - 4] })
    }
    #[inline(always)]
    fn scatter(columns: [Self; 8], mut row: impl FnMut(usize, Row)) {
        let low: [Self; 4] = shuffle(shuffle(core::array::from_fn(|k| columns[k])));
        let high: [Self; 4] = shuffle(shuffle(core::array::from_fn(|k| columns[k + 4])));
        for i in 0..4 {
            let mut out = [0.0; 8];
            low[i].store_slice(&mut out[..4]);
            high[i].store_slice(&mut out[4..]);
            row(i, out);
        }
    }
}

impl<S: Simd> Lanes for f32x8<S> {
    vector_lanes!(f32x8, 8);

    #[inline(always)]
    fn gather<'a>(token: S, row: impl Fn(usize) -> &'a Row) -> [Self; 8] {
        let rows: [Self; 8] = core::array::from_fn(|i| Self::from_slice(token, row(i)));
        shuffle(shuffle(shuffle(rows)))
    }
    #[inline(always)]
    fn scatter(columns: [Self; 8], mut row: impl FnMut(usize, Row)) {
        let rows = shuffle(shuffle(shuffle(columns)));
        for (i, lanes) in rows.iter().enumerate() {
            let mut out = [0.0; 8];
            lanes.store_slice(&mut out);
            row(i, out);
        }
    }
}

impl<S: Simd> Lanes for f32x16<S> {
    vector_lanes!(f32x16, 16);

    #[inline(always)]
    fn gather<'a>(token: S, row: impl Fn(usize) -> &'a Row) -> [Self; 8] {
        let low = f32x8::gather(token, &row);
        let high = f32x8::gather(token, |i| row(i + 8));
        core::array::from_fn(|k| low[k].combine(high[k]))
    }
    #[inline(always)]
    fn scatter(columns: [Self; 8], mut row: impl FnMut(usize, Row)) {
        f32x8::scatter(core::array::from_fn(|k| columns[k].split().0), &mut row);
        f32x8::scatter(core::array::from_fn(|k| columns[k].split().1), |i, out| row(i + 8, out));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct RoundTrip;
    impl Kernel for RoundTrip {
        type Output = ();
        fn run<L: Lanes>(self, token: L::Token) {
            let table: Vec<Row> = (0..32).map(|i| core::array::from_fn(|k| (i * 8 + k) as f32)).collect();
            let pick = |lane: usize| (lane * 7 + 3) % 32;
            let columns = L::gather(token, |lane| &table[pick(lane)]);
            for (k, column) in columns.iter().enumerate() {
                let mut lanes = [0.0; 16];
                column.store(&mut lanes);
                for (lane, &x) in lanes[..L::WIDTH].iter().enumerate() {
                    assert_eq!(x, table[pick(lane)][k]);
                }
            }
            let above = L::bits(L::splat(token, 12.0).lt(columns[0]));
            assert!((0..16).all(|i| (above >> i & 1 == 1) == (i < L::WIDTH && pick(i) * 8 > 12)));
            let mut seen = 0;
            L::scatter(columns, |lane, row| {
                assert_eq!(row, table[pick(lane)]);
                seen += 1;
            });
            assert_eq!(seen, L::WIDTH);
        }
    }

    #[test]
    fn gather_and_scatter_are_transpositions_at_every_width() {
        for width in Width::all() {
            width.run(RoundTrip);
        }
    }

    /// A chain of every operation over awkward numbers; returns the bits of lane 0 of each batch in order.
    struct Chain<'a>(&'a [f32]);
    impl Kernel for Chain<'_> {
        type Output = Vec<u32>;
        fn run<L: Lanes>(self, token: L::Token) -> Vec<u32> {
            let mut out = vec![0.0; self.0.len()];
            for (from, to) in self.0.chunks_exact(L::WIDTH).zip(out.chunks_exact_mut(L::WIDTH)) {
                let x = L::load(token, from);
                let third = L::splat(token, 1.0 / 3.0);
                let y = (x * x + third).sqrt() / (x - third).abs();
                let z = L::select(x.lt(y), x.max(-y), y.min(x * third));
                (z + x * y - third).store(to);
            }
            out.iter().map(|x| x.to_bits()).collect()
        }
    }

    #[test]
    fn every_width_gives_the_same_bits() {
        let mut numbers: Vec<f32> =
            (0..4096).map(|i| f32::from_bits(crate::hash::mix(i) as u32 & 0xbfff_ffff)).collect();
        numbers[..4].copy_from_slice(&[0.0, -0.0, 1e-42, -3.0e38]);
        let scalar = Width::Scalar.run(Chain(&numbers));
        for width in Width::all() {
            assert_eq!(scalar, width.run(Chain(&numbers)), "{width:?}");
        }
    }
}
