#![no_main]

use rockfall_fuzz::{IMPORTS, import};
use std::sync::LazyLock;

static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| tempfile::tempdir().expect("a folder"));

// The first byte tells the format.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Some((&kind, bytes)) = bytes.split_first() {
        import(FOLDER.path(), IMPORTS[usize::from(kind) % IMPORTS.len()], bytes);
    }
});
