//! `frames.csv` as columns of numbers.

use crate::exit::Failure;
use rockfall_cache::FRAMES;
use std::fs;
use std::path::Path;

/// Columns by their names, in their order.
#[derive(Debug, Default)]
pub(super) struct Table {
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
}

impl Table {
    /// That of a run; of one that is still being written up to its last whole row.
    pub(super) fn read(run: &Path) -> Result<Self, Failure> {
        let path = run.join(FRAMES);
        let text = fs::read_to_string(&path)
            .map_err(|error| Failure::Run(format!("cannot read {}: {error}", path.display())))?;
        Ok(Table::parse(&text))
    }

    fn parse(text: &str) -> Self {
        let mut lines = text.split_inclusive('\n').filter_map(|line| line.strip_suffix('\n'));
        let names: Vec<String> =
            lines.next().unwrap_or_default().split(',').map(|name| name.trim().to_owned()).collect();
        let mut columns = vec![Vec::new(); names.len()];
        for line in lines {
            let cells: Vec<&str> = line.trim_end().split(',').collect();
            if cells.len() == names.len() {
                // What is no number, such as a hash, is none here either.
                columns
                    .iter_mut()
                    .zip(cells)
                    .for_each(|(column, cell)| column.push(cell.parse().unwrap_or(f64::NAN)));
            }
        }
        Table { names, columns }
    }

    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str)
    }

    /// A column, if the run has it.
    pub(super) fn column(&self, name: &str) -> Option<&[f64]> {
        let found = self.names.iter().position(|known| known == name)?;
        Some(&self.columns[found])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_found_by_name_and_a_row_that_is_cut_off_is_left_out() {
        let table = Table::parse("frame,time_s,hash\n1,0.5,0f\n2,1.0,ab\n3,1.");
        assert_eq!(table.column("time_s"), Some(&[0.5, 1.0][..]));
        assert!(table.column("hash").is_some_and(|hashes| hashes.iter().all(|hash| hash.is_nan())));
        assert_eq!(table.column("other"), None);
        assert_eq!(Table::parse("").column("frame"), None);
    }
}
