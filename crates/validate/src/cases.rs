//! All cases. A new one is a file with a `CASE`, or several `CASES` of one kind, and its line in its group.

mod consistency;
mod flight;
mod friction;
mod grains;
mod impact;
mod quality;
mod simbenchmark;
mod statics;
mod threshold;

use crate::case::Case;

/// All cases, in the order of the report.
pub fn cases() -> Vec<Case> {
    let groups: [&[Case]; 8] = [
        &simbenchmark::CASES,
        &flight::CASES,
        &friction::CASES,
        &impact::CASES,
        &statics::CASES,
        &grains::CASES,
        &consistency::CASES,
        &[quality::CASE],
    ];
    groups.concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_none_is_a_group() {
        let cases = cases();
        let mut names: Vec<&str> = cases.iter().map(|case| case.name).collect();
        names.sort_unstable();
        assert!(names.is_sorted_by(|a, b| a < b), "{names:?}");
        assert!(cases.iter().all(|case| names.binary_search(&case.group).is_err()));
        assert!(cases.iter().all(|case| !case.engines.is_empty() && !case.setup.is_empty()));
    }
}
