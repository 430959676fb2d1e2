//! Closed surfaces of revolution.

use rockfall_math::{Vec3, trig};
use rockfall_shape::Mesh;
use std::f32::consts::TAU;

/// Steps around the axis.
const STEPS: u32 = 48;

/// A surface around the z axis: an outline of (distance from the axis, height), counter-clockwise. Where it touches the axis, triangles have
/// no area and are left out.
fn lathe(outline: &[[f32; 2]]) -> Mesh {
    let m = outline.len() as u32;
    let ring = |k: u32| {
        let (s, c) = trig::sin_cos(TAU * k as f32 / STEPS as f32);
        outline.iter().map(move |&[r, z]| Vec3::new(r * c, r * s, z))
    };
    let vertices: Vec<Vec3> = (0..STEPS).flat_map(ring).collect();
    let mut triangles = Vec::new();
    for k in 0..STEPS {
        let (here, next) = (k * m, (k + 1) % STEPS * m);
        for i in 0..m {
            let j = (i + 1) % m;
            triangles.extend([[here + i, next + i, next + j], [here + i, next + j, here + j]]);
        }
    }
    Mesh::from_triangles(&vertices, &triangles).expect("a surface")
}

/// A ring around the z axis, 1 m to the middle of a section of 0.3 m radius.
pub(crate) fn torus() -> Mesh {
    let outline: Vec<[f32; 2]> = (0..24)
        .map(|i| {
            let (s, c) = trig::sin_cos(TAU * i as f32 / 24.0);
            [1.0 + 0.3 * c, 0.3 * s]
        })
        .collect();
    lathe(&outline)
}

/// A bowl, open at the top, z = 0: what lies between half balls of 1 m and of 0.85 m.
pub(crate) fn bowl() -> Mesh {
    let arc = |r: f32, i: u32| {
        let (s, c) = trig::sin_cos(TAU / 4.0 * i as f32 / 12.0);
        [r * s, -r * c]
    };
    let outline: Vec<[f32; 2]> =
        (0..=12).map(|i| arc(1.0, i)).chain((0..=12).rev().map(|i| arc(0.85, i))).collect();
    lathe(&outline)
}

/// A cup that nests in its like: walls that lean outwards, a floor of 0.1 m, open at the top, z = 0.8.
pub(crate) fn cup() -> Mesh {
    lathe(&[[0.0, 0.0], [0.5, 0.0], [1.0, 0.8], [0.9, 0.8], [0.42, 0.1], [0.0, 0.1]])
}
