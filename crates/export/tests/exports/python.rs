//! Scripts that open exports with other programs and compare them with the run.

use std::ffi::OsStr;
use std::path::Path;
use std::process::Command;

/// The variable that names a Python with the packages of `requirements.txt`; the `test` script sets it.
const PYTHON: &str = "ROCKFALL_PYTHON";

/// The variable that names a Python with Blender and the packages of `requirements-blender.txt`; the `test` script sets it where there is Python 3.11.
const BLENDER: &str = "ROCKFALL_BLENDER";

/// Runs a script of this folder's parent; says what it printed. `None` where there is no Python to run it.
pub(crate) fn python<A: AsRef<OsStr>>(script: &str, arguments: &[A]) -> Option<String> {
    run(PYTHON, script, arguments)
}

/// The same with the Python that has Blender.
pub(crate) fn blender<A: AsRef<OsStr>>(script: &str, arguments: &[A]) -> Option<String> {
    run(BLENDER, script, arguments)
}

fn run<A: AsRef<OsStr>>(variable: &str, script: &str, arguments: &[A]) -> Option<String> {
    let Some(python) = std::env::var_os(variable) else {
        println!(
            "SKIPPED: {variable} is not set; `./test` makes a Python with what {script} needs and sets it"
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
