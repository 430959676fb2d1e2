//! Programs that read files independently, started by tests.

use std::ffi::OsStr;
use std::path::Path;
use std::process::Command;

/// The Python that has the packages of `requirements.txt`; `./test` makes it and sets this.
const PYTHON: &str = "ROCKFALL_PYTHON";

/// What a script beside this folder says; `None`, with a word on why, where there is no Python to run it.
pub(crate) fn python<A: AsRef<OsStr>>(script: &str, arguments: &[A]) -> Option<String> {
    let Some(python) = std::env::var_os(PYTHON) else {
        println!(
            "SKIPPED: {PYTHON} is not set; `./test` makes a Python with what {script} needs and sets it"
        );
        return None;
    };
    let output = Command::new(&python)
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(script))
        .args(arguments)
        .output()
        .unwrap_or_else(|error| panic!("cannot start {}: {error}", python.display()));
    let said = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    Some(said)
}
