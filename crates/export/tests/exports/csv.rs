//! CSV, read by another reader than the one that writes it.

use crate::python::python;
use crate::sample::{FRAMES, Sample};
use rockfall_export::Csv;

#[test]
fn pythons_csv_reads_the_bits_of_the_store() {
    for (away, frames) in [(0.0, FRAMES), (4.0e6, 5)] {
        let sample = Sample::new(away, frames);
        sample.export(&Csv::default(), "", "all.csv").unwrap();
        let bodies = "2..4,5000,10..20".parse().unwrap();
        sample.export(&Csv { bodies: Some(bodies) }, "1..3", "some.csv").unwrap();
        for (name, first, last, ids) in
            [("all.csv", 0, frames - 1, "all"), ("some.csv", 1, 3, "2-4,5000-5000,10-20")]
        {
            let arguments = [
                sample.path("run").display().to_string(),
                sample.path(name).display().to_string(),
                first.to_string(),
                last.to_string(),
                ids.to_owned(),
            ];
            let Some(said) = python("read_csv.py", &arguments) else { return };
            assert!(said.ends_with("rows are equal"), "{said}");
        }
    }
}
