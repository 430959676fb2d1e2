#![no_main]

use rockfall_fuzz::{MESH_FILES, mesh_file};
use std::sync::LazyLock;

static FOLDER: LazyLock<tempfile::TempDir> = LazyLock::new(|| tempfile::tempdir().expect("a folder"));

// The first byte tells the format.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Some((&kind, bytes)) = bytes.split_first() {
        mesh_file(FOLDER.path(), MESH_FILES[usize::from(kind) % MESH_FILES.len()], bytes);
    }
});
