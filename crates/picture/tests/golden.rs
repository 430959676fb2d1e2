//! Small pictures, to the bit: every shape, overlay, colour mode and quality is in one of them.
//!
//! What they show is made by hand and not simulated, so that no change of the physics changes a picture. Where a picture has changed, it is written to the
//! folder that the message names: look at it before its hash is put here.

mod common;

use common::{shapes, turned};
use rockfall::{Kind, Shape};
use rockfall_cache::Contacts;
use rockfall_math::{DVec3, Pose, Vec3};
use rockfall_picture::{Camera, ColorBy, Lens, Look, Overlay, Quality, Seen, Sight, take};
use std::collections::BTreeSet;
use std::path::Path;

/// Name, colours, overlays, hash.
type Case = (&'static str, ColorBy, &'static [Overlay], u64);

const CASES: [Case; 13] = [
    ("round", ColorBy::Body, &[], 0x6408_5c0b_03e3_7633),
    ("flat", ColorBy::Material, &[], 0xa92d_962d_e2ed_063d),
    ("concave", ColorBy::Size, &[Overlay::Bounds], 0x7176_68a7_5152_ff8c),
    ("speed", ColorBy::Speed, &[Overlay::Paths], 0xf92a_1057_af32_4cd4),
    ("force", ColorBy::Force, &[Overlay::Impulses], 0x73b8_e4e0_ed03_b956),
    ("sleep", ColorBy::Sleep, &[Overlay::Centres], 0x9daf_e7b2_f666_e8f5),
    ("island", ColorBy::Island, &[Overlay::Contacts], 0x20ee_34bf_026a_54c3),
    ("penetration", ColorBy::Penetration, &[Overlay::Normals, Overlay::Contacts], 0x0f79_f44b_bce7_7b3b),
    ("lens", ColorBy::Body, &[], 0xddf6_be21_9275_91de),
    ("far", ColorBy::Body, &[], 0x0bc3_5dc8_b54b_a32a),
    ("draft", ColorBy::Body, &[], 0x43e6_e011_a9c1_27bb),
    ("fine", ColorBy::Body, &[], 0x7f63_a860_f855_3f57),
    ("looks", ColorBy::Body, &[], 0xcf39_0b48_4b54_08d2),
];

/// Bodies of these shapes in rows of `across`, on the ground.
fn row(shapes: Vec<Shape>, across: u32, spacing: f64, origin: DVec3) -> Sight {
    let ground = shapes.len() as u32;
    let body = |k: u32, kind, position, rotation| Seen {
        id: u64::from(k) + 1,
        shape: k,
        shown: k,
        color: None,
        material: k % 3,
        kind,
        pose: Pose { position, rotation },
        center: position,
        velocity: Vec3::ZERO,
        spin: Vec3::ZERO,
    };
    let place = |k: u32| {
        let (i, j) = (f64::from(k % across), f64::from(k / across));
        body(k, Kind::Dynamic, origin + DVec3::new(spacing * i, spacing * j, 1.1), turned(k))
    };
    let mut bodies: Vec<Seen> = (0..ground).map(place).collect();
    bodies.push(body(ground, Kind::Static, origin, Pose::default().rotation));
    let mut shapes = shapes;
    shapes.push(Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 });
    let materials = ["granite", "sandstone", "slate"].map(str::to_owned).to_vec();
    Sight { frame: 12, time: 0.2, step: 1.0 / 60.0, shapes, materials, bodies, origin, ..Sight::default() }
}

/// Two layers of balls of several sizes, of which everything is known.
fn pile(origin: DVec3) -> Sight {
    let shapes = (0..32).map(|k| Shape::Sphere { radius: 0.35 + 0.03 * (k % 6) as f32 }).collect();
    let mut sight = row(shapes, 4, 1.0, origin);
    let mut contacts = Contacts::default();
    for k in 0..32 {
        let layer = f64::from(k as u32 / 16);
        let body = &mut sight.bodies[k];
        body.pose.position = origin + DVec3::new((k % 4) as f64, (k / 4 % 4) as f64, 0.5 + layer);
        body.center = body.pose.position;
        body.velocity = Vec3::new(0.9 * k as f32, 0.2, 0.0);
        if k % 4 > 0 {
            contacts.a.push(k as u64);
            contacts.b.push(k as u64 + 1);
            let middle = DVec3::new((k % 4) as f64 - 0.5, (k / 4 % 4) as f64, 0.5 + layer);
            contacts.positions.push(middle.as_vec3().to_array());
            contacts.normals.push([1.0, 0.0, 0.0]);
            contacts.distances.push(-0.002 * k as f32);
            contacts.forces.push(40.0 * k as f32);
        }
    }
    sight.forces = Ok((0..33).map(|k| 25.0 * k as f32).collect());
    sight.asleep = Ok((0..33).map(|k| k % 3 == 0).collect());
    sight.contacts = Ok(contacts);
    sight
}

fn sight(name: &str) -> (Sight, Camera) {
    let all = shapes();
    let pick = |kinds: &[usize]| kinds.iter().map(|&k| all[k].clone()).collect::<Vec<Shape>>();
    let far = DVec3::new(3e6, -1e6, 2e5);
    let (sight, target, back) = match name {
        "round" | "lens" | "fine" => {
            (row(pick(&[0, 2, 3, 4, 5]), 5, 2.2, DVec3::ZERO), DVec3::new(4.4, 0.0, 0.8), 11.0)
        }
        "flat" => (row(pick(&[1, 6, 7, 8, 11]), 5, 2.2, DVec3::ZERO), DVec3::new(4.4, 0.0, 0.8), 11.0),
        "concave" => {
            let mut sight = row(pick(&[9, 10, 12]), 3, 2.4, DVec3::ZERO);
            // As a height field stands.
            sight.bodies[2].pose.rotation = Pose::default().rotation;
            (sight, DVec3::new(2.4, 0.0, 0.8), 8.0)
        }
        // A mesh in place of a ball, colours of a body and of a material, and hulls put together as a decomposition is.
        "looks" => {
            let mut sight = row(pick(&[0, 14, 1]), 3, 2.4, DVec3::ZERO);
            sight.shapes.push(all[9].clone());
            sight.bodies[0].shown = 4;
            for body in &mut sight.bodies[..2] {
                body.pose =
                    Pose { position: body.pose.position - DVec3::new(0.0, 0.0, 0.3), ..Pose::default() };
            }
            sight.bodies[1].color = Some([0.02, 0.3, 0.25]);
            sight.colors = vec![None, None, Some([0.6, 0.1, 0.05])];
            (sight, DVec3::new(2.4, 0.0, 0.8), 8.0)
        }
        "far" => (pile(far), far + DVec3::new(1.5, 1.5, 0.8), 7.0),
        _ => (pile(DVec3::ZERO), DVec3::new(1.5, 1.5, 0.8), 7.0),
    };
    let eye = target + back * DVec3::new(0.45, -0.8, 0.5);
    let lens = (name == "lens").then_some(Lens { aperture: 0.6, focus: None });
    (sight, Camera { eye, target, up: DVec3::Z, fov: 32.0, lens })
}

#[test]
fn pictures_are_what_they_were_when_somebody_looked_at_them() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let mut changed = Vec::new();
    for (name, colors, overlays, hash) in CASES {
        let (sight, camera) = sight(name);
        let quality = match name {
            "draft" => Quality::Draft,
            "fine" => Quality::Fine,
            _ => Quality::Standard,
        };
        let look = Look {
            width: 320,
            height: 180,
            quality,
            colors,
            overlays: overlays.to_vec(),
            caption: name == "far",
            ..Look::default()
        };
        let (image, picture) = take(&sight, &camera, &look).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(image.light.iter().flatten().all(|x| x.is_finite() && *x >= 0.0), "{name}");
        if picture.hash() != hash {
            let path = folder.join(format!("golden-{name}.png"));
            picture.write_png(&path).unwrap_or_else(|error| panic!("{error}"));
            changed.push(format!("{name}: {:#018x}, {}", picture.hash(), path.display()));
        }
    }
    assert!(changed.is_empty(), "other pictures than before:\n{}", changed.join("\n"));
}

#[test]
fn every_word_and_every_shape_is_in_one_of_them() {
    for (word, by) in ColorBy::WORDS {
        assert!(CASES.iter().any(|case| case.1 == by), "no picture is coloured by {word}");
    }
    for (word, overlay) in Overlay::WORDS {
        let drawn = |case: &&Case| !overlay.strokes(&sight(case.0).0).expect("all is known").is_empty();
        let mut those = CASES.iter().filter(|case| case.2.contains(&overlay));
        assert!(those.any(|case| drawn(&case)), "no picture has the overlay {word}");
    }
    let mut kinds = BTreeSet::new();
    for (name, ..) in CASES {
        let (sight, _) = sight(name);
        kinds.extend(sight.bodies.iter().map(|body| kind(&sight.shapes[body.shown as usize])));
    }
    assert!(kinds.into_iter().eq(0..KINDS), "a shape is in no picture");
}

/// Kinds of shapes.
const KINDS: u32 = 14;

/// The number of a shape's kind. The compiler asks for one that is new.
fn kind(shape: &Shape) -> u32 {
    match shape {
        Shape::Sphere { .. } => 0,
        Shape::Box { .. } => 1,
        Shape::Capsule { .. } => 2,
        Shape::Cylinder { .. } => 3,
        Shape::Cone { .. } => 4,
        Shape::Ellipsoid { .. } => 5,
        Shape::RoundedBox { .. } => 6,
        Shape::Hull(_) => 7,
        Shape::RoundedHull { .. } => 8,
        Shape::HalfSpace { .. } => 9,
        Shape::Mesh(_) => 10,
        Shape::Field(_) => 11,
        Shape::HeightField(_) => 12,
        Shape::Compound(_) => 13,
    }
}

#[test]
fn what_is_not_known_is_an_error_that_says_what_to_do() {
    let (mut sight, camera) = sight("pile");
    sight.contacts = Err("the run does not know contacts: run its scene again".into());
    sight.forces = Err("no forces".into());
    let small = Look { width: 32, height: 18, quality: Quality::Draft, ..Look::default() };
    for look in [
        Look { colors: ColorBy::Penetration, ..small.clone() },
        Look { colors: ColorBy::Island, ..small.clone() },
        Look { overlays: vec![Overlay::Impulses], ..small.clone() },
    ] {
        let error = take(&sight, &camera, &look).expect_err("no contacts").to_string();
        assert!(error.contains("run its scene again"), "{error}");
    }
    assert!(take(&sight, &camera, &Look { colors: ColorBy::Force, ..small.clone() }).is_err());
    assert!(take(&sight, &camera, &small).is_ok());
}
