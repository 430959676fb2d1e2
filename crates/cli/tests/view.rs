//! What `rockfall view` promises to those who call it. What the server and the page do is tested where they are.

mod common;

use common::{Place, wait_for};
use serde_json::Value;
use std::io::{BufRead, BufReader};
use std::net::TcpListener;
use std::process::{Child, Stdio};

const SCENE: &str = r#"
[world]
frames = 100000
[shapes]
floor = { kind = "half-space" }
ball = { kind = "sphere", radius = 0.5 }
[[bodies]]
shape = "floor"
[[bodies]]
shape = "ball"
position = [0, 0, 3]
"#;

/// Ends a program when a test is over, however it ends.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Starts the page of something, and gives its address.
fn view(place: &Place, arguments: &str) -> (Running, String) {
    let mut child =
        place.command(arguments).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().map(Running).unwrap();
    let mut url = String::new();
    BufReader::new(child.0.stdout.take().unwrap()).read_line(&mut url).unwrap();
    (child, url.trim().to_owned())
}

#[test]
fn whatever_is_wrong_is_said_before_anything_is_shown() {
    let place = Place::with("small.toml", SCENE);
    std::fs::create_dir(place.path("empty")).unwrap();
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port();
    for (arguments, code, expected) in [
        ("view missing.toml", 3, "does not exist"),
        ("view empty", 1, "is not a run"),
        (&format!("view small.toml --port {port}"), 1, "is taken by another program"),
        (&format!("view missing.toml --port {port}"), 1, "is taken by another program"),
        ("view small.toml --host 203.0.113.7", 1, "cannot listen at 203.0.113.7:0"),
        ("view small.toml --host nowhere", 2, "invalid value 'nowhere'"),
        ("view small.toml --port 70000", 2, "70000"),
        ("view small.toml --threads 0", 2, "invalid value '0'"),
    ] {
        place.refuses(arguments, code, expected);
    }
}

#[test]
fn a_run_that_is_still_being_written_is_followed() {
    let place = Place::with("small.toml", SCENE);
    let run = place.command("run small.toml --out run --quiet --threads 1").spawn().map(Running).unwrap();
    wait_for("run", || place.path("run/trajectory.zarr/time/zarr.json").is_file());
    // It can be shown from its first frame on.
    let mut server = None;
    wait_for("page", || {
        let (child, url) = view(&place, "view run");
        let there = !url.is_empty();
        if there {
            server = Some((child, url));
        }
        there
    });
    let (child, url) = server.unwrap();
    let (mut socket, _) = tungstenite::connect(format!("{}live", url.replacen("http", "ws", 1))).unwrap();
    let mut status = || loop {
        let message = socket.read().unwrap();
        if message.is_binary() && message.clone().into_data()[0] == 1 {
            let number = message.into_data().slice(4..8);
            socket.send(tungstenite::Message::Binary(number)).unwrap();
        } else if let Ok(text) = message.to_text()
            && let Ok(value) = serde_json::from_str::<Value>(text)
            && value["is"] == "status"
        {
            return value;
        }
    };
    let first = status();
    assert_eq!(first["grows"], true);
    wait_for("growth", || status()["last"].as_u64() > first["last"].as_u64());
    wait_for("play", || status()["frame"].as_u64() > first["last"].as_u64());
    drop((run, child));
}
