//! What `rockfall report` promises to those who call it.

mod common;

use common::{Place, expect, out};
use std::fs;

const SCENE: &str = r#"
[world]
frames = 12

[output]
contacts = true

[shapes]
floor = { kind = "half-space" }
ball = { kind = "sphere", radius = 0.5 }

[[bodies]]
shape = "floor"
[[bodies]]
shape = "ball"
position = [0, 0, 0.55]
velocity = [1, 0, 0]
"#;

#[test]
fn a_page_shows_the_run_and_needs_nothing_else() {
    let place = Place::with("small.toml", SCENE);
    expect(&place.rockfall("run small.toml --out run --quiet"), 0);
    let said = place.rockfall("report run --quality draft");
    expect(&said, 0);
    assert!(out(&said).starts_with("run.html: "), "{}", out(&said));
    let page = fs::read_to_string(place.path("run.html")).unwrap();
    for title in [
        "Kinetic energy",
        "Energy",
        "Momentum",
        "Penetration",
        "Bodies",
        "Contacts",
        "Time of a step, by stage",
    ] {
        assert!(page.contains(&format!("<figcaption>{title}</figcaption>")), "{title}");
    }
    // A table behind each curve, the percentile that contacts allow, what is zero throughout not at all.
    assert_eq!(page.matches("<figure").count(), page.matches(" as a table</summary>").count());
    assert!(page.contains("99 of 100") && page.contains("<polygon") && !page.contains("frozen</figcaption>"));
    // The summary, the pictures, the scene as text.
    assert!(page.contains("<th class=\"text\" scope=\"row\">deepest penetration</th>"));
    assert!(
        page.contains("src=\"data:image/png;base64,iVBOR") && page.contains("kind = &quot;half-space&quot;")
    );
    for outside in ["http://", "https://", "<script", "<link", "src=\"/", "NaN"] {
        assert!(!page.contains(outside), "{outside}");
    }
}

#[test]
fn a_film_is_made_for_the_page_or_taken_from_a_file() {
    let place = Place::with("small.toml", SCENE);
    expect(&place.rockfall("run small.toml --out run --frames 3 --quiet"), 0);
    expect(&place.rockfall("report run --film --quality draft -o page.html --quiet"), 0);
    let page = fs::read_to_string(place.path("page.html")).unwrap();
    assert!(page.contains("<video controls") && page.contains("src=\"data:video/mp4;base64,"));
    assert!(!place.path("page.html.mp4").exists());
    expect(&place.rockfall("render run -o film.mp4 --size 64x48 --quality draft --quiet"), 0);
    expect(&place.rockfall("report run --film film.mp4 -o other.html --quiet"), 0);
    assert!(fs::read_to_string(place.path("other.html")).unwrap().len() < page.len());
}

#[test]
fn whatever_is_wrong_is_said_and_no_page_is_left() {
    let place = Place::with("small.toml", SCENE);
    expect(&place.rockfall("run small.toml --out run --frames 2 --quiet"), 0);
    fs::create_dir(place.path("empty")).unwrap();
    for (options, code, expected) in [
        ("missing", 1, "missing"),
        ("empty", 1, "is not a run"),
        ("run -o no/a.html", 1, "cannot write no/a.html"),
        ("run -o a.html --film small.toml", 2, "small.toml is not a film"),
        ("run -o a.html --film gone.mp4", 1, "cannot read gone.mp4"),
        ("run --quality best", 2, "expected one of draft, default, fine"),
    ] {
        place.refuses(&format!("report {options}"), code, expected);
        assert!(!place.path("a.html").exists(), "{options}");
    }
    // What was there stays.
    fs::write(place.path("old.html"), "old").unwrap();
    place.refuses("report run -o old.html --film gone.mp4", 1, "cannot read gone.mp4");
    assert_eq!(fs::read_to_string(place.path("old.html")).unwrap(), "old");
    // A run without its table.
    fs::remove_file(place.path("run/frames.csv")).unwrap();
    place.refuses("report run -o a.html", 1, "frames.csv");
}
