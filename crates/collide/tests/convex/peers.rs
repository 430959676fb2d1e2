//! Other libraries' word: distances of random poses, compared by `tests/compare_with_peers.py` with `coal` and `python-fcl`.

use crate::brute_force::size;
use crate::common::Random;
use rockfall_collide::{Distance, distance};
use rockfall_math::{Isometry, Vec3};
use rockfall_shape::Shape;
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

/// The variable that names a Python with the packages of `tests/requirements.txt`; the `test` script sets it.
const PYTHON: &str = "ROCKFALL_PYTHON";

/// Sphere, box, capsule, hull, half-space, plate or needle, large hull, cylinder, cone, ellipsoid.
const CLASSES: [usize; 10] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9];

/// A shape in one word for each number; nothing for a truncated cone, which the others lack.
fn words(shape: &Shape) -> Option<String> {
    let flat =
        |points: &[Vec3]| points.iter().map(|p| format!(" {} {} {}", p.x, p.y, p.z)).collect::<String>();
    Some(match shape {
        Shape::Sphere { radius } => format!("sphere {radius}"),
        Shape::Box { half } => format!("box{}", flat(&[*half])),
        Shape::Capsule { half_length, radius } => format!("capsule {half_length} {radius}"),
        Shape::Cylinder { half_length, radius } => format!("cylinder {half_length} {radius}"),
        Shape::Cone { half_length, lower, upper: 0.0 } => format!("cone {half_length} {lower}"),
        Shape::Ellipsoid { half } => format!("ellipsoid{}", flat(&[*half])),
        Shape::HalfSpace { normal, offset } => format!("halfspace{} {offset}", flat(&[*normal])),
        Shape::Hull(hull) => {
            let mut triangles = String::new();
            for f in 0..hull.normals.len() {
                let face = hull.face(f);
                for k in 2..face.len() {
                    let _ = write!(triangles, " {} {} {}", face[0], face[k - 1], face[k]);
                }
            }
            format!("hull {}{}{triangles}", hull.vertices.len(), flat(&hull.vertices))
        }
        _ => return None,
    })
}

/// What is compared: size, distance, normal, point of A, point of B, pose of B by columns, A, B.
fn line(a: &Shape, b: &Shape, b_in_a: &Isometry) -> Option<String> {
    let Distance { distance, normal, on_a, on_b } = distance(a, b, b_in_a)?;
    let of = |shape: &Shape| if matches!(shape, Shape::HalfSpace { .. }) { 0.0 } else { size(shape) };
    let scale = of(a) + of(b) + 0.5 * b_in_a.translation.length();
    let Isometry { rotation: r, translation } = b_in_a;
    let mut line = format!("{scale} {distance}");
    for v in [normal, on_a, on_b, r.x_axis, r.y_axis, r.z_axis, *translation] {
        let _ = write!(line, " {} {} {}", v.x, v.y, v.z);
    }
    Some(format!("{line}|{}|{}", words(a)?, words(b)?))
}

fn poses(first: usize, second: usize, count: usize) -> Vec<String> {
    let mut random = Random((first * 32 + second) as u64);
    let mut lines = Vec::new();
    while lines.len() < count {
        let (a, b) = (random.shape(first), random.shape(second));
        let along = random.direction();
        let rotation = random.rotation();
        let translation = if let Shape::HalfSpace { normal, offset } = a {
            (offset + random.between(-0.2, 1.2) * size(&b)) * normal + along.cross(normal)
        } else {
            random.between(0.2, 1.4) * (size(&a) + size(&b)) * along
        };
        lines.extend(line(&a, &b, &Isometry { rotation, translation }));
    }
    lines
}

fn compare(count: usize) {
    let Some(python) = std::env::var_os(PYTHON) else {
        println!(
            "SKIPPED: {PYTHON} is not set; `./test` makes a Python with coal and python-fcl and sets it"
        );
        return;
    };
    let mut all = Vec::new();
    for (k, &first) in CLASSES.iter().enumerate() {
        // Of two, the half-space comes first.
        for &second in &CLASSES[k..] {
            match (first, second) {
                (4, 4) => {}
                (_, 4) => all.extend(poses(4, first, count)),
                _ => all.extend(poses(first, second, count)),
            }
        }
    }
    let folder = tempfile::tempdir().expect("a folder for the poses");
    let file = folder.path().join("poses.txt");
    std::fs::write(&file, all.join("\n")).expect("room for the poses");
    let output = Command::new(&python)
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/compare_with_peers.py"))
        .arg(&file)
        .output()
        .unwrap_or_else(|error| panic!("cannot start {}: {error}", python.display()));
    let said = String::from_utf8_lossy(&output.stdout);
    print!("{said}");
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    assert!(said.contains(&format!("{} poses", all.len())), "{said}");
}

/// Promise: distances, normals and nearest points are those of `coal`, and distances those of FCL where that has them, to the tolerances that the script
/// states.
#[test]
fn distances_are_those_of_coal_and_fcl() {
    compare(50);
}

#[test]
#[ignore = "minutes: a hundred thousand poses"]
fn a_hundred_thousand_distances_are_those_of_coal_and_fcl() {
    compare(2000);
}
