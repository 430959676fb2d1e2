//! What the program promises: a run from end to end, with engines in processes of their own.

use std::process::{Command, Output};

fn bench(arguments: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rockfall-bench"));
    command.args(arguments.split_whitespace()).output().expect("started")
}

#[test]
fn a_run_prints_its_tables_and_writes_its_files() {
    let folder = std::env::temp_dir().join(format!("rockfall-bench-{}", std::process::id()));
    let few = "--scene box-pile --bodies 30 --steps 6 --timed 4 --turn 2 --repeats 1 --threads 1,2 --engines rockfall";
    let ended = bench(&format!("{few} --out {}", folder.display()));
    let text = String::from_utf8_lossy(&ended.stdout);
    assert!(ended.status.success(), "{text}{}", String::from_utf8_lossy(&ended.stderr));
    assert_eq!(text.matches("| box-pile | 30 | 6 |").count(), 2, "{text}");
    assert!(text.contains("2 threads worth"), "{text}");
    for name in ["bench.md", "bench.html", "bench.csv", "bench.json"] {
        let length = std::fs::metadata(folder.join(name)).expect(name).len();
        assert!(length > 100, "{name} has {length} bytes");
    }
    std::fs::remove_dir_all(folder).expect("removed");
}

#[test]
fn nonsense_is_refused() {
    let ended = bench("--scene nowhere");
    assert_eq!(ended.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&ended.stderr).contains("nowhere"));
}
