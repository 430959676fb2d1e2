//! Numbers as people read them.

/// Five digits at most, in powers of ten where zeros would be long.
pub(crate) fn number(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    if !value.is_finite() {
        return value.to_string();
    }
    let size = value.abs();
    if !(1e-3..1e6).contains(&size) {
        let text = format!("{value:.2e}");
        return text.replace(".00e", "e");
    }
    let whole = size.log10().floor() as i32;
    let text = format!("{value:.*}", (4 - whole).clamp(0, 6) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// A number with its unit.
pub(crate) fn with_unit(value: f64, unit: &str) -> String {
    if unit.is_empty() { number(value) } else { format!("{} {unit}", number(value)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_short_and_keep_what_matters() {
        let texts = [0.0, 1.0, 0.0186, 185.03, 24034.5, 1.35e-4, -2.5, 7.4e6, 0.26794919].map(number);
        assert_eq!(texts, ["0", "1", "0.0186", "185.03", "24034", "1.35e-4", "-2.5", "7.40e6", "0.26795"]);
        assert_eq!(with_unit(2.0, "m/s"), "2 m/s");
        assert_eq!(number(f64::NAN), "NaN");
    }
}
