//! Bad input: every scene of `broken.txt` is refused with exactly the text that stands there, without a panic and
//! within two seconds. `UPDATE=1 cargo test -p rockfall-scene --test broken` writes the texts anew; read the
//! difference before you keep it.

use rockfall_scene::Scene;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// One entry: a title, files (the first is the scene), and what must be said of them.
struct Case<'a> {
    title: &'a str,
    files: Vec<(&'a str, &'a str)>,
    said: &'a str,
}

/// Entries begin with `=== title`, files with `@@ name`, what is said with `>>>`.
fn cases(table: &str) -> Vec<Case<'_>> {
    let entry = |entry| {
        let (title, rest): (&str, &str) = str::split_once(entry, '\n').unwrap();
        let (input, said) = rest.split_once(">>>\n").unwrap();
        let files = input.split("@@ ").skip(1).map(|f| f.split_once('\n').unwrap()).collect();
        Case { title, files, said: said.trim_end() }
    };
    table.split("=== ").skip(1).map(entry).collect()
}

/// A folder of its own in the build's scratch space.
fn folder(number: usize) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("broken-{number}"));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Contents in words, for what a text file can't hold.
fn contents(text: &str) -> Vec<u8> {
    match text.trim() {
        "(binary garbage)" => (0..4096u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect(),
        "(17 MiB of comment)" => b"# and so on\n".repeat(1_500_000),
        "(ten thousand brackets)" => [b"x = ".as_slice(), &[b'['; 10_000]].concat(),
        _ => text.as_bytes().to_vec(),
    }
}

/// Everything that is said, one problem on a line, paths from the case's folder.
fn said(folder: &Path, scene: &str) -> String {
    let outcome = Scene::load(folder.join(scene)).and_then(|s| s.check_within(Some(16_000_000_000)));
    match outcome {
        Ok(()) => "nothing".to_owned(),
        Err(error) => {
            assert!(!error.render(false).contains('\u{1b}'), "no colours were asked for");
            let lines: Vec<String> = error.problems().iter().map(ToString::to_string).collect();
            assert!(error.to_string().starts_with(&lines[0]));
            lines.join("\n").replace(&format!("{}/", folder.display()), "")
        }
    }
}

#[test]
fn every_broken_scene_is_refused_with_its_text() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/broken.txt");
    let table = std::fs::read_to_string(&path).unwrap();
    let cases = cases(&table);
    assert!(cases.len() >= 60);
    let mut anew = table.split("=== ").next().unwrap().to_owned();
    let mut wrong = Vec::new();
    for (number, case) in cases.iter().enumerate() {
        let folder = folder(number);
        for (name, text) in &case.files {
            match text.trim() {
                "(a folder)" => std::fs::create_dir(folder.join(name)).unwrap(),
                "(missing)" => {}
                _ => std::fs::write(folder.join(name), contents(text)).unwrap(),
            }
        }
        let start = Instant::now();
        let found = said(&folder, case.files[0].0);
        assert!(start.elapsed() < Duration::from_secs(2), "{} took too long", case.title);
        if found != case.said {
            wrong.push(format!("{}\nsaid:     {found}\nexpected: {}", case.title, case.said));
        }
        anew += &format!("=== {}\n", case.title);
        case.files.iter().for_each(|(name, text)| anew += &format!("@@ {name}\n{text}"));
        anew += &format!(">>>\n{found}\n\n");
    }
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&path, anew.trim_end().to_owned() + "\n").unwrap();
    } else {
        assert!(wrong.is_empty(), "{}", wrong.join("\n\n"));
    }
}

#[test]
fn all_problems_of_a_file_are_shown_with_their_lines() {
    let text = "[materials.rock]\nfrction = 1\ndensity = -2600\n\n[[bodies]]\nshape = 7\n";
    let error = Scene::parse(text, "slide.toml", ".").unwrap_err();
    assert_eq!(error.problems().len(), 3);
    assert!(error.to_string().ends_with("(and 2 more problems)"));
    let shown = error.render(false);
    for part in ["slide.toml:2:1", "frction = 1", "did you mean `friction`?", "density = -2600", "shape = 7"]
    {
        assert!(shown.contains(part), "{part} is not in\n{shown}");
    }
    assert!(error.render(true).contains('\u{1b}'));
}
