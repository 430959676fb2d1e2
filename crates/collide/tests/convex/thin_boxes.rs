//! Boxes at which collisions in MuJoCo went wrong, as its tests list them: thinner than a millimetre, hardly touching, or deeper in each other than they
//! are thick.
//!
//! The truth is the largest gap along the fifteen axes, in double precision: of boxes that overlap it is the signed distance.

use crate::brute_force::manifold;
use rockfall_collide::{Manifold, distance};
use rockfall_math::{DMat3, DQuat, DVec3, Isometry};
use rockfall_shape::Shape;

/// What MuJoCo asks for in double precision, metres; in single precision it asks for 1e-6.
const EXACT: f64 = 1e-8;

/// Two boxes: half edges, the place of the second, and how both are turned (w, x, y, z).
struct Pair {
    name: &'static str,
    a: [f64; 3],
    b: [f64; 3],
    at: [f64; 3],
    turns: [[f64; 4]; 2],
}

/// The last one overlaps by less than single precision may tell.
const PAIRS: [Pair; 7] = [
    Pair {
        name: "plates, an edge 15 µm over a face",
        a: [0.047, 0.032, 0.00035],
        b: [0.047, 0.032, 0.00035],
        at: [
            -5.352194487262811e-5 - 2.821825771308448e-5,
            0.01427117523229726 + 0.013292121195706197,
            0.029254416229696868 - 0.02925607203779027,
        ],
        turns: [
            [0.8413078708224405, 0.5405489850449948, 0.0015299333749655413, 0.002349587816151039],
            [0.8413227886432264, -0.5405328371688882, 0.00024615852936852315, -0.00039580009650069315],
        ],
    },
    Pair {
        name: "grains, 0.1 mm in each other",
        a: [0.0004435946851825113, 0.0019427705390657074, 0.0005671679001576571],
        b: [0.0006228817555632633, 0.0010906336314477707, 0.00030803275652456415],
        at: [-0.0011513383735175778, -0.0013813387665010076, -0.00043818094448460645],
        turns: [
            [0.28720146798163904, -0.08356181000090748, -0.5185345971782723, 0.8010334651109969],
            [0.5158897735854452, 0.6344510664489523, 0.5096216111120138, -0.26761053656263345],
        ],
    },
    Pair {
        name: "deeper than thick, by a face",
        a: [0.10375412296887962, 0.0014208822825842824, 0.029838770510023913],
        b: [0.004773870482716396, 0.0007140947854610601, 0.0045937794963772805],
        at: [0.027189909560778446, 0.003935055006556199, -0.005523247607722875],
        turns: [
            [-0.1806468116522028, -0.38732117424997786, 0.11417869384387985, 0.8968345796687466],
            [-0.2982961646559716, 0.8451955220617328, 0.23968520782082428, -0.373115168266074],
        ],
    },
    Pair {
        name: "deeper than thick, by edges",
        a: [0.034760484829104925, 0.0007121346731259294, 0.005931487330397722],
        b: [0.013576183806600434, 0.008216226332206124, 0.0011680617239575811],
        at: [0.004439242064513605, -0.004176748325073057, 0.0007814051151228268],
        turns: [
            [0.5866436682665767, 0.3999167118422233, 0.24085697266687636, -0.6617429627807058],
            [-0.35168496783547554, 0.48328103093900215, 0.12063144050164629, -0.792593959159161],
        ],
    },
    Pair {
        name: "edges of a block and a plate",
        a: [0.018352361395955086, 0.038452208042144775, 0.047704100608825684],
        b: [0.026817722246050835, 0.0014398059574887156, 0.008226536214351654],
        at: [-0.02632516250014305, 0.03075334243476391, 0.02338058315217495],
        turns: [
            [-0.9009177684783936, -0.42279955744743347, 0.09701432287693024, -0.013262901455163956],
            [0.239192396402359, 0.05607346072793007, 0.9122782945632935, 0.3277057707309723],
        ],
    },
    Pair {
        name: "edges of a rod and a block",
        a: [0.044790275394916534, 0.005722186993807554, 0.00495378952473402],
        b: [0.026496950536966324, 0.01980442740023136, 0.005734471138566732],
        at: [0.009404403157532215, 0.020275400951504707, -0.017358051612973213],
        turns: [
            [0.040385473519563675, 0.7518953680992126, -0.5543022155761719, 0.3546428084373474],
            [-0.6716417670249939, 0.08577035367488861, 0.6968343257904053, -0.23656430840492249],
        ],
    },
    Pair {
        name: "plates, 25 nm in each other",
        a: [0.07661046832799911, 0.21989625692367554, 0.0005179486470296979],
        b: [0.02934698574244976, 0.00031350101926364005, 0.1565844863653183],
        at: [0.1099575087428093, 0.06743335723876953, -0.27263233065605164],
        turns: [
            [-0.599370002746582, 0.08237090706825256, -0.38643673062324524, 0.6961590051651001],
            [0.05186958238482475, -0.7553620338439941, 0.6043813228607178, 0.24791309237480164],
        ],
    },
];

impl Pair {
    fn boxes(&self) -> [Shape; 2] {
        [self.a, self.b].map(|half| Shape::Box { half: DVec3::from(half).as_vec3() })
    }

    /// B's axes and place in the frame of A.
    fn seen(&self) -> (DMat3, DVec3) {
        let [a, b] =
            self.turns.map(|[w, x, y, z]| DMat3::from_quat(DQuat::from_xyzw(x, y, z, w).normalize()));
        (a.transpose() * b, a.transpose() * DVec3::from(self.at))
    }

    /// The largest gap along an axis, B being moved by `shift` in A's frame.
    fn gap(&self, shift: DVec3) -> f64 {
        let (turn, place) = self.seen();
        let (of_a, of_b) = (DVec3::AXES, [turn.x_axis, turn.y_axis, turn.z_axis]);
        let crossed = of_a.iter().flat_map(|a| of_b.map(|b| a.cross(b)));
        let axes = of_a.into_iter().chain(of_b).chain(crossed).filter_map(|axis| axis.try_normalize());
        let reach = |half: [f64; 3], axes: [DVec3; 3], n: DVec3| {
            (0..3).map(|i| half[i] * axes[i].dot(n).abs()).sum::<f64>()
        };
        axes.map(|n| n.dot(place + shift).abs() - reach(self.a, of_a, n) - reach(self.b, of_b, n))
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// Distance and manifold of the boxes, B being moved by `shift` in A's frame.
    fn meet(&self, shift: DVec3, margin: f32) -> (f64, Option<Manifold>) {
        let (turn, place) = self.seen();
        let pose = Isometry { rotation: turn.as_mat3(), translation: (place + shift).as_vec3() };
        let [a, b] = self.boxes();
        let apart = distance(&a, &b, &pose).expect("boxes have one").distance;
        (f64::from(apart), manifold(&a, &b, &pose, margin))
    }
}

/// Promise: of MuJoCo's listed pairs that overlap, the signed distance is exact to 1e-8 m, and so is the depth of the deepest contact, but for what a face is
/// preferred by: half a percent of the depth, where MuJoCo prefers it by five.
#[test]
fn thin_boxes_are_as_deep_as_mujoco_says() {
    for pair in &PAIRS[1..] {
        let exact = pair.gap(DVec3::ZERO);
        let (apart, manifold) = pair.meet(DVec3::ZERO, 0.0);
        let manifold = manifold.unwrap_or_else(|| panic!("{}: nothing found at {exact}", pair.name));
        let deepest = f64::from(manifold.deepest());
        println!("{}: {exact:e}, off by {:e} and {:e}", pair.name, apart - exact, deepest - exact);
        assert!((apart - exact).abs() < EXACT, "{}: {apart} in place of {exact}", pair.name);
        // The boxes of the last one are up to 0.27 m apart, where single precision has steps of 3e-8 m: all that is asked is that they touch.
        let preferred = if pair.name.starts_with("edges") { 5e-3 * exact.abs() } else { 0.0 };
        let allowed = if exact > -1e-7 { 1e-7 } else { EXACT + preferred };
        assert!((deepest - exact).abs() < allowed, "{}: {deepest} in place of {exact}", pair.name);
    }
}

/// Promise: two plates of 0.7 mm that are 15 µm apart have no contact that overlaps; pushed into each other by 0.1 mm along its normal, the deepest is exact
/// to 1e-8 m.
#[test]
fn plates_that_are_apart_have_no_deep_contact() {
    let plates = &PAIRS[0];
    let (apart, found) = plates.meet(DVec3::ZERO, 2e-5);
    let found = found.expect("they are within the margin");
    // Of boxes that are apart the gap along an axis is no more than the distance.
    assert!(apart >= plates.gap(DVec3::ZERO) - EXACT && apart < 2e-5, "{apart}");
    assert!(found.points().iter().all(|p| p.distance > 0.0), "{found:?}");
    let shift = -1e-4 * found.normal.as_dvec3();
    let exact = plates.gap(shift);
    let (overlap, pushed) = plates.meet(shift, 2e-5);
    let deepest = f64::from(pushed.expect("they overlap").deepest());
    assert!(exact < 0.0 && (overlap - exact).abs() < EXACT, "{overlap} in place of {exact}");
    assert!((deepest - exact).abs() < EXACT, "{deepest} in place of {exact}");
}

/// Promise: a small box in a larger one, moved out through each face, is as deep as it is, along that face's normal, at every contact.
#[test]
fn a_box_in_a_box_leaves_by_the_nearest_face() {
    let [large, small] = [1.0, 0.2].map(|half| Shape::Box { half: rockfall_math::Vec3::splat(half) });
    for (axis, sign) in (0..6).map(|i| (i / 2, if i % 2 == 0 { 1.0 } else { -1.0 })) {
        for offset in [0.5_f32, 0.79, 0.8, 0.81, 1.2, 1.3] {
            let out = sign * rockfall_math::Vec3::AXES[axis];
            let pose = Isometry { translation: offset * out, ..Isometry::IDENTITY };
            let exact = f64::from(offset) - 1.2;
            let found = manifold(&large, &small, &pose, 0.05);
            assert_eq!(found.is_some(), exact <= 0.05, "{offset}");
            for (m, p) in found.iter().flat_map(|m| m.points().iter().map(move |p| (m, p))) {
                assert!((f64::from(p.distance) - exact).abs() < 1e-7, "{exact}: {m:?}");
                assert!((m.normal - out).length() < 1e-7, "{exact}: {m:?}");
            }
        }
    }
}
