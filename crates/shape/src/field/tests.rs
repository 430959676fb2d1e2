//! Fields against the mesh that they were sampled from.

use super::*;
use crate::{Hull, MeshReport};
use rand_chacha::ChaCha8Rng;
use rand_core::{Rng, SeedableRng};
use rockfall_math::{DVec3, Isometry, Mat3, Quat, Vec2, trig};
use std::f32::consts::TAU;

fn uniform(rng: &mut ChaCha8Rng) -> f32 {
    rng.next_u32() as f32 / u32::MAX as f32
}

/// A torus around the z axis.
fn torus(ring: f32, tube: f32, [n, m]: [u32; 2]) -> Mesh {
    let around = (0..m).map(|j| {
        let (sin, cos) = trig::sin_cos(TAU * j as f32 / m as f32);
        Vec2::new(ring + tube * cos, tube * sin)
    });
    Mesh::turned(&around.collect::<Vec<_>>(), n).unwrap()
}

fn triangles_of(hull: &Hull) -> Vec<[u32; 3]> {
    (0..hull.normals.len())
        .flat_map(|f| {
            let face: Vec<u32> = hull.face(f).to_vec();
            (1..face.len() - 1).map(move |k| [face[0], face[k], face[k + 1]]).collect::<Vec<_>>()
        })
        .collect()
}

/// A cube with a smaller one left out of its middle.
fn hollow_cube() -> Mesh {
    let hull = Hull::cuboid(Vec3::splat(0.05));
    let outside = triangles_of(&hull);
    let mut vertices: Vec<Vec3> = hull.vertices.to_vec();
    vertices.extend(hull.vertices.iter().map(|v| 0.4 * *v));
    let inside = outside.iter().map(|t| [t[0] + 8, t[2] + 8, t[1] + 8]);
    let triangles: Vec<[u32; 3]> = outside.iter().copied().chain(inside).collect();
    Mesh::from_triangles(&vertices, &triangles).unwrap()
}

fn field(mesh: Mesh, error: f32) -> Field {
    Field::new(Arc::new(mesh), FieldSettings::with_error(error)).unwrap()
}

/// The largest excess over the bound over random points, half of them near the surface.
fn worst(field: &Field, points: usize) -> f64 {
    let mesh = field.mesh();
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let area = mesh.bounds.grown(0.08 * (mesh.bounds.max - mesh.bounds.min).max_element());
    let mut worst = f64::NEG_INFINITY;
    for i in 0..points {
        let mut p = area.min
            + (area.max - area.min) * Vec3::new(uniform(&mut rng), uniform(&mut rng), uniform(&mut rng));
        if i % 2 == 0 {
            // Onto the surface and a little off it.
            let near = mesh.nearest(p.as_dvec3(), f64::INFINITY).unwrap();
            let off = f64::from((uniform(&mut rng) - 0.5) * 4.0 * field.settings().error);
            p = (near.point + off * near.normal).as_vec3();
        }
        let exact = mesh.nearest(p.as_dvec3(), f64::INFINITY).unwrap().distance;
        let found = field.distance(p);
        worst = worst.max((f64::from(found) - exact).abs() - f64::from(field.bound(found)));
        assert!(f64::from(field.least_distance(p)) <= exact + 1e-7);
    }
    worst
}

fn bodies() -> Vec<(&'static str, Mesh, f32)> {
    let cube = Hull::cuboid(Vec3::new(0.05, 0.03, 0.002));
    vec![
        ("torus", torus(0.035, 0.015, [50, 50]), 1e-3),
        ("coarse torus", torus(0.035, 0.015, [8, 5]), 5e-4),
        ("plate", Mesh::from_triangles(&cube.vertices, &triangles_of(&cube)).unwrap(), 1e-3),
        ("hollow cube", hollow_cube(), 1e-3),
    ]
}

#[test]
fn distances_are_within_the_stated_bound() {
    for (name, mesh, error) in bodies() {
        let over = worst(&field(mesh, error), 10_000);
        assert!(over <= 0.0, "{name}: {over} m beyond the bound");
    }
}

#[test]
fn a_million_distances_are_within_the_stated_bound() {
    for (name, mesh, error) in bodies() {
        let field = field(mesh, error);
        let over = worst(&field, 1_000_000);
        println!(
            "{name}: {} cells, {} samples, {:?}, {over:e} beyond",
            field.cells(),
            field.samples().points().len(),
            field.memory()
        );
        assert!(over <= 0.0, "{name}: {over} m beyond the bound");
    }
}

#[test]
fn a_cavity_is_outside() {
    let field = field(hollow_cube(), 1e-3);
    let in_cavity = field.nearest(Vec3::new(0.005, 0.0, 0.0));
    assert!((in_cavity.distance - 0.015).abs() <= field.bound(in_cavity.distance));
    let in_wall = field.distance(Vec3::new(0.035, 0.0, 0.0));
    assert!((in_wall + 0.015).abs() <= field.bound(in_wall));
    // From the wall towards the cavity is out.
    let near = field.nearest(Vec3::new(0.025, 0.0, 0.0));
    assert!(near.distance < 0.0 && near.normal.x < -0.99, "{near:?}");
}

/// At the faces between cells of different sizes, from both sides.
#[test]
fn distances_do_not_jump_between_cells() {
    let field = field(torus(0.035, 0.015, [8, 5]), 5e-4);
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let unit = field.octree.cell / 64.0;
    let mut seams = 0;
    for _ in 0..50_000 {
        let mut p = Vec3::from([0, 1, 2].map(|_| (uniform(&mut rng) - 0.5) * 0.1));
        p.z *= 0.4;
        p.x = field.octree.origin.x + ((p.x - field.octree.origin.x) / unit).round() * unit;
        let step = 1e-7 * Vec3::X;
        let [a, b] = [p - step, p + step].map(|p| field.octree.spot(p));
        seams += usize::from(a.edge != b.edge);
        let jump = field.distance(p + step) - field.distance(p - step);
        assert!(jump.abs() < 1e-6, "{jump} at {p}");
    }
    assert!(seams > 100, "{seams}");
}

#[test]
fn normals_of_a_smooth_body_are_those_of_its_surface() {
    let field = field(torus(0.035, 0.015, [96, 64]), 1e-3);
    let mut worst = 1.0_f32;
    for i in 0..1000 {
        let (s, c) = trig::sin_cos(0.37 * i as f32);
        let (t, d) = trig::sin_cos(1.13 * i as f32);
        let out = Vec3::new(d * c, d * s, t);
        let p = 0.035 * Vec3::new(c, s, 0.0) + 0.0155 * out;
        worst = worst.min(field.nearest(p).normal.dot(out));
    }
    // Away from the surface the distance may be off by a quarter of itself, and so its slope by a quarter.
    assert!(trig::acos(worst) < 0.25, "{}", trig::acos(worst));
}

#[test]
fn no_point_of_the_surface_is_further_from_a_sample_than_the_spacing() {
    for (name, mesh, error) in bodies() {
        let field = field(mesh, error);
        let (mesh, spacing) = (field.mesh(), field.settings().spacing);
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for _ in 0..1000 {
            let t = rng.next_u32() as usize % mesh.triangles.len();
            let [a, b, c] = mesh.triangle(t);
            let (mut u, mut v) = (uniform(&mut rng), uniform(&mut rng));
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let p = a + u * (b - a) + v * (c - a);
            let least =
                field.samples().points().iter().map(|s| s.position.distance(p)).fold(f32::INFINITY, f32::min);
            assert!(least <= spacing, "{name}: {least}");
        }
    }
}

#[test]
fn a_search_finds_all_samples_in_a_ball() {
    let field = field(torus(0.035, 0.015, [50, 50]), 1e-3);
    let points = field.samples().points();
    for (k, p) in points.iter().enumerate().step_by(97) {
        let inside = |q: Vec3| q.distance(p.position) <= 0.01;
        let mut found = Vec::new();
        let mut balls = 0;
        field.samples().search(
            |[x, y, z, radius]| {
                balls += x.len();
                let center = |i: usize| Vec3::new(x[i], y[i], z[i]);
                std::array::from_fn(|i| center(i).distance(p.position) - radius[i])
            },
            |bound| bound <= 0.01,
            |range, [x, y, z, _]| {
                for (i, k) in range.enumerate() {
                    assert_eq!(points[k].position, Vec3::new(x[i], y[i], z[i]));
                    if inside(points[k].position) {
                        found.push(k);
                    }
                }
            },
        );
        let all: Vec<usize> = (0..points.len()).filter(|&i| inside(points[i].position)).collect();
        assert_eq!(found, all, "{k}");
        assert!(balls < points.len() / 4, "{balls}");
    }
}

#[test]
fn eight_places_have_the_distances_that_each_has_alone() {
    let field = field(torus(0.035, 0.015, [50, 50]), 1e-3);
    let wave = |k: u64| (rockfall_math::hash::mix(k) >> 40) as f32 / (1 << 23) as f32 - 1.0;
    let pose = |k: u64| {
        let turn = Quat::from_xyzw(wave(k), wave(k + 1), wave(k + 2), 1.1).normalize();
        let translation = 0.02 * Vec3::new(wave(k + 3), wave(k + 4), wave(k + 5));
        Isometry { rotation: Mat3::from_quat(turn), translation }
    };
    for k in (0..400).map(|k| 100 * k) {
        // The last ones far out, or nowhere.
        let size = if k < 39_000 { 0.06 } else { 0.5 };
        let mut places: Balls =
            std::array::from_fn(|axis| std::array::from_fn(|i| size * wave(k + 10 * i as u64 + axis as u64)));
        places[0][7] = [f32::NAN, f32::INFINITY, 1.0][k as usize / 100 % 3];
        let (own, here) = (pose(k + 80), pose(k + 90));
        let least = field.least_distances(&places, &own, &here);
        let below = field.distances_below(&places, &own, &here, 0.1);
        for i in 0..8 {
            let p = here.inverse_point(own.point(Vec3::new(places[0][i], places[1][i], places[2][i])));
            assert_eq!(least[i].to_bits(), field.least_distance(p).to_bits(), "{p}");
            let bits = |said: Result<f32, f32>| said.map(f32::to_bits).map_err(f32::to_bits);
            assert_eq!(bits(below[i]), bits(field.distance_below(p, 0.1)), "{p}");
        }
    }
}

#[test]
fn any_number_of_threads_makes_the_same_field() {
    let make = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| field(torus(0.035, 0.015, [20, 12]), 1e-3))
    };
    let (one, three) = (make(1), make(3));
    assert!(one.octree == three.octree && one.samples == three.samples && one.inner == three.inner);
}

#[test]
fn the_inner_ball_is_inside() {
    let field = field(torus(0.035, 0.015, [50, 50]), 1e-3);
    let (center, radius) = field.inner_ball();
    assert!(radius > 0.0125 && radius < 0.015, "{radius}");
    let exact = field.mesh().nearest(center.as_dvec3(), f64::INFINITY).unwrap().distance;
    assert!((exact + f64::from(radius)).abs() < 1e-6);
}

/// Two cubes of 0.1 m, the second one moved along x.
fn two_cubes(shift: f32) -> Mesh {
    let hull = Hull::cuboid(Vec3::splat(0.05));
    let one = triangles_of(&hull);
    let vertices: Vec<Vec3> = hull
        .vertices
        .iter()
        .copied()
        .chain(hull.vertices.iter().map(|v| *v + shift * Vec3::new(1.0, 0.1, 0.2)))
        .collect();
    let triangles: Vec<[u32; 3]> = one.iter().copied().chain(one.iter().map(|t| t.map(|c| c + 8))).collect();
    Mesh::from_triangles(&vertices, &triangles).unwrap()
}

#[test]
fn parts_that_lie_within_each_other_are_refused() {
    let made = |shift: f32| Field::new(Arc::new(two_cubes(shift)), FieldSettings::with_error(2e-3));
    for shift in [0.05, 0.09, 0.0995] {
        let Err(FieldError::Crossed { count, of, at }) = made(shift) else { panic!("at {shift}") };
        assert!(count > 0 && count < of);
        // Where they overlap, or no further off than the error.
        assert!(at.x > shift - 0.05 - 3e-3 && at.x < 0.05 + 3e-3, "{at}");
    }
    for shift in [0.105, 0.2] {
        assert!(made(shift).is_ok(), "{shift}");
    }
}

#[test]
fn every_corner_and_edge_that_sticks_out_is_known_to_a_sample_near_it() {
    for (name, mesh, error) in bodies() {
        let field = field(mesh, error);
        let (features, samples, mesh) = (field.features(), field.samples().points(), field.mesh());
        let spacing = field.settings().spacing;
        let mut corners = vec![f32::INFINITY; mesh.vertices.len()];
        let mut edges = vec![Vec::new(); features.edges().len()];
        for (i, sample) in samples.iter().enumerate() {
            for feature in features.near(i) {
                match feature {
                    Feature::Corner(v) => {
                        corners[v as usize] = sample.position.distance(mesh.vertices[v as usize])
                    }
                    Feature::Edge(e) => edges[e as usize].push(sample.position),
                }
            }
        }
        for (edge, known) in features.edges().iter().zip(&edges) {
            let [a, b] = edge.ends.map(|v| mesh.vertices[v as usize]);
            assert!(edge.ends.iter().all(|&v| corners[v as usize] <= spacing), "{name}");
            for k in 0..=10 {
                let p = a + (b - a) * (k as f32 / 10.0);
                assert!(known.iter().any(|q| q.distance(p) <= spacing), "{name}: {p}");
            }
        }
        let convex =
            mesh.edges.as_flattened().iter().filter(|kind| **kind == crate::EdgeKind::Convex).count();
        assert_eq!(2 * features.edges().len(), convex, "{name}");
    }
}

#[test]
fn what_has_no_field_says_why() {
    let message = |mesh: Mesh, settings| Field::new(Arc::new(mesh), settings).unwrap_err().to_string();
    let ring = torus(0.035, 0.015, [8, 5]);
    let fine = FieldSettings::with_error(1e-3);
    let open = Mesh::from_triangles(&ring.vertices, &ring.triangles[1..]).unwrap();
    assert_eq!(
        message(open, fine),
        "the mesh is not closed, so that it has no inside: 3 of its edges have one triangle only, and 0 have more than two or two that show \
         different sides; expected that each edge joins two triangles"
    );
    let turned: Vec<[u32; 3]> = ring.triangles.iter().map(|t| [t[0], t[2], t[1]]).collect();
    let inside_out = Mesh::from_triangles(&ring.vertices, &turned).unwrap();
    assert_eq!(inside_out.report, MeshReport::default());
    assert_eq!(
        message(inside_out, fine),
        "the mesh is inside out: expected triangles that are counter-clockwise from outside"
    );
    for error in [0.0, -1.0, f32::NAN, f32::INFINITY, 1e-6, 1.0] {
        let said = message(ring.clone(), FieldSettings { error, ..fine });
        assert!(said.starts_with(&format!("the error of the field is {error} m, expected 0.00")), "{said}");
    }
    // Of a kilometre in samples of a hundred millimetres.
    let large: Vec<Vec3> = ring.vertices.iter().map(|v| 1e4 * *v).collect();
    let large = Mesh::from_triangles(&large, &ring.triangles).unwrap();
    let said = message(large, FieldSettings { error: 10.0, spacing: 0.11 });
    assert!(said.contains("points of the surface, more than 4194304"), "{said}");
}

mod cache {
    use super::*;
    use std::fs;

    fn mesh() -> Arc<Mesh> {
        Arc::new(torus(0.035, 0.015, [12, 8]))
    }

    const SETTINGS: FieldSettings = FieldSettings { error: 1e-3, spacing: 4e-3 };

    #[test]
    fn a_field_is_sampled_once() {
        let folder = tempfile::tempdir().unwrap();
        let below = folder.path().join("a").join("b");
        let (first, how) = Field::cached(mesh(), SETTINGS, &below).unwrap();
        let CacheUse::Written(path) = how else { panic!("{how:?}") };
        let (second, how) = Field::cached(mesh(), SETTINGS, &below).unwrap();
        assert!(matches!(how, CacheUse::Read(read) if read == path));
        assert!(first.octree == second.octree && first.samples == second.samples);
        assert!(first.inner == second.inner && first.key == second.key);
        // Another error, another spacing, another mesh: another file.
        for other in [FieldSettings { error: 2e-3, ..SETTINGS }, FieldSettings { spacing: 5e-3, ..SETTINGS }]
        {
            let (_, how) = Field::cached(mesh(), other, &below).unwrap();
            assert!(matches!(how, CacheUse::Written(_)));
        }
        let (_, how) = Field::cached(Arc::new(torus(0.035, 0.0151, [12, 8])), SETTINGS, &below).unwrap();
        assert!(matches!(how, CacheUse::Written(_)));
        assert_eq!(fs::read_dir(&below).unwrap().count(), 4);
    }

    #[test]
    fn a_torn_or_wrong_file_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let (field, how) = Field::cached(mesh(), SETTINGS, folder.path()).unwrap();
        let CacheUse::Written(path) = how else { panic!("{how:?}") };
        let whole = fs::read(&path).unwrap();
        let mut altered = whole.clone();
        altered[whole.len() / 2] ^= 1;
        let other = torus(0.036, 0.015, [12, 8]);
        let (_, how) = Field::cached(Arc::new(other), SETTINGS, folder.path()).unwrap();
        let CacheUse::Written(another) = how else { panic!("{how:?}") };
        let foreign = fs::read(another).unwrap();
        for wrong in [&[][..], &whole[..whole.len() - 1], &altered, &foreign, b"no field"] {
            fs::write(&path, wrong).unwrap();
            let (again, how) = Field::cached(mesh(), SETTINGS, folder.path()).unwrap();
            assert!(matches!(how, CacheUse::Written(_)), "{how:?}");
            assert!(field.octree == again.octree);
            assert_eq!(fs::read(&path).unwrap(), whole);
        }
    }

    #[test]
    fn a_folder_that_can_not_be_written_is_no_error() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, b"no folder").unwrap();
        let (_, how) = Field::cached(mesh(), SETTINGS, &file).unwrap();
        assert!(matches!(how, CacheUse::Kept(_)), "{how:?}");
    }

    /// What passes the checksums but leads nowhere.
    #[test]
    fn an_octree_that_does_not_fit_together_is_not_sound() {
        let (field, _) = Field::cached(mesh(), SETTINGS, tempfile::tempdir().unwrap().path()).unwrap();
        assert!(store::is_sound(&field.octree));
        let broken = |change: fn(&mut Octree)| {
            let mut octree = field.octree.clone();
            change(&mut octree);
            !store::is_sound(&octree)
        };
        assert!(broken(|o| o.roots.truncate(3)));
        assert!(broken(|o| o.roots[0] = 1 << 20));
        assert!(broken(|o| o.nodes[3][2] = 3));
        assert!(broken(|o| o.nodes[0][0] = octree::LEAF | 1 << 30));
        assert!(broken(|o| o.leaves[5][1] = f32::NAN));
        assert!(broken(|o| o.cell = 0.0));
    }

    #[test]
    fn distances_in_a_cached_field_are_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let p = DVec3::new(0.04, 0.01, 0.0).as_vec3();
        let [a, b] = [0, 1].map(|_| Field::cached(mesh(), SETTINGS, folder.path()).unwrap().0.nearest(p));
        assert_eq!(a, b);
    }
}
