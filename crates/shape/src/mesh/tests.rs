//! Meshes of good and bad triangles.

use super::*;
use crate::{Hull, Shape};
use std::sync::Arc;

/// A box as triangles, corners not shared.
fn soup(half: Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let hull = Hull::cuboid(half);
    let vertices: Vec<Vec3> = hull.triangles().flatten().map(|p| p.as_vec3()).collect();
    let triangles = (0..vertices.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    (vertices, triangles)
}

fn cube() -> Mesh {
    let (vertices, triangles) = soup(Vec3::ONE);
    Mesh::from_triangles(&vertices, &triangles).unwrap()
}

#[test]
fn a_soup_of_a_cube_becomes_a_closed_mesh() {
    let mesh = cube();
    mesh.check().unwrap();
    assert!(mesh.closed);
    assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (8, 12));
    assert_eq!(mesh.report, MeshReport { dropped_vertices: 28, ..MeshReport::default() });
    let kinds = mesh.edges.as_flattened();
    assert_eq!(kinds.iter().filter(|k| **k == EdgeKind::Flat).count(), 12);
    assert_eq!(kinds.iter().filter(|k| **k == EdgeKind::Convex).count(), 24);
    let inside = Shape::Mesh(Arc::new(mesh));
    assert!(inside.has_inside() && !inside.is_convex());
    inside.validate().unwrap();
}

#[test]
fn a_cube_seen_from_inside_has_concave_edges_and_no_inside() {
    let (vertices, mut triangles) = soup(Vec3::ONE);
    triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let room = Mesh::from_triangles(&vertices, &triangles).unwrap();
    assert!(room.closed);
    assert_eq!(room.edges.as_flattened().iter().filter(|k| **k == EdgeKind::Concave).count(), 24);
    assert!(!Shape::Mesh(Arc::new(room)).has_inside());
}

#[test]
fn neighbours_name_each_other() {
    let mesh = cube();
    for (t, neighbours) in mesh.neighbours.iter().enumerate() {
        for (i, &n) in neighbours.iter().enumerate() {
            let [u, v] = [mesh.triangles[t][i], mesh.triangles[t][(i + 1) % 3]];
            let j = (0..3).find(|&j| mesh.triangles[n as usize][j] == v).unwrap();
            assert_eq!(mesh.triangles[n as usize][(j + 1) % 3], u);
            assert_eq!(mesh.neighbours[n as usize][j], t as u32);
        }
    }
}

#[test]
fn the_tree_finds_the_triangles_of_a_region() {
    let mesh = cube();
    let mut found = Vec::new();
    let top = Aabb::new(Vec3::new(-2.0, -2.0, 0.9), Vec3::splat(2.0));
    mesh.tree.query(&top, |t| found.push(t as usize));
    found.sort_unstable();
    let expected: Vec<usize> =
        (0..12).filter(|&t| Aabb::from_points(mesh.triangle(t)).overlaps(&top)).collect();
    assert_eq!(found, expected);
    assert_eq!(found.len(), 10);
}

#[test]
fn bad_triangles_are_left_out_and_counted() {
    let (mut vertices, mut triangles) = soup(Vec3::ONE);
    vertices.push(Vec3::new(7.0, 7.0, 7.0));
    triangles.push([0, 0, 1]);
    // The corners 0 and 3 of the soup are the same place.
    assert_eq!(vertices[0], vertices[3]);
    triangles.push([0, 3, 1]);
    triangles.push([triangles[4][1], triangles[4][2], triangles[4][0]]);
    let mesh = Mesh::from_triangles(&vertices, &triangles).unwrap();
    assert!(mesh.closed);
    assert_eq!(mesh.bounds, Aabb::new(-Vec3::ONE, Vec3::ONE));
    let report =
        MeshReport { dropped_vertices: 29, degenerate_triangles: 2, duplicate_triangles: 1, ..mesh.report };
    assert_eq!(mesh.report, report);
}

#[test]
fn open_and_tangled_edges_are_boundaries_and_counted() {
    let (vertices, mut triangles) = soup(Vec3::ONE);
    triangles.pop();
    let open = Mesh::from_triangles(&vertices, &triangles).unwrap();
    assert!(!open.closed);
    assert_eq!((open.report.open_edges, open.report.tangled_edges), (3, 0));
    assert!(!Shape::Mesh(Arc::new(open)).has_inside());

    // Three triangles on the edge from 0 to 1.
    let fin = [Vec3::ZERO, Vec3::X, Vec3::Y, -Vec3::Y, Vec3::Z];
    let mesh = Mesh::from_triangles(&fin, &[[0, 1, 2], [1, 0, 3], [0, 1, 4]]).unwrap();
    assert_eq!((mesh.report.open_edges, mesh.report.tangled_edges), (6, 1));
    assert_eq!(mesh.edges, vec![[EdgeKind::Boundary; 3]; 3]);

    // Two triangles that disagree about what is outside.
    let mesh = Mesh::from_triangles(&fin, &[[0, 1, 2], [0, 1, 3]]).unwrap();
    assert_eq!((mesh.report.open_edges, mesh.report.tangled_edges), (4, 1));
}

#[test]
fn an_edge_is_flat_below_a_thousandth_of_a_radian_only() {
    let kind = |rise: f32| {
        let v = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::new(0.0, -1.0, rise)];
        Mesh::from_triangles(&v, &[[0, 1, 2], [1, 0, 3]]).unwrap().edges[0][0]
    };
    assert_eq!(kind(0.0), EdgeKind::Flat);
    assert_eq!([kind(0.0009), kind(-0.0009)], [EdgeKind::Flat; 2]);
    assert_eq!([kind(0.0011), kind(-0.0011)], [EdgeKind::Concave, EdgeKind::Convex]);
    let folded = [Vec3::ZERO, Vec3::X, Vec3::Y, 2.0 * Vec3::Y];
    let knife = Mesh::from_triangles(&folded, &[[0, 1, 2], [1, 0, 3]]).unwrap();
    assert_eq!(knife.edges[0][0], EdgeKind::Convex);
}

#[test]
fn input_that_makes_no_mesh_is_refused() {
    let v = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let message = |v: &[Vec3], t: &[[u32; 3]]| Mesh::from_triangles(v, t).unwrap_err().to_string();
    assert_eq!(message(&v, &[]), "the mesh has no triangles");
    assert_eq!(message(&[], &[]), "the mesh has no triangles");
    assert_eq!(
        message(&v, &[[0, 1, 2], [0, 1, 3]]),
        "triangle 1 of the mesh names vertex 3, but there are only 3"
    );
    assert_eq!(message(&[Vec3::NAN, v[1], v[2]], &[[0, 1, 2]]), "vertex 0 of the mesh is not finite");
    assert_eq!(
        message(&[v[0], v[1], 1e20 * v[2]], &[[0, 1, 2]]),
        "vertex 2 of the mesh is more than 1000 km from the origin"
    );
    let line = [Vec3::ZERO, Vec3::X, 2.0 * Vec3::X];
    assert_eq!(message(&line, &[[0, 1, 2], [0, 0, 1]]), "none of the 2 triangles of the mesh has an area");
}

#[test]
fn a_surface_goes_around_a_point_as_often_as_it_is_nested() {
    let (vertices, triangles) = soup(Vec3::ONE);
    let twice = |shift: Vec3, scale: f32, turned: bool| {
        let more = vertices.iter().map(|v| shift + scale * *v);
        let count = vertices.len() as u32;
        let swapped = |t: &[u32; 3]| if turned { [t[0], t[2], t[1]] } else { *t };
        let second = triangles.iter().map(|t| swapped(&t.map(|c| c + count)));
        let all: Vec<Vec3> = vertices.iter().copied().chain(more).collect();
        Mesh::from_triangles(&all, &triangles.iter().copied().chain(second).collect::<Vec<_>>()).unwrap()
    };
    let at = |mesh: &Mesh, x: f64| mesh.winding(rockfall_math::DVec3::new(x, 0.1, 0.05));
    let one = cube();
    assert_eq!([-1.5, 0.0, 0.9, 1.1].map(|x| at(&one, x)), [Some(0), Some(1), Some(1), Some(0)]);
    let overlapping = twice(Vec3::X, 1.0, false);
    assert_eq!([-0.5, 0.5, 1.5, 2.5].map(|x| at(&overlapping, x)), [Some(1), Some(2), Some(1), Some(0)]);
    let hollow = twice(Vec3::ZERO, 0.5, true);
    assert_eq!([0.0, 0.7, 1.2].map(|x| at(&hollow, x)), [Some(0), Some(1), Some(0)]);
}

/// Every ray of a fine torus counts the same, also where it passes next to edges.
#[test]
fn the_count_is_that_of_a_torus() {
    let line: Vec<_> = (0..24)
        .map(|k| {
            let (sin, cos) = rockfall_math::trig::sin_cos(std::f32::consts::TAU * k as f32 / 24.0);
            rockfall_math::Vec2::new(1.0 + 0.4 * cos, 0.4 * sin)
        })
        .collect();
    let mesh = Mesh::turned(&line, 48).unwrap();
    for i in 0..20_000_u32 {
        let p = [i % 27, i / 27 % 27, i / 729].map(|k| f64::from(k) / 9.0 - 1.5 + 1e-3 * f64::from(i % 7));
        let p = rockfall_math::DVec3::from(p);
        let near = mesh.nearest(p, f64::INFINITY).unwrap().distance;
        if near.abs() > 1e-9 {
            assert_eq!(mesh.winding(p), Some(i32::from(near < 0.0)), "{p}");
        }
    }
}
