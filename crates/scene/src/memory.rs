//! How much memory a scene will need, and how much there is.

use crate::node::Table;
use crate::shapes;
use crate::{generators, import};
use rockfall_import::Content;
use std::sync::Arc;

/// What a scene will need, counted without building it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Estimate {
    /// Bodies, those included that will be poured.
    pub bodies: u64,
    /// Shapes that the scene describes; sizes that generators draw come on top.
    pub shapes: u64,
    /// Memory of the running world, bytes: about 2.5 KB for each body and its share of the contacts, and the shapes.
    pub memory: u64,
}

/// A body in a settled pile with its contacts, bytes.
const BYTES_PER_BODY: u128 = 2500;

/// Counts what the scene `root` holds, its imports having been read, with so many bodies and shapes of the run that it starts with.
pub(crate) fn estimate(root: &Table, imports: &[Arc<Content>], bodies: u64, shapes: u64) -> Estimate {
    let mut bodies = u128::from(bodies) + root.list("bodies").len() as u128;
    bodies += imports.iter().map(|content| content.bodies.len() as u128).sum::<u128>();
    for table in root.tables("generators") {
        bodies = bodies.saturating_add((generators::kind_of(table).count)(table));
    }
    let mut shapes = shapes + imports.iter().map(|content| content.shapes.len() as u64).sum::<u64>();
    let mut geometry = imports.iter().map(|content| import::memory(content)).sum::<u64>();
    for (_, table) in root.named("shapes") {
        let kind = shapes::kind_of(table);
        shapes += (kind.members)(table);
        geometry = geometry.saturating_add((kind.memory)(table));
    }
    let memory = bodies.saturating_mul(BYTES_PER_BODY).saturating_add(geometry.into());
    let fit = |n: u128| u64::try_from(n).unwrap_or(u64::MAX);
    Estimate { bodies: fit(bodies), shapes, memory: fit(memory) }
}

/// The generator that makes the most bodies.
pub(crate) fn largest(root: &Table) -> Option<&Table> {
    root.tables("generators").max_by_key(|table| (generators::kind_of(table).count)(table))
}

/// Bytes that can be had without swapping, where the system says so (Linux).
pub(crate) fn available() -> Option<u64> {
    parse(&std::fs::read_to_string("/proc/meminfo").ok()?)
}

fn parse(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// Bytes for people.
pub(crate) fn human(bytes: u64) -> String {
    const UNITS: [&str; 7] = ["B", "KB", "MB", "GB", "TB", "PB", "EB"];
    let (mut x, mut unit) = (bytes as f64, 0);
    while x >= 999.5 && unit + 1 < UNITS.len() {
        x /= 1000.0;
        unit += 1;
    }
    if x < 9.95 && unit > 0 { format!("{x:.1} {}", UNITS[unit]) } else { format!("{x:.0} {}", UNITS[unit]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meminfo_is_read() {
        assert_eq!(parse("MemTotal: 5 kB\nMemAvailable:   24117 kB\n"), Some(24117 * 1024));
        assert_eq!(parse("MemTotal: 5 kB\n"), None);
    }

    #[test]
    fn bytes_are_rounded_for_people() {
        assert_eq!(human(999), "999 B");
        assert_eq!(human(2_500_000_000_000), "2.5 TB");
        assert_eq!(human(24_400_000_000), "24 GB");
        assert_eq!(human(u64::MAX), "18 EB");
    }
}
