//! Files that are not what they were.

use rockfall_import::{Body, Place, read};

/// A file cut off at every so many bytes, and the byte there changed in some ways: it is refused or read, and that is all that happens.
pub(crate) fn damage(name: &str, bytes: &[u8], every: usize) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    let mut read_at_all = 0;
    let mut try_it = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        match read(&path, &Place::default()) {
            Ok(content) => {
                let whole = |body: &Body| body.pose.position.is_finite() && body.velocity.is_finite();
                assert!(content.bodies.iter().all(whole));
                read_at_all += 1;
            }
            Err(error) => assert!(!error.reason.is_empty()),
        }
    };
    for at in (0..bytes.len()).step_by(every) {
        try_it(&bytes[..at]);
        for flip in [0x01, 0x80, 0xff] {
            let mut bytes = bytes.to_vec();
            bytes[at] ^= flip;
            try_it(&bytes);
        }
    }
    println!("{read_at_all} of {} damaged files could be read", 4 * bytes.len().div_ceil(every));
}
