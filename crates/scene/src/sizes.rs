//! Distributions of sizes, cut into classes.
//!
//! Shapes are shared by bodies, so a size is drawn from a few classes, all equally likely: class k of n has the size
//! below which the share (k + ½) / n of the distribution lies.

use crate::node::Table;
use crate::spec::{Key, POSITIVE, Range, Spec, Ty, key, required};

const WORDS: &[&str] = &["uniform", "log-normal", "power-law"];
const EXPONENT: Range = Range { min: 0.0, max: 10.0 };

/// The shape of a distribution; the limits come beside it.
pub(crate) const DISTRIBUTION: &[Key] = &[
    key(
        "distribution",
        Ty::Choice(WORDS),
        "\"uniform\"",
        "`uniform`; `log-normal` with the limits two standard deviations of the logarithm from its median, cut off \
         there; `power-law`: the number of sizes per metre falls with size to the power of -`exponent`.",
    ),
    key("exponent", Ty::Number(EXPONENT), "2.5", "Of the power law. Broken rock has 2 to 3.5."),
];

/// The key `size` of generators.
pub(crate) static SIZES: Spec = Spec {
    name: "size",
    about: "Random sizes: each body's shape is scaled by a factor drawn from this distribution.",
    example: r#"size = { min = 0.5, max = 2, distribution = "log-normal", classes = 32 }
"#,
    groups: &[
        &[
            required("min", Ty::Number(POSITIVE), "Smallest factor."),
            required("max", Ty::Number(POSITIVE), "Largest factor, not below `min`."),
            key(
                "classes",
                Ty::Int(1, 1024),
                "16",
                "The distribution is cut into so many equally likely sizes, each one shape that bodies share.",
            ),
        ],
        DISTRIBUTION,
    ],
};

/// A distribution of sizes between two limits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Sizes {
    law: Law,
    min: f64,
    max: f64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Law {
    Uniform,
    LogNormal,
    Power(f64),
}

impl Sizes {
    /// `table` has the keys of [`DISTRIBUTION`].
    pub(crate) fn read(table: &Table, min: f64, max: f64) -> Self {
        let law = match table.text("distribution") {
            "log-normal" => Law::LogNormal,
            "power-law" => Law::Power(table.f64("exponent")),
            _ => Law::Uniform,
        };
        Sizes { law, min, max }
    }

    /// The size below which the share `p` of the distribution lies.
    pub(crate) fn quantile(&self, p: f64) -> f64 {
        let (min, max) = (self.min, self.max);
        let size = match self.law {
            Law::Uniform => min + (max - min) * p,
            Law::LogNormal => {
                let sigma = libm::log(max / min) / 4.0;
                let (low, high) = (normal_share(-2.0), normal_share(2.0));
                (min * max).sqrt() * libm::exp(sigma * normal_quantile(low + (high - low) * p))
            }
            Law::Power(exponent) => {
                let e = 1.0 - exponent;
                if e.abs() < 1e-9 {
                    min * libm::pow(max / min, p)
                } else {
                    // Relative to the smallest size, so that no power overflows.
                    let top = libm::pow(max / min, e);
                    min * libm::pow(1.0 + (top - 1.0) * p, 1.0 / e)
                }
            }
        };
        size.clamp(min, max)
    }

    /// The sizes of the classes, ascending.
    pub(crate) fn classes(&self, n: usize) -> Vec<f64> {
        (0..n).map(|k| self.quantile((k as f64 + 0.5) / n as f64)).collect()
    }
}

/// Share of the normal distribution below `z`.
fn normal_share(z: f64) -> f64 {
    0.5 * libm::erfc(-z * std::f64::consts::FRAC_1_SQRT_2)
}

/// Inverse of [`normal_share`] within two standard deviations, by bisection down to the last bits.
fn normal_quantile(p: f64) -> f64 {
    let (mut low, mut high) = (-2.5, 2.5);
    for _ in 0..60 {
        let mid = 0.5 * (low + high);
        if normal_share(mid) < p { low = mid } else { high = mid }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAWS: [Law; 4] = [Law::Uniform, Law::LogNormal, Law::Power(2.5), Law::Power(1.0)];

    #[test]
    fn quantiles_run_from_the_smallest_to_the_largest_size() {
        for law in LAWS {
            let sizes = Sizes { law, min: 0.3, max: 1.2 };
            assert!((sizes.quantile(0.0) - 0.3).abs() < 1e-9, "{law:?}");
            assert!((sizes.quantile(1.0) - 1.2).abs() < 1e-9, "{law:?}");
            assert!(sizes.classes(16).is_sorted());
        }
    }

    #[test]
    fn quantiles_invert_the_closed_form_of_each_distribution() {
        let (min, max): (f64, f64) = (0.3, 1.2);
        for p in [0.1, 0.5, 0.9] {
            let power = Sizes { law: Law::Power(2.5), min, max }.quantile(p);
            let share = (min.powf(-1.5) - power.powf(-1.5)) / (min.powf(-1.5) - max.powf(-1.5));
            assert!((share - p).abs() < 1e-12);
            let log = Sizes { law: Law::Power(1.0), min, max }.quantile(p);
            assert!(((log / min).ln() / (max / min).ln() - p).abs() < 1e-12);
        }
        let median = Sizes { law: Law::LogNormal, min, max }.quantile(0.5);
        assert!((median - (min * max).sqrt()).abs() < 1e-9);
        // 84.134 % of a normal distribution lie below one standard deviation; 95.45 % within two.
        let one = Sizes { law: Law::LogNormal, min, max }.quantile((0.841_345 - 0.022_75) / 0.9545);
        assert!(((one / median).ln() - (max / min).ln() / 4.0).abs() < 1e-4);
    }
}
