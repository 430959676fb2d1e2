//! Where something begins to give way.

use crate::Error;

/// A threshold that is searched for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search {
    /// Where it is expected.
    pub(super) expected: f64,
    /// The search goes over `expected` × (1 ± this); what lies outside is found at its end.
    pub(super) within: f64,
    /// Halvings of the interval.
    pub(super) halvings: u32,
}

impl Search {
    /// ± 8 %, found to 0.06 %.
    pub(super) fn around(expected: f64) -> Self {
        Search { expected, within: 0.08, halvings: 8 }
    }

    /// The least value at which `holds` is true, where it is true above and false below.
    pub(super) fn least(self, mut holds: impl FnMut(f64) -> Result<bool, Error>) -> Result<f64, Error> {
        let (mut low, mut high) = (self.expected * (1.0 - self.within), self.expected * (1.0 + self.within));
        for _ in 0..self.halvings {
            let middle = 0.5 * (low + high);
            if holds(middle)? {
                high = middle;
            } else {
                low = middle;
            }
        }
        Ok(0.5 * (low + high))
    }

    /// The largest value at which `holds` is true, where it is true below and false above.
    pub(super) fn largest(self, mut holds: impl FnMut(f64) -> Result<bool, Error>) -> Result<f64, Error> {
        self.least(|value| Ok(!holds(value)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_is_found_from_both_sides_and_at_the_ends() {
        let search = Search::around(1.0);
        assert!((search.least(|x| Ok(x >= 1.03)).expect("found") - 1.03).abs() < 4e-4);
        assert!((search.largest(|x| Ok(x <= 0.97)).expect("found") - 0.97).abs() < 4e-4);
        assert!((search.least(|_| Ok(true)).expect("found") - 0.92).abs() < 4e-4);
        assert!((search.least(|_| Ok(false)).expect("found") - 1.08).abs() < 4e-4);
    }
}
