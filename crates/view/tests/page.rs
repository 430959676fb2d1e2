//! The page in a real browser, and its types. Both go where there are node and the packages that `./test` installs; with `CI` set they have to.

use rockfall_view::{Door, Options, Server, Source};
use std::env;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::net::IpAddr;
use std::path::Path;
use std::process::{Command, Stdio};

const SCENE: &str = r#"
[shapes]
floor = { kind = "half-space" }
cube = { kind = "box", size = [1, 1, 1] }

[[bodies]]
shape = "floor"
[[generators]]
kind = "grid"
shape = "cube"
count = [5, 5, 5]
spacing = [1.3, 1.3, 1.3]
position = [0, 0, 1]
"#;

/// A variable that `./test` sets; without it there is nothing to test with.
fn given(name: &str, what: &str) -> Option<String> {
    let found = env::var(name).ok();
    if found.is_none() {
        assert!(env::var_os("CI").is_none(), "{what} is missing: `./test` installs it");
        eprintln!("{name} is not set: {what} is missing, and this test with it; `./test` installs it");
    }
    found
}

fn browser() -> Option<String> {
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let there =
        |name: &&str| Command::new(name).arg("--version").output().is_ok_and(|said| said.status.success());
    let found =
        env::var("ROCKFALL_CHROMIUM").ok().or_else(|| names.into_iter().find(there).map(str::to_owned));
    if found.is_none() {
        assert!(env::var_os("CI").is_none(), "chromium is missing: Debian's package has it");
        eprintln!(
            "there is no chromium: the page is not tested in a browser; Debian's package `chromium` has it"
        );
    }
    found
}

/// The file of a program in the path.
fn which(name: &str) -> String {
    let folders = env::var_os("PATH").unwrap_or_default();
    let found = env::split_paths(&folders).map(|folder| folder.join(name)).find(|path| path.is_file());
    found.map_or_else(|| name.to_owned(), |path| path.display().to_string())
}

fn serve(scene: &Path, host: IpAddr, port: u16) -> Server {
    let saves = scene.with_file_name("saved");
    let door = Door::open(&Options { host, port, saves }).unwrap();
    door.serve(Source::scene(scene, 1).unwrap()).unwrap()
}

#[test]
fn the_page_works_in_a_browser() {
    let Some(playwright) = given("ROCKFALL_PLAYWRIGHT", "playwright-core of npm") else { return };
    let Some(chromium) = browser() else { return };
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("cubes.toml");
    fs::write(&scene, SCENE).unwrap();
    let host = Options::default().host;
    let mut server = Some(serve(&scene, host, 0));
    let (url, port) =
        server.as_ref().map(|server| (server.url().to_owned(), server.address().port())).unwrap();
    let mut script = Command::new("node")
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/page.mjs"))
        .args([playwright, which(&chromium), url])
        .args(env::var_os("ROCKFALL_SHOTS"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let (mut answers, asked) = (script.stdin.take().unwrap(), script.stdout.take().unwrap());
    for line in BufReader::new(asked).lines() {
        let answer = match line.unwrap().as_str() {
            "stop" => {
                server = None;
                "stopped"
            }
            "start" => {
                server = Some(serve(&scene, host, port));
                "started"
            }
            other => panic!("the script asks for {other}"),
        };
        writeln!(answers, "{answer}").unwrap();
    }
    assert!(script.wait().unwrap().success(), "what went wrong is above");
    drop(server);
}

#[test]
fn the_page_is_typed() {
    let Some(compiler) = given("ROCKFALL_TYPESCRIPT", "typescript of npm") else { return };
    let said = Command::new("node")
        .args([compiler, "-p".into(), concat!(env!("CARGO_MANIFEST_DIR"), "/page").into()])
        .output()
        .unwrap();
    assert!(said.status.success(), "{}", String::from_utf8_lossy(&said.stdout));
}
