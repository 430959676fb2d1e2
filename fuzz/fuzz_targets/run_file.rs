#![no_main]

use rockfall_fuzz::{GoodRun, run_file};
use std::sync::LazyLock;

static RUN: LazyLock<(tempfile::TempDir, GoodRun)> = LazyLock::new(|| {
    let folder = tempfile::tempdir().expect("a folder");
    let run = GoodRun::write(folder.path());
    (folder, run)
});

// The first bytes tell which of a run's files is spoilt, and where.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| run_file(&RUN.1, bytes));
