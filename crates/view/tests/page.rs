//! The page in a real browser, and its types. Both go where there are node and the packages that `./test` installs; with `CI` set they have to.

use rockfall_cache::{
    BodyTable, Contents, FORMAT, Frame, Poses, RunFolder, RunWriter, SUMMARY, Status, Summary, VERSION,
};
use rockfall_math::DVec3;
use rockfall_scene::{Running, Scene};
use rockfall_view::{Door, Options, Server, Source};
use std::env;
use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::net::IpAddr;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Frames of a run, the start not counted.
const FRAMES: u64 = 90;

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

fn serve(source: Source, folder: &Path, host: IpAddr, port: u16) -> Server {
    let door = Door::open(&Options { host, port, saves: folder.join("saved") }).unwrap();
    door.serve(source).unwrap()
}

/// What it takes to drive a browser, where that is there: the package and the program.
fn driver() -> Option<[String; 2]> {
    let playwright = given("ROCKFALL_PLAYWRIGHT", "playwright-core of npm")?;
    Some([playwright, which(&browser()?)])
}

/// Has a script drive the page at `url`; `answer` says what it asks for.
fn drive(driver: [String; 2], script: &str, url: &str, mut answer: impl FnMut(&str) -> String) {
    let mut script = Command::new("node")
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(script))
        .args(driver)
        .arg(url)
        .args(env::var_os("ROCKFALL_SHOTS"))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let (mut answers, asked) = (script.stdin.take().unwrap(), script.stdout.take().unwrap());
    for line in BufReader::new(asked).lines() {
        writeln!(answers, "{}", answer(&line.unwrap())).unwrap();
    }
    assert!(script.wait().unwrap().success(), "what went wrong is above");
}

#[test]
fn the_page_works_in_a_browser() {
    let Some(driver) = driver() else { return };
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("cubes.toml");
    fs::write(&scene, SCENE).unwrap();
    let host = Options::default().host;
    let start = |port| serve(Source::scene(&scene, 1).unwrap(), folder.path(), host, port);
    let mut server = Some(start(0));
    let (url, port) =
        server.as_ref().map(|server| (server.url().to_owned(), server.address().port())).unwrap();
    drive(driver, "page.mjs", &url, |asked| match asked {
        "stop" => {
            server = None;
            "stopped".to_owned()
        }
        "start" => {
            server = Some(start(port));
            "started".to_owned()
        }
        other => panic!("the script asks for {other}"),
    });
}

/// Writes a run of the scene, some frames at a time.
struct Recorder {
    path: PathBuf,
    running: Running,
    table: BodyTable,
    summary: Summary,
    writer: RunWriter,
    frame: u64,
}

impl Recorder {
    fn new(path: PathBuf) -> Self {
        let scene = Scene::parse(SCENE, "cubes.toml", ".").unwrap();
        let running = scene.build().unwrap();
        let rows = running.body_table();
        let table = BodyTable {
            ids: rows.iter().map(|row| row.id).collect(),
            names: rows.iter().map(|row| row.name.clone().unwrap_or_default()).collect(),
            shapes: rows.iter().map(|row| row.shape as u32).collect(),
            scales: rows.iter().map(|row| row.scale).collect(),
        };
        let summary = Summary {
            format: FORMAT.into(),
            format_version: VERSION,
            status: Status::Running,
            frames_per_second: 60.0,
            frames_planned: FRAMES,
            bodies: table.len(),
            ..Summary::default()
        };
        let folder = RunFolder::at(&path, false).unwrap();
        let text = scene.to_toml_filled();
        let writer = RunWriter::create(&folder, &text, &summary, &table, Contents::default()).unwrap();
        let mut recorder = Recorder { path, running, table, summary, writer, frame: 0 };
        recorder.push();
        recorder
    }

    fn push(&mut self) {
        let (world, mut poses) = (&self.running.world, Poses::default());
        poses.gather(&self.table, DVec3::ZERO, &world.ids(), &world.poses()).unwrap();
        let report = (self.frame > 0).then(|| world.report().clone());
        let time = self.frame as f64 / 60.0;
        self.writer.push(Frame { time, poses, report, ..Frame::default() }).unwrap();
    }

    /// Goes on to a frame. All are on the disk then, for those who look on.
    fn go(&mut self, frame: u64) -> String {
        while self.frame < frame {
            self.running.before_step(self.frame).unwrap();
            self.running.world.step();
            self.frame += 1;
            self.push();
        }
        self.writer.sync().unwrap();
        self.frame.to_string()
    }

    fn finish(mut self) -> String {
        let last = self.go(FRAMES);
        self.writer.finish().unwrap();
        Summary { status: Status::Finished, ..self.summary }.write(&self.path.join(SUMMARY)).unwrap();
        last
    }
}

#[test]
fn runs_are_played_and_followed_in_a_browser() {
    let Some(driver) = driver() else { return };
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let host = Options::default().host;
    let show = |path: &Path| serve(Source::run(path).unwrap(), folder.path(), host, 0);
    Recorder::new(path("whole")).finish();
    let whole = show(&path("whole"));
    let (mut recorder, mut growing) = (None, None);
    drive(driver, "run.mjs", whole.url(), |asked| match asked {
        "grow" => {
            let recorder = recorder.insert(Recorder::new(path("growing")));
            recorder.go(20);
            growing.insert(show(&path("growing"))).url().to_owned()
        }
        "more" => recorder.as_mut().map(|recorder| recorder.go(recorder.frame + 20)).unwrap(),
        "finish" => recorder.take().map(Recorder::finish).unwrap(),
        other => panic!("the script asks for {other}"),
    });
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
