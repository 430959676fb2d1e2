//! The choice of a width at run time.

use super::Lanes;
use fearless_simd::{Level, Simd, SimdBase, f32x4, f32x8, f32x16};
use std::sync::OnceLock;

/// Code that runs at any width. Everything that it calls must be `#[inline(always)]`, or the instructions of the
/// wide registers don't reach it.
pub trait Kernel {
    /// What it returns.
    type Output;
    /// Runs at the width of `L`.
    fn run<L: Lanes>(self, token: L::Token) -> Self::Output;
}

/// A number of lanes together with the instruction set that carries it.
#[derive(Clone, Copy, Debug)]
pub enum Width {
    /// One number at a time.
    Scalar,
    /// 4 lanes.
    Four(Level),
    /// 8 lanes; several registers each where the machine's are narrower.
    Eight(Level),
    /// 16 lanes; several registers each where the machine's are narrower.
    Sixteen(Level),
}

impl Width {
    /// As many lanes as the machine's registers have.
    pub fn native() -> Self {
        /// The machine is asked once.
        static NATIVE: OnceLock<Width> = OnceLock::new();
        *NATIVE.get_or_init(|| Self::new(0))
    }

    /// `lanes` lanes; for a number other than 1, 4, 8 or 16 as many as the machine's registers have.
    pub fn new(lanes: usize) -> Self {
        let level = Level::new();
        match lanes {
            1 => Width::Scalar,
            4 => Width::Four(level),
            8 => Width::Eight(level),
            16 => Width::Sixteen(level),
            _ => Self::new(fearless_simd::dispatch!(level, simd => native_lanes(simd))),
        }
    }

    /// Four lanes, or one where this is one: for kernels that have no more to do side by side.
    pub fn four(self) -> Self {
        match self {
            Width::Scalar => Width::Scalar,
            Width::Four(level) | Width::Eight(level) | Width::Sixteen(level) => Width::Four(level),
        }
    }

    /// Every width; all of them run on every machine.
    pub fn all() -> [Self; 4] {
        [1, 4, 8, 16].map(Self::new)
    }

    /// Number of lanes.
    pub fn lanes(self) -> usize {
        match self {
            Width::Scalar => 1,
            Width::Four(_) => 4,
            Width::Eight(_) => 8,
            Width::Sixteen(_) => 16,
        }
    }

    /// Runs a kernel at this width.
    ///
    /// On x86 a kernel is compiled for one instruction set per width, and once more for SSE2 where a machine lacks it,
    /// rather than for all four that `fearless_simd::dispatch!` would compile.
    #[inline]
    #[cfg(target_arch = "x86_64")]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self {
            Width::Scalar => kernel.run::<f32>(()),
            Width::Four(level) => baseline(level, Four(kernel)),
            Width::Eight(level) => match level.as_avx2() {
                Some(simd) => Eight(kernel).at(simd),
                None => baseline(level, Eight(kernel)),
            },
            Width::Sixteen(level) => match level.as_avx512() {
                Some(simd) => Sixteen(kernel).at(simd),
                None => baseline(level, Sixteen(kernel)),
            },
        }
    }

    /// Runs a kernel at this width.
    #[inline]
    #[cfg(not(target_arch = "x86_64"))]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self {
            Width::Scalar => kernel.run::<f32>(()),
            Width::Four(level) => fearless_simd::dispatch!(level, simd => Four(kernel).at(simd)),
            Width::Eight(level) => fearless_simd::dispatch!(level, simd => Eight(kernel).at(simd)),
            Width::Sixteen(level) => fearless_simd::dispatch!(level, simd => Sixteen(kernel).at(simd)),
        }
    }
}

/// A kernel with its width, still without an instruction set.
trait Placed {
    type Output;
    fn at<S: Simd>(self, simd: S) -> Self::Output;
}

macro_rules! placed {
    ($name:ident, $vector:ident) => {
        struct $name<K>(K);
        impl<K: Kernel> Placed for $name<K> {
            type Output = K::Output;
            #[inline(always)]
            fn at<S: Simd>(self, simd: S) -> K::Output {
                simd.vectorize(
                    #[inline(always)]
                    || self.0.run::<$vector<S>>(simd),
                )
            }
        }
    };
}

placed!(Four, f32x4);
placed!(Eight, f32x8);
placed!(Sixteen, f32x16);

#[inline]
#[cfg(target_arch = "x86_64")]
fn baseline<P: Placed>(level: Level, kernel: P) -> P::Output {
    // Every x86-64 processor has SSE2, so the level is never without it.
    match level.as_sse2() {
        Some(simd) => kernel.at(simd),
        None => unreachable!("x86-64 without SSE2"),
    }
}

#[inline(always)]
fn native_lanes<S: Simd>(_: S) -> usize {
    S::f32s::LEN
}
