//! Boxes, balls, capsules and hulls dropped on hills made of triangles.

use super::random::Random;
use super::{Placed, Scene, pile};
use rockfall::Shape;
use rockfall::math::{DVec3, Pose, Vec2, Vec3};
use rockfall::shape::{HeightField, Mesh};
use std::sync::Arc;

/// Cells along each side of the terrain, one metre wide; each is two triangles.
const CELLS: u32 = 128;

/// Cells from one top or hollow to the next.
const HILL: u32 = 16;

/// Tops and hollows are at ± this height, metres. No slope is steeper than the friction of bodies can hold.
const HEIGHT: f32 = 2.0;

/// Least distance between the walls and what is dropped, metres.
const MARGIN: f32 = 2.0;

/// Shapes of each sort.
const SHAPES: usize = 256;

/// Keys of the random streams; those of shapes and places are in `pile`.
const HEIGHTS: u64 = 3 << 60;

/// Bodies in at least four layers, in a square over the middle of the terrain.
pub(super) fn mixed(count: usize, seed: u64) -> Result<Scene, crate::Error> {
    let terrain = hills(seed)?;
    let width = CELLS as f32;
    let pitch = 1.25;
    let widest = ((width - 2.0 * MARGIN) / pitch) as usize;
    let side = (1..widest).find(|n| 4 * n * n >= count).unwrap_or(widest);
    let layers = count.div_ceil(side * side);

    let mut scene = Scene::walls(0.5 * width, (layers + 2) as f32 * pitch + HEIGHT, -HEIGHT - 1.0);
    scene.fixed.push(Placed { shape: scene.shapes.len(), pose: Pose::at(DVec3::ZERO) });
    scene.shapes.push(Shape::Mesh(Arc::new(mesh(&terrain)?)));
    scene.terrain = Some(terrain);
    let hulls = pile::hull_shapes(SHAPES, seed)?;
    let shapes = hulls.into_iter().enumerate().flat_map(|(i, hull)| {
        let capsule = capsule(i, seed);
        [pile::box_shape(i, seed), pile::ball_shape(i, seed), capsule, hull]
    });
    pile::drop(&mut scene, shapes.collect(), count, side, pitch, HEIGHT, seed);
    Ok(scene)
}

fn capsule(i: usize, seed: u64) -> Shape {
    let mut random = Random::new(seed, pile::SHAPES + (1 << 32) + i as u64);
    Shape::Capsule { half_length: random.between(0.15, 0.3), radius: random.between(0.2, 0.3) }
}

/// Heights between random tops and hollows, smooth in between.
fn hills(seed: u64) -> Result<HeightField, crate::Error> {
    let nodes = CELLS / HILL + 1;
    let node =
        |i: u32, j: u32| Random::new(seed, HEIGHTS + u64::from(j * nodes + i)).between(-HEIGHT, HEIGHT);
    let height = |i: u32, j: u32| {
        // The last sample belongs to the last hill.
        let (x, y) = ((i / HILL).min(nodes - 2), (j / HILL).min(nodes - 2));
        let (u, v) = (ease(i - x * HILL), ease(j - y * HILL));
        let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
        mix(mix(node(x, y), node(x + 1, y), u), mix(node(x, y + 1), node(x + 1, y + 1), u), v)
    };
    let samples = CELLS + 1;
    let heights = (0..samples * samples).map(|n| height(n % samples, n / samples)).collect();
    Ok(HeightField::new(samples, samples, Vec2::ONE, heights)?)
}

/// From 0 to 1 over a hill, flat at both ends.
fn ease(cells: u32) -> f32 {
    let t = cells as f32 / HILL as f32;
    t * t * (3.0 - 2.0 * t)
}

/// The same surface as triangles: not every engine cuts the cells of a height field alike.
fn mesh(field: &HeightField) -> Result<Mesh, crate::Error> {
    let middle = 0.5 * CELLS as f32;
    let samples = CELLS + 1;
    let corner = |(n, &z): (usize, &f32)| {
        let (i, j) = (n as u32 % samples, n as u32 / samples);
        Vec3::new(i as f32 - middle, j as f32 - middle, z)
    };
    let vertices: Vec<Vec3> = field.heights.iter().enumerate().map(corner).collect();
    let cells = (0..CELLS * CELLS).map(|n| n / CELLS * samples + n % CELLS);
    let triangles: Vec<[u32; 3]> = cells
        .flat_map(|a| {
            let (b, c, d) = (a + 1, a + samples + 1, a + samples);
            [[a, b, c], [a, c, d]]
        })
        .collect();
    Ok(Mesh::from_triangles(&vertices, &triangles)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mesh_is_the_height_field() {
        let field = hills(5).expect("hills");
        let mesh = mesh(&field).expect("a mesh");
        assert_eq!(mesh.triangles.len(), 2 * 128 * 128);
        for (t, normal) in mesh.normals.iter().enumerate() {
            let [a, b, c] = mesh.triangle(t);
            let middle = (a + b + c) / 3.0;
            let height = field.height_at(middle.x, middle.y).expect("on the field");
            assert!((middle.z - height).abs() < 1e-5 && normal.z > 0.0, "triangle {t}");
        }
    }

    #[test]
    fn no_slope_is_steeper_than_friction_holds() {
        let mesh = mesh(&hills(5).expect("hills")).expect("a mesh");
        let steepest = mesh.normals.iter().map(|n| n.z).fold(1.0, f32::min);
        let tangent = (1.0 - steepest * steepest).sqrt() / steepest;
        assert!((0.2..super::super::FRICTION).contains(&tangent), "{tangent}");
    }

    #[test]
    fn all_four_sorts_are_dropped() {
        let scene = mixed(20_000, 1).expect("a scene");
        for sort in ["box", "sphere", "capsule", "hull"] {
            let count = scene.bodies.iter().filter(|b| scene.shapes[b.shape].name() == sort).count();
            assert_eq!(count, 5000, "{sort}");
        }
    }
}
