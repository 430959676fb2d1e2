//! Names that USD allows, from names that anything allows.

use std::collections::BTreeSet;

/// Names among siblings.
#[derive(Debug, Default)]
pub(super) struct Names {
    taken: BTreeSet<String>,
}

impl Names {
    /// A name like `wish`, with `_` for what can't be in it, and a number behind it where it is taken.
    pub(super) fn choose(&mut self, wish: &str) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '_' };
        let mut name: String = wish.chars().map(plain).collect();
        if !name.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_') {
            name.insert(0, '_');
        }
        let numbered = (2..).map(|k: u64| format!("{name}_{k}"));
        let free = [name.clone()].into_iter().chain(numbered).find(|name| !self.taken.contains(name));
        let name = free.unwrap_or(name);
        self.taken.insert(name.clone());
        name
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_valid_and_each_is_there_once() {
        let mut names = Names::default();
        let chosen = ["oak", "oak", "rough wood", "rough-wood", "1st", "", "große", "oak_2"]
            .map(|wish| names.choose(wish));
        assert_eq!(chosen, ["oak", "oak_2", "rough_wood", "rough_wood_2", "_1st", "_", "gro_e", "oak_2_2"]);
    }
}
