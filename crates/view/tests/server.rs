//! What the server promises to those who come, without a browser.

use rockfall_view::wire::{ABSENT, Grid, HEAD, Record};
use rockfall_view::{Door, Error, Options, Server, Source};
use serde_json::{Value, json};
use std::fs;
use std::io::{Read, Write};
use std::net::{IpAddr, Ipv4Addr, TcpStream};
use std::time::{Duration, Instant};
use tempfile::TempDir;
use tungstenite::client::IntoClientRequest;
use tungstenite::{Message, WebSocket};

/// A pile of cubes on the ground.
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

struct Place {
    server: Server,
    folder: TempDir,
}

impl Place {
    fn open() -> Self {
        Self::with(Options::default())
    }

    fn with(options: Options) -> Self {
        Self::of(SCENE, options)
    }

    fn of(scene: &str, options: Options) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cubes.toml");
        fs::write(&path, scene).unwrap();
        let door = Door::open(&Options { saves: folder.path().join("saved"), ..options }).unwrap();
        let server = door.serve(Source::scene(&path, 1).unwrap()).unwrap();
        Place { server, folder }
    }

    fn viewer(&self) -> Viewer {
        let url = self.server.url().replacen("http", "ws", 1).replacen('?', "live?", 1);
        let url = if url.contains("live") { url } else { format!("{url}live") };
        Viewer::open(&url, &[]).expect("the viewer is let in")
    }

    /// The answer to a request, head and body.
    fn ask(&self, request: &str) -> String {
        let mut stream = TcpStream::connect(self.server.address()).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        String::from_utf8_lossy(&answer).into_owned()
    }
}

/// A page without a browser.
struct Viewer {
    socket: WebSocket<TcpStream>,
    records: Vec<Record>,
    rows: usize,
    frame: u32,
    step: f32,
    /// Texts by what they are.
    heard: Vec<Value>,
    moments: usize,
    /// Bytes of moments, and records in them.
    read: [usize; 2],
    /// Whether it tells the server what it has read.
    polite: bool,
}

impl Viewer {
    fn open(url: &str, headers: &[(&str, &str)]) -> Result<Self, String> {
        let mut request = url.into_client_request().unwrap();
        for (name, value) in headers {
            let name = tungstenite::http::HeaderName::try_from(*name).unwrap();
            request.headers_mut().insert(name, value.parse().unwrap());
        }
        let host = request.uri().authority().unwrap().to_string();
        let stream = TcpStream::connect(&host).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        let (socket, _) = tungstenite::client(request, stream).map_err(|error| match error {
            tungstenite::HandshakeError::Failure(tungstenite::Error::Http(answer)) => {
                let body = answer.body().clone().unwrap_or_default();
                format!("{} {}", answer.status(), String::from_utf8_lossy(&body))
            }
            other => other.to_string(),
        })?;
        Ok(Viewer {
            socket,
            records: Vec::new(),
            rows: 0,
            frame: 0,
            step: 0.0,
            heard: Vec::new(),
            moments: 0,
            read: [0; 2],
            polite: true,
        })
    }

    fn say(&mut self, command: Value) {
        self.socket.send(Message::text(command.to_string())).unwrap();
    }

    /// Reads one message; whether there was one.
    fn read(&mut self) -> bool {
        match self.socket.read() {
            Ok(Message::Text(text)) => self.heard.push(serde_json::from_str(&text).unwrap()),
            Ok(Message::Binary(bytes)) => self.binary(&bytes),
            Ok(_) => {}
            Err(_) => return false,
        }
        true
    }

    fn binary(&mut self, bytes: &[u8]) {
        let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
        match bytes[0] {
            1 => {
                if bytes[1] == 1 {
                    self.records.fill(ABSENT);
                }
                (self.frame, self.step) = (word(8), f32::from_bits(word(12)));
                let (count, length) = (word(24) as usize, word(28) as usize);
                let mut words = HEAD + length.next_multiple_of(4);
                assert_eq!(bytes.len(), words + 12 * count);
                let mut numbers = bytes[HEAD..HEAD + length].iter();
                let mut number = || {
                    let (mut value, mut shift) = (0, 0);
                    let mut any = false;
                    for byte in numbers.by_ref() {
                        any = true;
                        value |= usize::from(byte & 0x7f) << shift;
                        shift += 7;
                        if byte & 0x80 == 0 {
                            break;
                        }
                    }
                    any.then_some(value)
                };
                let mut row = 0;
                while let Some(gap) = number() {
                    row += gap;
                    for _ in 0..number().unwrap() {
                        self.records[row] = [word(words), word(words + 4), word(words + 8)];
                        (row, words) = (row + 1, words + 12);
                    }
                }
                self.moments += 1;
                self.read = [self.read[0] + bytes.len(), self.read[1] + count];
                if self.polite {
                    self.socket.send(Message::binary(bytes[4..8].to_vec())).unwrap();
                }
            }
            4 => {
                self.rows = (word(4) + word(8)) as usize;
                self.records.resize(self.rows, ABSENT);
            }
            2 | 3 | 5 => {}
            other => panic!("a message of kind {other}"),
        }
    }

    /// Reads until something holds.
    #[track_caller]
    fn until(&mut self, what: &str, mut holds: impl FnMut(&Viewer) -> bool) {
        let deadline = Instant::now() + Duration::from_secs(20);
        while !holds(self) {
            assert!(Instant::now() < deadline, "no {what}: {:?}", self.heard.last());
            assert!(self.read(), "no {what}: the connection is gone after {:?}", self.heard.last());
        }
    }

    fn last(&self, is: &str) -> Option<&Value> {
        self.heard.iter().rev().find(|value| value["is"] == is)
    }

    fn status(&self, key: &str) -> &Value {
        static NONE: Value = Value::Null;
        self.last("status").map_or(&NONE, |status| &status[key])
    }

    fn place(&self, row: usize) -> [f32; 3] {
        Grid { step: self.step }.pose(self.records[row]).expect("the body is there").0.to_array()
    }
}

#[test]
fn a_viewer_sees_bodies_fall_and_time_obeys() {
    let place = Place::open();
    let mut viewer = place.viewer();
    viewer.until("greeting", |v| v.last("hello").is_some());
    assert_eq!(viewer.last("hello").unwrap()["title"], "cubes");
    viewer.until("moment", |v| v.moments > 0);
    assert_eq!(viewer.rows, 126);
    viewer.until("fall", |v| v.frame > 20);
    viewer.say(json!({"do": "play", "on": false}));
    viewer.until("rest", |v| v.status("playing") == false);
    viewer.say(json!({"do": "seek", "frame": 0}));
    viewer.until("start", |v| v.frame == 0 && v.status("frame") == 0);
    let start = viewer.place(60);
    viewer.say(json!({"do": "step", "by": 3}));
    viewer.until("third frame", |v| v.frame == 3);
    assert!(viewer.place(60)[2] < start[2]);
    viewer.say(json!({"do": "step", "by": -2}));
    viewer.until("first frame", |v| v.frame == 1);
    let last = viewer.status("last").as_u64().unwrap();
    viewer.say(json!({"do": "seek", "frame": last}));
    viewer.until("end", |v| u64::from(v.frame) == last);
    viewer.say(json!({"do": "step", "by": 2}));
    viewer.until("beyond", |v| u64::from(v.frame) == last + 2);
    viewer.say(json!({"do": "reset"}));
    viewer.until("reset", |v| v.frame == 0 && v.status("last") == 0);
    assert_eq!(viewer.place(60), start);
}

#[test]
fn hands_reach_the_simulation_and_what_is_asked_is_told() {
    let place = Place::open();
    let mut viewer = place.viewer();
    viewer.until("moment", |v| v.moments > 0);
    viewer.say(json!({"do": "show", "color": "speed", "overlays": ["contacts", "bounds"], "pick": 60}));
    viewer.until("legend", |v| v.last("legend").is_some_and(|legend| legend["by"] == "speed"));
    viewer.until("body", |v| {
        v.last("picked").is_some_and(|told| told["shape"] == "box" && told["mass"] == 2600.0)
    });
    viewer.say(json!({"do": "throw", "from": [-9.0, 0.0, 4.0], "velocity": [30.0, 0.0, 0.0], "radius": 0.5}));
    viewer.until("ball", |v| v.rows == 127);
    viewer.say(json!({"do": "pile", "over": [20.0, 0.0, 0.0], "size": 0.5, "count": 10}));
    viewer.until("pile", |v| v.rows == 137);
    viewer.say(json!({"do": "set", "gravity": [0, 0, 5], "solver": "impulse", "substeps": 2}));
    viewer.until("gravity", |v| {
        v.status("settings") == &json!({"gravity": [0.0, 0.0, 5.0], "solver": "impulse", "substeps": 2})
    });
    viewer.say(json!({"do": "material", "index": 0, "friction": 0.125, "restitution": 0.5}));
    viewer.until("material", |v| v.status("materials")[0]["friction"] == 0.125);
    let at: Vec<f64> = {
        viewer.until("body", |v| v.last("picked").is_some_and(|told| told["row"] == 60));
        serde_json::from_value(viewer.last("picked").unwrap()["position"].clone()).unwrap()
    };
    viewer.say(json!({"do": "grab", "row": 60, "at": at}));
    viewer.say(json!({"do": "pull", "to": [at[0], at[1] + 40.0, at[2]]}));
    let before = viewer.place(60)[1];
    viewer.until("pull", |v| v.place(60)[1] > before + 5.0);
    viewer.say(json!({"do": "release"}));
    viewer.say(json!({"do": "save"}));
    viewer.until("scene", |v| v.last("note").is_some());
    let note = viewer.last("note").unwrap()["text"].as_str().unwrap().to_owned();
    assert!(note.contains("scene.toml"), "{note}");
    assert!(place.folder.path().join("saved").is_dir());
    let wrong = [
        (json!({"do": "set", "solver": "magic"}), "expected one of soft-step, impulse, reflect"),
        (json!({"do": "set", "substeps": 0}), "setting `substeps` is 0"),
        (json!({"do": "speed", "of": 1e9}), "expected 0.001 to 100"),
        (json!({"do": "grab", "row": 0, "at": [0, 0, 0]}), "nobody moves"),
        (json!({"do": "grab", "row": 999_999, "at": [0, 0, 0]}), "there is no body in row"),
        (json!({"do": "throw", "from": [0, 0, 0], "velocity": [0, 0, 0], "radius": -1}), "makes no sense"),
        (json!({"do": "material", "index": 7, "friction": 0.1}), "no material number 7"),
    ];
    for (command, expected) in wrong {
        viewer.heard.retain(|value| value["is"] != "error");
        viewer.say(command);
        viewer.until(expected, |v| v.last("error").is_some());
        let said = viewer.last("error").unwrap()["text"].as_str().unwrap();
        assert!(said.contains(expected), "{said}");
    }
}

/// Places and sleep are kept of what has been; what is not is told to be unknown, and what does not change is known.
#[test]
fn a_body_in_the_past_is_told_of_as_far_as_it_was_kept() {
    let place = Place::open();
    let mut viewer = place.viewer();
    viewer.say(json!({"do": "show", "color": "body", "overlays": [], "pick": 60}));
    viewer.until("fall", |v| v.frame > 40);
    viewer.say(json!({"do": "play", "on": false}));
    viewer.until("rest", |v| v.status("playing") == false);
    let last = viewer.status("last").as_u64().unwrap();
    viewer.say(json!({"do": "seek", "frame": 7}));
    viewer.until("past", |v| v.frame == 7 && v.last("picked").is_some_and(|told| told["past"] == 7));
    let told = viewer.last("picked").unwrap().clone();
    assert_eq!((&told["id"], &told["shape"], &told["mass"]), (&json!("61"), &json!("box"), &json!(2600.0)));
    assert_eq!(told["asleep"], false);
    for key in ["velocity", "spin", "force", "center", "contacts", "contact_count"] {
        assert!(told[key].is_null(), "{key} of the past: {}", told[key]);
    }
    let hello = viewer.last("hello").unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    for (axis, at) in viewer.place(60).into_iter().enumerate() {
        let there = number(&told["position"][axis]) - number(&hello["origin"][axis]);
        assert!((there - f64::from(at)).abs() < 1e-6, "{there} and {at}");
    }
    viewer.say(json!({"do": "seek", "frame": last}));
    viewer.until("present", |v| {
        v.last("picked").is_some_and(|told| told["velocity"].is_array() && told["past"].is_null())
    });
}

/// What twenty thousand boxes in free fall, none of which rests, cost on their way to a page.
#[test]
fn twenty_thousand_bodies_on_their_way_take_at_most_16_bytes_each_and_frame() {
    let scene = SCENE.replace("[5, 5, 5]", "[25, 25, 32]").replace("[0, 0, 1]", "[0, 0, 100]");
    let place = Place::of(&scene, Options::default());
    let mut viewer = place.viewer();
    viewer.until("moments", |v| v.moments > 6);
    let [bytes, records] = viewer.read;
    assert!(records > 6 * 19_000, "{records} records");
    let each = bytes as f64 / records as f64;
    println!(
        "{each:.2} bytes for each of 20,000 bodies that move, and frame, over {} moments",
        viewer.moments
    );
    assert!(each <= 16.0, "{each}");
}

#[test]
fn who_reads_nothing_holds_nobody_up_and_rubbish_is_answered() {
    let place = Place::open();
    let mut deaf = place.viewer();
    deaf.polite = false;
    let mut viewers = [place.viewer(), place.viewer(), place.viewer()];
    for viewer in &mut viewers {
        viewer.until("moments", |v| v.moments > 5);
    }
    viewers[0].until("count", |v| v.status("viewers") == 4);
    // Rubbish in all ways.
    let mut rude = place.viewer();
    for text in ["", "{", "null", r#"{"do":"explode"}"#, r#"{"do":"seek","frame":"ü"}"#] {
        rude.socket.send(Message::text(text)).unwrap();
        rude.heard.clear();
        rude.until("complaint", |v| v.last("error").is_some());
    }
    rude.socket.send(Message::binary(vec![7; 3])).unwrap();
    rude.heard.clear();
    rude.until("complaint", |v| v.last("error").is_some());
    rude.socket.send(Message::binary(u32::MAX.to_le_bytes().to_vec())).unwrap();
    let _ = rude.socket.send(Message::text("x".repeat(100_000)));
    while rude.read() {}
    let mut endless = place.viewer();
    for _ in 0..500 {
        if endless.socket.send(Message::text("rubbish")).is_err() {
            break;
        }
    }
    while endless.read() {}
    assert!(endless.heard.iter().filter(|value| value["is"] == "error").count() < 200);
    let mut broken = place.viewer();
    broken.socket.get_mut().write_all(&[0xff; 64]).unwrap();
    while broken.read() {}
    for junk in ["\u{16}\u{3}\u{1}", "GET / HTTP/9.9\r\n\r\n", "hello\r\n\r\n"] {
        assert!(place.ask(junk).starts_with("HTTP/1.1 400"), "{junk:?}");
    }
    let long = format!("GET / HTTP/1.1\r\nX: {}\r\n\r\n", "y".repeat(40_000));
    let said = place.ask(&long);
    assert!(said.starts_with("HTTP/1.1 400") || said.is_empty(), "{said}");
    // The others have seen nothing of it; the deaf one was sent two moments, and no more.
    for viewer in &mut viewers {
        let frame = viewer.frame;
        viewer.until("further moments", |v| v.frame > frame + 10);
    }
    deaf.until("two moments", |v| v.moments == 2);
    deaf.until("count", |v| v.status("frame").as_u64() > Some(u64::from(v.frame) + 5));
    assert_eq!(deaf.moments, 2);
    drop(viewers);
    deaf.polite = true;
    deaf.socket.send(Message::binary(2_u32.to_le_bytes().to_vec())).unwrap();
    deaf.until("moments again", |v| v.moments > 5);
    deaf.until("count", |v| v.status("viewers") == 1);
}

#[test]
fn strangers_are_not_let_in() {
    let place = Place::open();
    let (address, port) = (place.server.address(), place.server.address().port());
    let page = place.ask(&format!("GET / HTTP/1.1\r\nHost: {address}\r\n\r\n"));
    assert!(
        page.starts_with("HTTP/1.1 200 OK")
            && page.contains("default-src 'self'")
            && page.contains("<canvas")
    );
    assert!(place.ask(&format!("HEAD /main.js HTTP/1.1\r\nHost: {address}\r\n\r\n")).ends_with("\r\n\r\n"));
    for (request, expected) in [
        (format!("GET / HTTP/1.1\r\nHost: evil.example:{port}\r\n\r\n"), "403 Forbidden"),
        ("GET / HTTP/1.1\r\n\r\n".to_owned(), "403 Forbidden"),
        (format!("GET /live HTTP/1.1\r\nHost: {address}\r\n\r\n"), "426 Upgrade Required"),
        (format!("GET /../../etc/passwd HTTP/1.1\r\nHost: {address}\r\n\r\n"), "404 Not Found"),
        (format!("POST / HTTP/1.1\r\nHost: {address}\r\n\r\n"), "405 Method Not Allowed"),
    ] {
        let said = place.ask(&request);
        assert!(said.starts_with(&format!("HTTP/1.1 {expected}")), "{request}: {said}");
    }
    let url = format!("ws://{address}/live");
    let evil = Viewer::open(&url, &[("origin", "http://evil.example")]).err().unwrap();
    assert!(evil.contains("403") && evil.contains("another one's"), "{evil}");
    let rebound = Viewer::open(&url, &[("host", "evil.example")]).err().unwrap();
    assert!(rebound.contains("403"), "{rebound}");
    let own = format!("http://{address}");
    assert!(Viewer::open(&url, &[("origin", &own)]).is_ok());
}

#[test]
fn an_address_that_is_open_to_others_takes_a_token() {
    let place = Place::with(Options { host: IpAddr::V4(Ipv4Addr::UNSPECIFIED), ..Options::default() });
    let port = place.server.address().port();
    assert!(place.server.url().starts_with(&format!("http://127.0.0.1:{port}/?token=")));
    let page = |query: &str| place.ask(&format!("GET /{query} HTTP/1.1\r\nHost: box.example:{port}\r\n\r\n"));
    assert!(
        page("").starts_with("HTTP/1.1 403") && page("?token=0").contains("the token is missing or wrong")
    );
    let token = place.server.url().split_once('?').unwrap().1;
    assert!(page(&format!("?{token}")).starts_with("HTTP/1.1 200"));
    let without = Viewer::open(&format!("ws://127.0.0.1:{port}/live"), &[]).err().unwrap();
    assert!(without.contains("403") && without.contains("token"), "{without}");
    let mut viewer = place.viewer();
    viewer.until("moment", |v| v.moments > 0);
}

#[test]
fn a_port_that_is_taken_is_named() {
    let place = Place::open();
    let port = place.server.address().port();
    let error = Door::open(&Options { port, ..Options::default() }).err().unwrap();
    assert!(matches!(error, Error::Taken(_)) && error.to_string().contains(&port.to_string()), "{error}");
    let nowhere = Options { host: "203.0.113.7".parse().unwrap(), ..Options::default() };
    assert!(matches!(Door::open(&nowhere).err().unwrap(), Error::Listen { .. }));
}
