//! Stages of OpenUSD: bodies are where OpenUSD has them, and are what UsdPhysics says.

use crate::damage::damage;
use crate::python::python;
use crate::reach::{directions, reach};
use rockfall_import::{Body, Content, Geometry, Kind, Place, Weight, read};
use rockfall_math::{DVec3, Mat3, Pose, Quat, Vec3, rotation::rotate};
use std::path::{Path, PathBuf};

fn stages() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/stages")
}

fn everything() -> Content {
    read(&stages().join("everything.usda"), &Place::default()).unwrap_or_else(|error| panic!("{error}"))
}

fn body<'c>(content: &'c Content, name: &str) -> &'c Body {
    let found = content.bodies.iter().find(|body| body.name == name);
    found.unwrap_or_else(|| panic!("no {name} among {:?}", names(content)))
}

fn names(content: &Content) -> Vec<&str> {
    content.bodies.iter().map(|body| body.name.as_str()).collect()
}

/// What is in a text of a stage.
fn stage(text: &str) -> Result<Content, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("stage.usda");
    let head = "#usda 1.0\n(\n    metersPerUnit = 1\n    upAxis = \"Z\"\n)\n";
    std::fs::write(&path, format!("{head}{text}")).unwrap();
    read(&path, &Place::default()).map_err(|error| error.reason)
}

fn notes(content: &Content) -> Vec<String> {
    content.notes.iter().map(|note| note.to_string()).collect()
}

/// A prim that collides and moves, with more in its braces.
fn ball(name: &str, more: &str) -> String {
    format!(
        "def Sphere \"{name}\" (\n    prepend apiSchemas = [\"PhysicsRigidBodyAPI\", \"PhysicsCollisionAPI\", \"PhysicsMassAPI\"]\n)\n{{\n{more}\n}}\n"
    )
}

/// Holds a stage against what OpenUSD says of it, and its text against the same as binary files and as a package.
fn agrees_with_openusd(name: &str, count: usize, beside: usize) {
    let folder = tempfile::tempdir().unwrap();
    let path = stages().join(name);
    let Some(said) = python("read_with_usd.py", &[path.as_os_str(), folder.path().as_os_str()]) else {
        return;
    };
    let expected: Vec<(String, Vec<f64>)> =
        said.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(expected.len(), count);
    let text = read(&path, &Place::default()).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(text.bodies.len(), count + beside, "{:?}", names(&text));
    for (name, far) in &expected {
        let body = body(&text, name);
        for (d, far) in directions().into_iter().zip(far) {
            let ours = reach(&text, body, d);
            assert!((ours - far).abs() < 2e-6, "{name} along {d}: {ours}, expected {far}");
        }
    }
    for ending in ["usdc", "usd", "usdz"] {
        let other = read(&folder.path().join(format!("stage.{ending}")), &Place::default());
        let other = other.unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(other.bodies, text.bodies, "{ending}");
        assert_eq!(other.shapes, text.shapes, "{ending}");
        assert_eq!(other.geometries, text.geometries, "{ending}");
        assert_eq!(other.materials, text.materials, "{ending}");
        assert_eq!((other.gravity, &other.notes), (text.gravity, &text.notes), "{ending}");
    }
}

#[test]
fn every_body_reaches_as_far_as_openusd_says_in_text_binary_and_package() {
    // And the ground, which has no end.
    agrees_with_openusd("everything.usda", 16, 1);
}

#[test]
fn references_payloads_variants_and_layers_are_composed() {
    agrees_with_openusd("composed.usda", 5, 0);
    let content = read(&stages().join("composed.usda"), &Place::default()).unwrap();
    assert_eq!(
        names(&content),
        ["/World/FromBelow", "/World/One", "/World/Two", "/World/Three", "/World/Four"]
    );
    assert_eq!(notes(&content), ["a prim that moves in time stands where it is at first (/World/Two)"]);
}

#[test]
fn bodies_are_what_usd_physics_says() {
    let content = everything();
    assert_eq!(content.gravity, Some(DVec3::new(0.0, 0.0, -5.0)));
    let rubber = &content.materials[0];
    assert_eq!((rubber.friction, rubber.restitution), (0.7, 0.4));
    // Half a kilogram is the unit of mass, a centimetre that of length.
    assert!((rubber.density.unwrap() - 0.0022 * 0.5e6).abs() < 1e-3);

    let crate_ = body(&content, "/World/Crate");
    assert_eq!((crate_.kind, crate_.material), (Kind::Dynamic, Some(0)));
    assert_eq!(crate_.mass.mass, Some(4.0));
    // World is turned by 30° about the vertical, which is z here.
    let (sin, cos) = 30.0_f64.to_radians().sin_cos();
    let turned = |x: f64, y: f64, z: f64| DVec3::new(x * cos + z * sin, -(z * cos - x * sin), y);
    assert!((crate_.velocity - turned(1.0, 0.0, -0.5)).length() < 1e-12);
    let spin = turned(0.0, 90.0_f64.to_radians(), 180.0_f64.to_radians());
    assert!((crate_.angular_velocity - spin).length() < 1e-9);
    // The scale of the body stretches the place of its centre.
    let center = crate_.mass.center.unwrap();
    assert!((center.abs() - Vec3::new(0.0, 0.005, 0.0)).length() < 1e-6, "{center}");
    // kg cm² of half kilograms; the principal axes change x and z.
    let moments = Mat3::from_diagonal(Vec3::new(4000.0, 3000.0, 2000.0)) * 0.5e-4;
    let off = (crate_.mass.inertia.unwrap() - moments).to_cols_array();
    assert!(off.iter().all(|x| x.abs() < 1e-6), "{off:?}");

    let tumbler = body(&content, "/World/Tumbler");
    let weights: Vec<_> = content.shapes[tumbler.shape as usize].iter().map(|part| part.weight).collect();
    let Some(Weight::Density(density)) = weights[0] else { panic!("{weights:?}") };
    assert!((density - 2000.0).abs() < 1e-2);
    assert_eq!(weights[1..], [Some(Weight::Mass(1.5)), None, None]);

    assert_eq!(body(&content, "/World/Pebble").kind, Kind::Kinematic);
    assert_eq!(body(&content, "/World/Still/Wedge").kind, Kind::Static);
    let ground = body(&content, "/World/Ground");
    assert_eq!(
        content.geometries[content.shapes[ground.shape as usize][0].geometry as usize],
        Geometry::HalfSpace
    );
    assert!((rotate(ground.pose.rotation, Vec3::Z) - Vec3::Z).length() < 1e-6);
    assert!((ground.pose.position.z - 0.15).abs() < 1e-9);

    assert_eq!(
        notes(&content),
        [
            "static and dynamic friction differ: the dynamic one is taken for both (/World/Looks/Rubber)",
            "1 invisible instances are left out (/World/Rocks)",
        ]
    );
}

#[test]
fn instances_share_shapes_and_have_their_own_motion() {
    let content = everything();
    let rock = |id: u32| body(&content, &format!("/World/Rocks[{id}]"));
    // The first and the third of four stones have other scales.
    assert_ne!(rock(7).shape, rock(9).shape);
    let pair = ["Again", "AgainAway"].map(|name| body(&content, &format!("/World/{name}/One")).shape);
    assert_eq!(pair[0], pair[1]);
    // Ten of the instancer's units, twice as long as those of the stage.
    assert!((rock(9).velocity.length() - 0.2).abs() < 1e-12);
    assert!((rock(9).angular_velocity.length() - 90.0_f64.to_radians()).abs() < 1e-12);
    assert_eq!(rock(7).velocity, DVec3::ZERO);
}

#[test]
fn a_stage_is_laid_into_the_world_as_its_place_says() {
    let path = stages().join("everything.usda");
    let rotation = rockfall_math::rotation::normalize(Quat::from_xyzw(0.1, 0.2, 0.3, 0.9));
    let place = Place { pose: Pose { position: DVec3::new(5.0, 6.0, 7.0), rotation }, scale: 3.0 };
    let (plain, placed) = (everything(), read(&path, &place).unwrap());
    for (one, other) in plain.bodies.iter().zip(&placed.bodies).filter(|(b, _)| b.name != "/World/Ground") {
        for d in directions() {
            let back = rockfall_math::rotation::rotate_back_double(rotation, d);
            let expected = d.dot(place.pose.position) + 3.0 * reach(&plain, one, back);
            assert!((reach(&placed, other, d) - expected).abs() < 1e-5, "{}", one.name);
        }
    }
}

#[test]
fn what_is_not_supported_is_listed() {
    let joint = "def PhysicsRevoluteJoint \"J\"\n{\n    rel physics:body0 = </A>\n}\n";
    let asleep = "    bool physics:startsAsleep = 1\n    float physxRigidBody:maxLinearVelocity = 3\n    bool physxRigidBody:enableCCD = 0";
    let shape = "def BasisCurves \"C\" (\n    prepend apiSchemas = [\"PhysicsCollisionAPI\", \"PhysxCookedDataAPI:x\"]\n)\n{\n}\n";
    let bent = "def Cylinder \"D\" (\n    prepend apiSchemas = [\"PhysicsCollisionAPI\"]\n)\n{\n    float3 xformOp:scale = (1, 2, 1)\n    uniform token[] xformOpOrder = [\"xformOp:scale\"]\n}\n";
    let missing = "def Xform \"M\" (\n    references = @nowhere.usda@\n)\n{\n}\n";
    let text = format!("{}{joint}{}{shape}{bent}{missing}", ball("A", ""), ball("B", asleep));
    let content = stage(&text).unwrap();
    assert_eq!(names(&content), ["/A", "/B", "/D"]);
    let notes = notes(&content);
    assert_eq!(
        notes[..6],
        [
            "PhysicsRevoluteJoint is not supported (/J)",
            "`physxRigidBody:maxLinearVelocity` is not supported (/B)",
            "a body that starts asleep starts awake (/B)",
            "PhysxCookedDataAPI:x is not supported (/C)",
            "BasisCurves as a collider is left out (/C)",
            "a form that is stretched out of round: taken as a hull (/D)",
        ]
    );
    assert!(
        notes[6].starts_with("a part of the stage is missing") && notes[6].contains("nowhere.usda"),
        "{notes:?}"
    );
}

#[test]
fn filtered_pairs_and_groups_become_groups_and_masks() {
    let with = |target: &str| format!("    rel physics:filteredPairs = <{target}>");
    let paired = ball("A", &with("/B")).replace("PhysicsMassAPI", "PhysicsFilteredPairsAPI");
    let group = "def PhysicsCollisionGroup \"G\" (\n    prepend apiSchemas = [\"CollectionAPI:colliders\"]\n)\n{\n    rel collection:colliders:includes = </C>\n    rel physics:filteredGroups = </G>\n}\n";
    let content = stage(&format!("{paired}{}{}{group}", ball("B", ""), ball("C", ""))).unwrap();
    let meet = |a: usize, b: usize| {
        let (a, b) = (&content.bodies[a], &content.bodies[b]);
        a.group & b.mask != 0 && b.group & a.mask != 0
    };
    assert_eq!([meet(0, 1), meet(0, 2), meet(1, 2), meet(2, 2)], [false, true, true, false]);
}

#[test]
fn wrong_numbers_are_refused_with_the_prim() {
    for (more, expected) in [
        ("    float physics:mass = -1", "/A: `physics:mass` is"),
        ("    float physics:density = inf", "/A: `physics:density` is"),
        ("    float3 physics:diagonalInertia = (1, -1, 1)", "/A: `physics:diagonalInertia` is"),
        ("    vector3f physics:velocity = (nan, 0, 0)", "/A: its velocity is not finite"),
    ] {
        let error = stage(&ball("A", more)).unwrap_err();
        assert!(error.starts_with(expected), "{error}");
    }
    let none = stage("def Sphere \"S\"\n{\n}\n").unwrap_err();
    assert!(none.starts_with("there is nothing to collide with"), "{none}");
    let flat = "    float3 xformOp:scale = (1, 0, 1)\n    uniform token[] xformOpOrder = [\"xformOp:scale\"]";
    let content = stage(&format!("{}{}", ball("A", ""), ball("B", flat))).unwrap();
    assert_eq!((content.bodies.len(), content.notes.len()), (1, 1));
}

#[test]
fn text_that_is_no_stage_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        read(&path, &Place::default()).unwrap_err().to_string()
    };
    for name in ["a.usda", "a.usdc", "a.usdz", "a.usd"] {
        for bytes in
            [&b""[..], b"#usda", b"#usda 1.0\ndef Xform \"", b"PXR-USDC", b"PK\x03\x04", &[0xff; 300]]
        {
            let error = refused(name, bytes);
            assert!(error.starts_with(&folder.path().join(name).display().to_string()), "{error}");
        }
    }
    let deep = format!("#usda 1.0\n{}", "def \"a\" {\n".repeat(100_000));
    assert!(
        refused("deep.usda", deep.as_bytes()).contains("brackets"),
        "{}",
        refused("deep.usda", deep.as_bytes())
    );
    let missing = read(&folder.path().join("missing.usda"), &Place::default()).unwrap_err();
    assert!(missing.to_string().ends_with("missing.usda: no such file, expected a scene"));
}

/// Who goes up from a path that ends with a brace which nothing opened never arrives, in openusd 0.6.
#[test]
fn names_that_have_no_way_up_are_refused() {
    let body = |more: &str| ball("Stone", more);
    for text in [
        // A path without its end reaches to the next one's, over all that is between.
        body(
            "rel material:binding = </World/Materials/Sto\n}\ndef Cube \"A\" {\nrel material:binding = </World/Steel>",
        ),
        ball("Stone}", ""),
        ball("Stone", "def \"Chip}\" {}"),
        "def Xform \"A\" (variants = { string size = \"large}\" } add variantSets = \"size\") {}".to_owned(),
        "def Xform \"A\" (variantSets = [\"size\", \"si}e\"]) {}".to_owned(),
        "def Xform \"A\" { variantSet \"size\" = { \"small\" { } \"la}rge\" { } } }".to_owned(),
        "def Xform \"A\" { variantSet \"si}ze\" = { \"small\" { } } }".to_owned(),
        "def Xform \"A\" (inherits = </Class{a=b}}>) {}".to_owned(),
    ] {
        let error = stage(&text).unwrap_err();
        assert!(error.contains("braces"), "{text}: {error}");
    }
    // What is said in strings is nobody's name.
    let said = "string note = \"} is {}\" (\n doc = \"'}' <}>\"\n)\n string[] more = [\"}\"] # <}>\n asset file = @}@";
    let content = stage(&body(said)).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(names(&content), ["/Stone"]);
}

#[test]
fn binary_names_that_have_no_way_up_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = stages().join("everything.usda");
    let Some(_) = python("read_with_usd.py", &[path.as_os_str(), folder.path().as_os_str()]) else { return };
    let path = folder.path().join("stage.usdc");
    let mut bytes = std::fs::read(&path).unwrap();
    let name = b"Tumbler\0";
    let at = bytes.windows(name.len()).position(|bytes| bytes == name).expect("it is in the file as it is");
    bytes[at + name.len() - 2] = b'}';
    std::fs::write(&path, bytes).unwrap();
    let error = read(&path, &Place::default()).unwrap_err();
    assert!(error.reason.contains("braces"), "{error}");
}

#[test]
fn no_damage_to_a_stage_does_more_than_refuse_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = stages().join("everything.usda");
    damage("stage.usda", &std::fs::read(&path).unwrap(), 211);
    let Some(_) = python("read_with_usd.py", &[path.as_os_str(), folder.path().as_os_str()]) else { return };
    for (name, every) in [("stage.usdc", 17), ("stage.usdz", 83)] {
        damage(name, &std::fs::read(folder.path().join(name)).unwrap(), every);
    }
}

#[test]
#[ignore = "takes minutes: every byte of a file"]
fn no_byte_of_a_binary_stage_does_more_than_refuse_it() {
    let folder = tempfile::tempdir().unwrap();
    let path = stages().join("everything.usda");
    let Some(_) = python("read_with_usd.py", &[path.as_os_str(), folder.path().as_os_str()]) else { return };
    damage("stage.usdc", &std::fs::read(folder.path().join("stage.usdc")).unwrap(), 1);
}
