//! Numbers for people.

use std::time::Duration;

/// Four significant digits with a prefix of the SI: `1.234 MJ`.
pub(crate) fn si(value: f64, unit: &str) -> String {
    const PREFIXES: [&str; 9] = ["n", "µ", "m", "", "k", "M", "G", "T", "P"];
    const NONE: i32 = 3;
    if value == 0.0 || !value.is_finite() {
        return format!("{value} {unit}");
    }
    // Rounding to four digits first keeps 999.99 from becoming "1000".
    let rounded: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    let step = (rounded.abs().log10() / 3.0).floor() as i32;
    let step = step.clamp(-NONE, PREFIXES.len() as i32 - 1 - NONE);
    let scaled = rounded / 1000f64.powi(step);
    let digits = 3 - (scaled.abs().log10().floor() as i32).clamp(0, 3);
    format!("{scaled:.*} {}{unit}", digits as usize, PREFIXES[(step + NONE) as usize])
}

/// `12,345`.
pub(crate) fn count(value: u64) -> String {
    indicatif::HumanCount(value).to_string()
}

/// `12.34 MB`, in powers of ten as disks count.
pub(crate) fn bytes(value: u64) -> String {
    indicatif::DecimalBytes(value).to_string()
}

/// `3 h 05 min`, `2 min 07 s`, `1.25 s`.
pub(crate) fn time(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    let whole = seconds.round() as u64;
    if whole >= 3600 {
        format!("{} h {:02} min", whole / 3600, whole % 3600 / 60)
    } else if whole >= 60 {
        format!("{} min {:02} s", whole / 60, whole % 60)
    } else {
        format!("{seconds:.2} s")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn si_keeps_four_digits() {
        assert_eq!(si(0.0, "J"), "0 J");
        assert_eq!(si(1234.4, "J"), "1.234 kJ");
        assert_eq!(si(-0.0312, "m"), "-31.20 mm");
        assert_eq!(si(999.99, "m"), "1.000 km");
        assert_eq!(si(5.0, "s"), "5.000 s");
        assert_eq!(si(2.6e-12, "m"), "0.003 nm");
        assert_eq!(si(3.0e20, "J"), "300000 PJ");
        assert_eq!(si(f64::NAN, "J"), "NaN J");
    }

    #[test]
    fn times_read_as_people_say_them() {
        assert_eq!(time(Duration::from_millis(1250)), "1.25 s");
        assert_eq!(time(Duration::from_secs_f64(59.7)), "1 min 00 s");
        assert_eq!(time(Duration::from_secs(127)), "2 min 07 s");
        assert_eq!(time(Duration::from_secs(3 * 3600 + 300)), "3 h 05 min");
    }
}
