//! The choice of a width at run time.

use super::Lanes;
use fearless_simd::{Level, Simd, f32x4};
#[cfg(target_arch = "x86_64")]
use fearless_simd::{f32x8, f32x16};
use std::sync::OnceLock;

/// What shows that the processor has registers of 4, 8 and 16 lanes.
#[cfg(target_arch = "x86_64")]
use fearless_simd::x86::{Avx2 as OfEight, Avx512 as OfSixteen, Sse2 as OfFour};

/// Code that runs at any width. Everything that it calls must be `#[inline(always)]`, or the instructions of the
/// wide registers don't reach it.
pub trait Kernel {
    /// What it returns.
    type Output;
    /// Runs at the width of `L`.
    fn run<L: Lanes>(self, token: L::Token) -> Self::Output;
}

/// A number of lanes together with the instruction set that carries it.
///
/// A kernel is compiled once for each: on registers that are narrower it would only be slower than with fewer lanes, and gives the same bits with those.
#[derive(Clone, Copy, Debug)]
pub enum Width {
    /// One number at a time.
    Scalar,
    /// 4 lanes: what every machine has.
    #[cfg(target_arch = "x86_64")]
    Four(OfFour),
    /// 8 lanes.
    #[cfg(target_arch = "x86_64")]
    Eight(OfEight),
    /// 16 lanes.
    #[cfg(target_arch = "x86_64")]
    Sixteen(OfSixteen),
    /// 4 lanes: what every machine has.
    #[cfg(not(target_arch = "x86_64"))]
    Four(Level),
}

impl Width {
    /// As many lanes as the machine's registers have.
    #[inline]
    pub fn native() -> Self {
        Self::most()[3]
    }

    /// 1, 4, 8 or 16 lanes, but no more than the machine's registers have; 0 means as many.
    #[inline]
    pub fn new(lanes: usize) -> Self {
        Self::native().at_most(if lanes == 0 { usize::MAX } else { lanes })
    }

    /// No more than so many lanes: for kernels that have no more to do side by side.
    #[inline]
    pub fn at_most(self, lanes: usize) -> Self {
        if self.lanes() <= lanes {
            return self;
        }
        Self::most()[usize::from(lanes >= 4) + usize::from(lanes >= 8) + usize::from(lanes >= 16)]
    }

    /// Every width that the machine has, ascending.
    pub fn all() -> impl Iterator<Item = Self> {
        let most = Self::most().iter().copied();
        most.zip([1, 4, 8, 16]).filter(|(width, lanes)| width.lanes() == *lanes).map(|(width, _)| width)
    }

    /// What comes nearest to 1, 4, 8 and 16 lanes.
    #[inline]
    fn most() -> &'static [Self; 4] {
        /// The machine is asked once.
        static MOST: OnceLock<[Width; 4]> = OnceLock::new();
        MOST.get_or_init(|| {
            let mut most = [Width::Scalar; 4];
            for (k, width) in Self::wide().into_iter().enumerate() {
                most[k + 1] = width.unwrap_or(most[k]);
            }
            most
        })
    }

    /// Those of 4, 8 and 16 lanes.
    #[cfg(target_arch = "x86_64")]
    fn wide() -> [Option<Self>; 3] {
        let level = Level::new();
        [
            level.as_sse2().map(Width::Four),
            level.as_avx2().map(Width::Eight),
            level.as_avx512().map(Width::Sixteen),
        ]
    }

    /// Those of 4, 8 and 16 lanes.
    #[cfg(not(target_arch = "x86_64"))]
    fn wide() -> [Option<Self>; 3] {
        [Some(Width::Four(Level::new())), None, None]
    }

    /// Number of lanes.
    #[inline]
    pub fn lanes(self) -> usize {
        match self {
            Width::Scalar => 1,
            Width::Four(_) => 4,
            #[cfg(target_arch = "x86_64")]
            Width::Eight(_) => 8,
            #[cfg(target_arch = "x86_64")]
            Width::Sixteen(_) => 16,
        }
    }

    /// Runs a kernel at this width.
    #[inline]
    #[cfg(target_arch = "x86_64")]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self {
            Width::Scalar => kernel.run::<f32>(()),
            Width::Four(simd) => Four(kernel).at(simd),
            Width::Eight(simd) => Eight(kernel).at(simd),
            Width::Sixteen(simd) => Sixteen(kernel).at(simd),
        }
    }

    /// Runs a kernel at this width.
    #[inline]
    #[cfg(not(target_arch = "x86_64"))]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self {
            Width::Scalar => kernel.run::<f32>(()),
            Width::Four(level) => fearless_simd::dispatch!(level, simd => Four(kernel).at(simd)),
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
#[cfg(target_arch = "x86_64")]
placed!(Eight, f32x8);
#[cfg(target_arch = "x86_64")]
placed!(Sixteen, f32x16);
