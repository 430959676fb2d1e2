//! Files in the repository that are made from the code, and are what the code makes. `UPDATE=1 cargo test -p
//! rockfall-scene` writes them anew.

use rockfall_math::{Vec2, trig};
use rockfall_shape::Mesh;
use std::fmt::Write;
use std::path::{Path, PathBuf};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn is_up_to_date(path: &Path, text: &str) {
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(path, text).unwrap();
    }
    let found = std::fs::read_to_string(path).unwrap_or_default();
    assert!(found == text, "{} is out of date: run the tests with UPDATE=1", path.display());
}

#[test]
fn the_schema_file_is_the_readers_own() {
    is_up_to_date(&repository().join("docs/scene.schema.json"), &rockfall_scene::schema());
}

#[test]
fn the_manual_lists_every_key() {
    let path = repository().join("docs/scene.md");
    let text = std::fs::read_to_string(&path).unwrap();
    let mark = "<!-- From here on this page is made from the reader's tables of keys. -->\n";
    let end = text.find(mark).expect("the page has its mark") + mark.len();
    is_up_to_date(&path, &format!("{}\n{}", &text[..end], rockfall_scene::manual()));
}

/// A hare of five round parts, each a closed surface: body, head, tail and two ears.
fn hare() -> String {
    // Centre, half axes, and how far the part leans forward (x per z).
    let parts: [([f64; 3], [f64; 3], f64); 5] = [
        ([0.0, 0.0, 0.32], [0.45, 0.28, 0.32], 0.15),
        ([0.42, 0.0, 0.62], [0.2, 0.16, 0.17], 0.0),
        ([-0.46, 0.0, 0.3], [0.1, 0.09, 0.1], 0.0),
        ([0.34, 0.07, 0.92], [0.06, 0.035, 0.25], -0.2),
        ([0.34, -0.07, 0.92], [0.06, 0.035, 0.25], -0.2),
    ];
    const AROUND: usize = 10;
    const RINGS: usize = 5;
    let mut out =
        String::from("# A hare of five ellipsoids, metres, z up. Made by crates/scene/tests/committed.rs.\n");
    let mut base = 1;
    for (centre, half, lean) in parts {
        let mut vertex = |x: f64, y: f64, z: f64| {
            let (dx, dy, dz) = (x * half[0], y * half[1], z * half[2]);
            let x = centre[0] + dx + lean * dz;
            writeln!(out, "v {x:.4} {:.4} {:.4}", centre[1] + dy, centre[2] + dz).unwrap();
        };
        vertex(0.0, 0.0, -1.0);
        for ring in 1..=RINGS {
            let (s, c) = libm::sincos(std::f64::consts::PI * (ring as f64 / (RINGS + 1) as f64 - 0.5));
            for k in 0..AROUND {
                let (sin, cos) = libm::sincos(std::f64::consts::TAU * k as f64 / AROUND as f64);
                vertex(c * cos, c * sin, s);
            }
        }
        vertex(0.0, 0.0, 1.0);
        let at = |ring: usize, k: usize| base + 1 + (ring - 1) * AROUND + k % AROUND;
        let top = base + 1 + RINGS * AROUND;
        for k in 0..AROUND {
            writeln!(out, "f {base} {} {}", at(1, k + 1), at(1, k)).unwrap();
            for ring in 1..RINGS {
                let (a, b) = (at(ring, k), at(ring, k + 1));
                writeln!(out, "f {a} {b} {} {}", at(ring + 1, k + 1), at(ring + 1, k)).unwrap();
            }
            writeln!(out, "f {} {} {top}", at(RINGS, k), at(RINGS, k + 1)).unwrap();
        }
        base = top + 1;
    }
    out
}

/// What comes from a lathe, as an OBJ file.
fn turned(title: &str, line: &[[f32; 2]], parts: u32) -> String {
    let line: Vec<Vec2> = line.iter().map(|p| Vec2::from(*p)).collect();
    let mesh = Mesh::turned(&line, parts).unwrap();
    assert!(mesh.closed);
    let mut out = format!("# {title}, metres, z up. Made by crates/scene/tests/committed.rs.\n");
    for v in &mesh.vertices {
        // Without the sign of a zero.
        let [x, y, z] = v.to_array().map(|x| (1e4 * x).round() / 1e4 + 0.0);
        writeln!(out, "v {x} {y} {z}").unwrap();
    }
    for t in &mesh.triangles {
        let [a, b, c] = t.map(|i| i + 1);
        writeln!(out, "f {a} {b} {c}").unwrap();
    }
    out
}

#[test]
fn the_cup_and_the_ring_are_what_their_recipes_make() {
    let cup = [[0.0, 0.0], [0.75, 0.0], [0.95, 1.0], [0.83, 1.0], [0.65, 0.12], [0.0, 0.12]];
    let ring: Vec<[f32; 2]> = (0..12)
        .map(|k| {
            let (sin, cos) = trig::sin_cos(std::f32::consts::TAU * k as f32 / 12.0);
            [0.2 + 0.06 * cos, 0.06 * sin]
        })
        .collect();
    let meshes = repository().join("scenes/meshes");
    is_up_to_date(&meshes.join("cup.obj"), &turned("A cup", &cup, 32));
    is_up_to_date(&meshes.join("ring.obj"), &turned("A ring", &ring, 24));
}

#[test]
fn the_hare_is_what_its_recipe_makes() {
    is_up_to_date(&repository().join("scenes/meshes/hare.obj"), &hare());
}
