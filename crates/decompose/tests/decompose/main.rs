//! The promises of convex decomposition: of the hulls, and of bodies made of them.

mod lathe;
mod motion;

use lathe::{bowl, torus};
use parry3d::query::PointQuery;
use parry3d::shape::{TriMesh, TriMeshFlags};
use rockfall_collide::nearest_point;
use rockfall_decompose::{Decomposition, Options, decompose};
use rockfall_math::{Vec3, hash};
use rockfall_shape::{Mesh, Shape};
use std::sync::Arc;

/// An L of two boxes.
fn ell() -> Mesh {
    let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 0.5], [0.5, 0.5], [0.5, 2.0], [0.0, 2.0]];
    let corners: Vec<Vec3> = [0.0, 0.75]
        .iter()
        .flat_map(|&y| outline.iter().map(move |&[x, z]: &[f32; 2]| Vec3::new(x, y, z)))
        .collect();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for [a, b, c] in [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]] {
        triangles.extend([[a, b, c], [a + 6, c + 6, b + 6]]);
    }
    for i in 0..6 {
        let j = (i + 1) % 6;
        triangles.extend([[i, i + 6, j + 6], [i, j + 6, j]]);
    }
    Mesh::from_triangles(&corners, &triangles).expect("an L")
}

fn cut(mesh: &Mesh, resolution: u32, max_hulls: u32) -> Decomposition {
    let options = Options { resolution, max_hulls, ..Options::default() };
    decompose(mesh, &options).expect("it is closed")
}

fn report(name: &str, mesh: &Mesh, cut: &Decomposition) {
    let parts = cut.compound.parts();
    let thin = Shape::Compound(Arc::new(cut.compound.clone())).inner_radius();
    let size = 2.0 * mesh.bounds.half_extents().max_element();
    let m = cut.misfit;
    println!("{name}: {} hulls, thinnest {thin}, {m:?}, {:.4} of the size", parts.len(), m.largest() / size);
}

/// Promise: what is reported is what an independent check finds: `parry3d` on the mesh, our support points on the hulls, at random places. None is
/// farther than reported and what lies between samples, and some are nearly as far.
#[test]
fn the_misfit_is_what_an_independent_check_finds() {
    for (name, mesh, hulls) in [("torus", torus(), 8), ("bowl", bowl(), 16), ("L", ell(), 4)] {
        let cut = cut(&mesh, 32, hulls);
        report(name, &mesh, &cut);
        let flags = TriMeshFlags::ORIENTED;
        let judge =
            TriMesh::with_flags(mesh.vertices.clone(), mesh.triangles.clone(), flags).expect("a mesh");
        let mut state = 7_u64;
        let mut number = || {
            state += 1;
            (hash::mix(state) >> 40) as f32 / (1_u64 << 24) as f32
        };
        let half = mesh.bounds.half_extents();
        let (mut missing, mut filled) = (0.0_f32, 0.0_f32);
        for _ in 0..40_000 {
            let p = mesh.bounds.center() + half * (2.0 * Vec3::new(number(), number(), number()) - 1.0);
            let near = judge.project_local_point(p, false);
            let away = near.point.distance(p);
            let from_mesh = if near.is_inside { -away } else { away };
            let from_hulls = (cut.compound.parts().iter())
                .filter_map(|part| nearest_point(&part.shape, p.as_dvec3(), f32::INFINITY))
                .fold(f32::INFINITY, |least, near| least.min(near.distance));
            if from_mesh <= 0.0 {
                missing = missing.max(from_hulls);
            }
            if from_hulls <= 0.0 {
                filled = filled.max(from_mesh);
            }
        }
        println!("{name}: {missing} missing, {filled} filled by {} random points", 40_000);
        let between = 0.87 * cut.misfit.spacing;
        assert!(missing <= cut.misfit.missing + between && filled <= cut.misfit.filled + between);
        assert!(cut.misfit.missing <= missing + between && cut.misfit.filled <= filled + between);
    }
}

/// Promise: more hulls fit better: a torus by 32 hulls at a resolution of 64 to 3 % of its size.
#[test]
fn more_hulls_fit_better() {
    let mesh = torus();
    let mut last = f32::INFINITY;
    for hulls in [4, 8, 32] {
        let cut = cut(&mesh, 64, hulls);
        report("torus", &mesh, &cut);
        assert!(cut.compound.parts().len() <= hulls as usize);
        assert!(cut.misfit.largest() < last);
        last = cut.misfit.largest();
    }
    assert!(last < 0.03 * 2.6, "{last}");
}

/// Promise: the hulls weigh what the mesh does.
#[test]
fn the_mass_is_that_of_the_mesh() {
    let mesh = bowl();
    let cut = cut(&mesh, 32, 16);
    let solid = Shape::Mesh(Arc::new(mesh)).mass_properties(2600.0).expect("it is closed");
    let found =
        Shape::Compound(Arc::new(cut.compound)).mass_properties(2600.0).expect("it stands for a solid");
    assert!((found.mass / solid.mass - 1.0).abs() < 1e-6);
    assert_eq!(found.center, solid.center);
}

/// Promise: the same hulls and the same misfit for any number of threads, and at a thousand times the size.
#[test]
fn the_result_depends_on_the_mesh_alone() {
    let mesh = torus();
    let in_pool = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| cut(&mesh, 32, 8))
    };
    let (one, three) = (in_pool(1), in_pool(3));
    assert_eq!(one.misfit, three.misfit);
    assert_eq!(format!("{:?}", one.compound), format!("{:?}", three.compound));
    let large: Vec<Vec3> = mesh.vertices.iter().map(|v| *v * 1024.0).collect();
    let large = Mesh::from_triangles(&large, &mesh.triangles).expect("a large torus");
    let large = cut(&large, 32, 8);
    assert_eq!(large.compound.parts().len(), one.compound.parts().len());
    assert!((large.misfit.largest() / one.misfit.largest() / 1024.0 - 1.0).abs() < 1e-3);
}

/// Promise: what can't be cut is refused with what was expected.
#[test]
fn what_can_not_be_cut_is_refused() {
    let corners = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let open = Mesh::from_triangles(&corners, &[[0, 1, 2]]).expect("a triangle");
    let said = decompose(&open, &Options::default()).expect_err("it is open").to_string();
    assert!(
        said.starts_with("the mesh has no inside (3 open edges, 0 tangled ones), expected a closed mesh"),
        "{said}"
    );
    let options = Options { max_hulls: 2, ..Options::default() };
    let said = decompose(&ell(), &options).expect_err("too few").to_string();
    assert_eq!(said, "the number of hulls is 2, expected 4 to 1024");
    let mut inside_out = ell();
    inside_out.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    assert!(decompose(&inside_out, &Options::default()).is_err());
}
