//! Parquet, read by Arrow's own library.

use crate::python::python;
use crate::sample::{FRAMES, Sample};
use rockfall_export::Parquet;

#[test]
fn pyarrow_reads_the_bits_of_the_store() {
    for (away, frames) in [(0.0, FRAMES), (4.0e6, 5)] {
        let sample = Sample::new(away, frames);
        for (per_frame, name) in [(false, "all.parquet"), (true, "all")] {
            sample.export(&Parquet { bodies: None, per_frame }, "", name).unwrap();
            let Some(said) = python("read_with_pyarrow.py", &[sample.path("run"), sample.path(name)]) else {
                return;
            };
            assert!(
                said.ends_with(if per_frame { "one file for each frame" } else { "in 1 row groups" }),
                "{said}"
            );
        }
    }
}

#[test]
fn chosen_bodies_are_all_that_is_there() {
    let sample = Sample::new(0.0, FRAMES);
    let bodies = Some("5000,4".parse().unwrap());
    sample.export(&Parquet { bodies, per_frame: false }, "2..3", "some.parquet").unwrap();
    let Some(said) = python("read_with_pyarrow.py", &["ids".into(), sample.path("some.parquet")]) else {
        return;
    };
    assert_eq!(said, "[4, 5000, 4, 5000]");
    // One that is poured later.
    let bodies = Some("64".parse().unwrap());
    sample.export(&Parquet { bodies, per_frame: false }, "0", "none.parquet").unwrap();
    assert_eq!(python("read_with_pyarrow.py", &["ids".into(), sample.path("none.parquet")]).unwrap(), "[]");
}
