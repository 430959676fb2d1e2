//! The straight line through points.

/// Slope, offset and R² of the line with the least sum of squares.
pub(super) fn through(points: &[(f64, f64)]) -> (f64, f64, f64) {
    let n = points.len() as f64;
    let mean = |value: fn(&(f64, f64)) -> f64| points.iter().map(value).sum::<f64>() / n;
    let (x, y) = (mean(|p| p.0), mean(|p| p.1));
    let sum = |value: &dyn Fn(f64, f64) -> f64| points.iter().map(|p| value(p.0 - x, p.1 - y)).sum::<f64>();
    let (xx, xy, yy) = (sum(&|a, _| a * a), sum(&|a, b| a * b), sum(&|_, b| b * b));
    (xy / xx, y - xy / xx * x, xy * xy / (xx * yy))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_is_found() {
        let (slope, offset, r) = through(&[(1.0, 1.0), (2.0, 3.0), (4.0, 7.0)]);
        assert!((slope - 2.0).abs() < 1e-12 && (offset + 1.0).abs() < 1e-12 && (r - 1.0).abs() < 1e-12);
    }
}
