//! Distances and depths that MuJoCo's tests of GJK and EPA list, with their poses.

use crate::brute_force::manifold;
use rockfall_collide::distance;
use rockfall_math::{DMat3, DVec3, Isometry, Vec3};
use rockfall_shape::Shape;

/// Rows of a rotation, as MuJoCo prints them, and a place.
struct Place([[f64; 3]; 3], [f64; 3]);

const UPRIGHT: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn b_in_a(a: &Place, b: &Place) -> Isometry {
    let turn = |place: &Place| DMat3::from_cols_array_2d(&place.0).transpose();
    let back = turn(a).transpose();
    let way = back * (DVec3::from(b.1) - DVec3::from(a.1));
    Isometry { rotation: (back * turn(b)).as_mat3(), translation: way.as_vec3() }
}

/// Promise: of eight pairs of spheres and boxes, some of them plates nearly flat on each other, the signed distance is MuJoCo's to 1e-6 m, of boxes also that of
/// the deepest contact, whose normal is the one that MuJoCo gives, to 1e-3 rad: a plate tilts by that.
#[test]
fn signed_distances_are_those_that_mujoco_lists() {
    let ball = |radius: f32| Shape::Sphere { radius };
    let cuboid = |half: [f32; 3]| Shape::Box { half: Vec3::from(half) };
    let plate = || cuboid([0.25, 0.25, 0.05]);
    let at = |p: [f64; 3]| Place(UPRIGHT, p);
    let origin = || at([0.0; 3]);
    let down = DVec3::NEG_Z;
    let cases = [
        (ball(1.0), ball(1.0), at([-1.5, 0.0, 0.0]), at([1.5, 0.0, 0.0]), 1.0, DVec3::X),
        (ball(3.0), ball(3.0), at([-1.0, 0.0, 0.0]), at([3.0, 0.0, 0.0]), -2.0, DVec3::X),
        (cuboid([2.5; 3]), cuboid([1.0; 3]), at([-1.0, 0.0, 0.0]), at([1.5, 0.0, 0.0]), -1.0, DVec3::X),
        (
            cuboid([5.0, 5.0, 0.1]),
            cuboid([1.0; 3]),
            origin(),
            Place(
                [
                    [0.999999966039443, -3.3960556969622e-8, -0.000260616790777324],
                    [-3.3960556972087e-8, 0.999999966039443, -0.000260616790777322],
                    [0.000260616790777324, 0.000260616790777322, 0.999999932078886],
                ],
                [-0.000171208577507292, -0.000171208577507291, 1.06711958624855],
            ),
            -0.033401579411886845,
            DVec3::Z,
        ),
        (
            plate(),
            plate(),
            Place(
                [
                    [0.965925826289068, -0.258819045102521, 0.0],
                    [0.258819045102521, 0.965925826289068, 0.0],
                    [0.0, 0.0, 1.0],
                ],
                [-0.0153465, -0.0235055, -4.562_296_442_400_121],
            ),
            Place(
                [[0.866025403784439, -0.5, 0.0], [0.5, 0.866025403784439, 0.0], [0.0, 0.0, 1.0]],
                [-0.0153465, -0.0235055, -4.659_230_360_891_631],
            ),
            -0.003066,
            down,
        ),
        (
            plate(),
            plate(),
            Place(
                [
                    [0.500063246694118, -0.865988885078582, -1.5036290463686e-5],
                    [0.865988885208802, 0.500063246603651, 9.541064416583e-6],
                    [-7.43359510433e-7, -1.7792396065398e-5, 0.999999999841439],
                ],
                [-0.0153467189251435, -0.0235004487932298, -4.85938271725998],
            ),
            Place(
                [
                    [0.999999999448634, -3.3207420761195e-5, -4.4925527334e-8],
                    [3.3207420790207e-5, 0.999999999448429, 6.41458652741e-7],
                    [4.4904226122e-8, -6.41460144248e-7, 0.999999999999794],
                ],
                [-0.0153477497103841, -0.0235006012732136, -4.95878285459475],
            ),
            -0.000_604_251_192_427_074_6,
            down,
        ),
        (
            plate(),
            plate(),
            Place(
                [
                    [0.965955045562010, -0.258709898141740, -0.000196358811267032],
                    [0.258709919231420, 0.965955055634175, 9.0476785846218e-5],
                    [0.000166266546411240, -0.000138196479997660, 0.999999976628583],
                ],
                [-0.0153815244981570, -0.0235279318903966, -4.55921400440950],
            ),
            Place(
                [
                    [0.866076536677694, -0.499911388413602, -0.000190658753729162],
                    [0.499911409912062, 0.866076540935323, 8.6494189368211e-5],
                    [0.000121885643632021, -0.000170223074359587, 0.999999978083999],
                ],
                [-0.0153586685909217, -0.0235420705046114, -4.65910835487699],
            ),
            -0.0001077858631973211,
            down,
        ),
        (
            cuboid([0.5, 0.5, 0.1]),
            cuboid([0.1; 3]),
            at([0.0, 0.0, -0.1]),
            Place(
                [
                    [-0.412617528992808, -0.910903939143411, -0.000887930675351448],
                    [0.910904370383107, -0.412617275794986, -0.000460143975736546],
                    [5.2771423713213e-5, -0.000998683403024198, 0.999999499923193],
                ],
                [0.413029898172642, 0.190777715293135, 0.100006658017412],
            ),
            -0.00009843,
            DVec3::Z,
        ),
    ];
    for (i, (a, b, first, second, exact, normal)) in cases.iter().enumerate() {
        let pose = b_in_a(first, second);
        let found = f64::from(distance(a, b, &pose).expect("they have one").distance);
        assert!((found - exact).abs() < 1e-6, "{i}: {found} in place of {exact}");
        if *exact < 0.0 {
            let found = manifold(a, b, &pose, 0.0).expect("they overlap");
            assert!((f64::from(found.deepest()) - exact).abs() < 1e-6, "{i}: {found:?}");
            let out = DMat3::from_cols_array_2d(&first.0).transpose() * found.normal.as_dvec3();
            assert!((out - *normal).length() < 1e-3, "{i}: {out} in place of {normal}");
        }
    }
}
