//! glTF: nodes are where the standard has them, and bodies are what `KHR_physics_rigid_bodies` says.

use crate::damage::damage;
use crate::reach::{directions, reach};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use rockfall_import::{Body, Content, Geometry, Kind, Mix, Place, read};
use rockfall_math::{DVec3, Mat3, Vec3};
use serde_json::{Value, json};

/// Corners of a wedge that no symmetry maps to itself.
const WEDGE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]];
const FACES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
/// Places and turns of two instances.
const INSTANCES: ([[f32; 3]; 2], [[f32; 4]; 2]) =
    ([[1.0, 0.0, 0.0], [0.0, 5.0, 0.0]], [[0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0]]);

/// A file with the wedge as mesh 0, a square as mesh 1, and accessors 3 and 4 for instances.
fn file(mut rest: Value) -> Vec<u8> {
    let square: [[f32; 3]; 4] = [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0]];
    let mut bytes = Vec::new();
    let mut views = Vec::new();
    let mut add = |part: Vec<u8>| {
        views.push(json!({ "buffer": 0, "byteOffset": bytes.len(), "byteLength": part.len() }));
        bytes.extend(part);
    };
    let floats = |all: &[f32]| all.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    add(floats(WEDGE.as_flattened()));
    add(FACES.as_flattened().iter().flat_map(|i| i.to_le_bytes()).collect());
    add(floats(square.as_flattened()));
    add(floats(INSTANCES.0.as_flattened()));
    add(floats(INSTANCES.1.as_flattened()));
    let accessor = |view: u32, kind: &str, count: u32, component: u32| {
        let mut accessor =
            json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
        if view == 0 || view == 2 {
            accessor["min"] = json!([-1.0, 0.0, -1.0]);
            accessor["max"] = json!([1.0, 2.0, 3.0]);
        }
        accessor
    };
    let primitive = |positions: u32| json!({ "attributes": { "POSITION": positions }, "indices": 1 });
    let base = json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "buffers": [{ "byteLength": bytes.len(),
            "uri": format!("data:application/octet-stream;base64,{}", STANDARD.encode(&bytes)) }],
        "bufferViews": views,
        "accessors": [
            accessor(0, "VEC3", 4, 5126), accessor(1, "SCALAR", 12, 5125), accessor(2, "VEC3", 4, 5126),
            accessor(3, "VEC3", 2, 5126), accessor(4, "VEC4", 2, 5126),
        ],
        "meshes": [{ "primitives": [primitive(0)] }, { "primitives": [primitive(2)] }],
    });
    for (key, value) in base.as_object().unwrap() {
        rest[key] = value.clone();
    }
    serde_json::to_vec(&rest).unwrap()
}

fn content(rest: Value) -> Result<Content, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.gltf");
    std::fs::write(&path, file(rest)).unwrap();
    read(&path, &Place::default()).map_err(|error| error.reason)
}

/// How far points reach that `map` takes to the scene, whose y is up.
fn expected(points: &[[f32; 3]], map: impl Fn(DVec3) -> DVec3, d: DVec3) -> f64 {
    let upright = |p: DVec3| DVec3::new(p.x, -p.z, p.y);
    let far = |p: &[f32; 3]| d.dot(upright(map(Vec3::from_array(*p).as_dvec3())));
    points.iter().map(far).fold(f64::NEG_INFINITY, f64::max)
}

fn assert_reaches(content: &Content, body: &Body, points: &[[f32; 3]], map: impl Fn(DVec3) -> DVec3) {
    for d in directions() {
        let (ours, far) = (reach(content, body, d), expected(points, &map, d));
        assert!((ours - far).abs() < 2e-6, "{} along {d}: {ours}, expected {far}", body.name);
    }
}

/// A quarter turn about y, which takes z to x.
fn quarter(p: DVec3) -> DVec3 {
    DVec3::new(p.z, p.y, -p.x)
}

const QUARTER: [f64; 4] = [0.0, std::f64::consts::FRAC_1_SQRT_2, 0.0, std::f64::consts::FRAC_1_SQRT_2];

#[test]
fn every_mesh_of_a_file_without_physics_is_a_body() {
    let content = content(json!({
        "scenes": [{ "nodes": [0, 3] }],
        "nodes": [
            { "translation": [10.0, 0.0, 0.0], "children": [1, 2], "scale": [2.0, 2.0, 2.0] },
            { "name": "rock", "mesh": 0, "rotation": QUARTER, "translation": [0.0, 1.0, 0.0] },
            { "name": "mirror", "mesh": 0, "scale": [-1.0, 1.0, 1.0] },
            { "name": "floor", "mesh": 1 },
        ],
    }))
    .unwrap();
    let names: Vec<&str> = content.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["rock", "mirror", "floor"]);
    let kinds: Vec<Kind> = content.bodies.iter().map(|body| body.kind).collect();
    assert_eq!(kinds, [Kind::Dynamic, Kind::Dynamic, Kind::Static]);
    let away = DVec3::new(10.0, 0.0, 0.0);
    assert_reaches(&content, &content.bodies[0], &WEDGE, |p| away + 2.0 * (quarter(p) + DVec3::Y));
    assert_reaches(&content, &content.bodies[1], &WEDGE, |p| away + 2.0 * DVec3::new(-p.x, p.y, p.z));
    let notes: Vec<String> = content.notes.iter().map(ToString::to_string).collect();
    assert_eq!(
        notes,
        [
            "there are no physics in it: every mesh is a body that forces move, as its convex hull",
            "a flat mesh is a body that stands still (floor)",
        ]
    );
    assert_eq!(content.density, None);
}

#[test]
fn instances_of_a_node_are_bodies_each() {
    let instancing =
        json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 3, "ROTATION": 4 } } });
    let content = content(json!({
        "extensionsRequired": ["EXT_mesh_gpu_instancing"],
        "extensionsUsed": ["EXT_mesh_gpu_instancing"],
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "rocks", "mesh": 0, "translation": [0.0, 0.0, 7.0], "extensions": instancing }],
    }))
    .unwrap();
    let names: Vec<&str> = content.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!((names, content.shapes.len()), (vec!["rocks[0]", "rocks[1]"], 1));
    let away = DVec3::new(0.0, 0.0, 7.0);
    assert_reaches(&content, &content.bodies[0], &WEDGE, |p| away + DVec3::X + p);
    // Half a turn about y.
    assert_reaches(&content, &content.bodies[1], &WEDGE, |p| away + DVec3::new(-p.x, 5.0 + p.y, -p.z));
}

fn physics(node: Value) -> Value {
    json!({ "KHR_physics_rigid_bodies": node })
}

/// A file with physics: a floor, a body of two parts, a kinematic mesh, and what is not supported.
fn playground() -> Value {
    json!({
        "extensionsUsed": ["KHR_physics_rigid_bodies", "KHR_implicit_shapes"],
        "extensions": {
            "KHR_implicit_shapes": { "shapes": [
                { "type": "plane" },
                { "type": "capsule", "capsule": { "height": 2.0, "radiusBottom": 0.5, "radiusTop": 0.5 } },
                { "type": "box", "box": { "size": [1.0, 2.0, 4.0] } },
                { "type": "cylinder", "cylinder": { "height": 2.0, "radiusBottom": 1.0, "radiusTop": 0.25 } },
                { "type": "sphere" },
            ] },
            "KHR_physics_rigid_bodies": {
                "physicsMaterials": [{ "dynamicFriction": 0.25, "restitution": 0.5, "frictionCombine": "multiply" }],
                "collisionFilters": [
                    { "collisionSystems": ["rock"], "notCollideWithSystems": ["dust"] },
                    { "collisionSystems": ["dust"] },
                ],
            },
        },
        "scenes": [{ "nodes": [0, 1, 4, 5, 6, 7] }],
        "nodes": [
            { "name": "floor", "translation": [0.0, -1.0, 0.0],
              "extensions": physics(json!({ "collider": { "geometry": { "shape": 0 } } })) },
            { "name": "body", "translation": [0.0, 5.0, 0.0], "rotation": QUARTER, "children": [2, 3],
              "extensions": physics(json!({ "motion": {
                  "mass": 4.0, "centerOfMass": [0.0, 1.0, 0.0], "inertiaDiagonal": [1.0, 2.0, 2.5],
                  "linearVelocity": [0.0, 0.0, 3.0], "angularVelocity": [0.0, 0.0, 2.0], "gravityFactor": 0.5 } })) },
            { "name": "log", "scale": [2.0, 2.0, 2.0], "extensions": physics(json!({
                "collider": { "geometry": { "shape": 1 }, "physicsMaterial": 0, "collisionFilter": 0 },
                "trigger": { "geometry": { "shape": 1 } } })) },
            { "name": "box", "translation": [3.0, 0.0, 0.0], "extensions": physics(json!({
                "collider": { "geometry": { "shape": 2 }, "physicsMaterial": 0, "collisionFilter": 0 } })) },
            { "name": "wedge", "extensions": physics(json!({
                "motion": { "isKinematic": true }, "collider": { "geometry": { "mesh": 0 } } })) },
            { "name": "bucket", "translation": [0.0, 0.0, 9.0], "extensions": physics(json!({
                "motion": { "inertiaDiagonal": [0.0, 1.0, 0.0] }, "joint": { "joint": 0 },
                "collider": { "geometry": { "shape": 3 }, "collisionFilter": 1 } })) },
            { "name": "gate", "extensions": physics(json!({ "trigger": { "geometry": { "shape": 4 } } })) },
            { "name": "hull", "extensions": physics(json!({
                "motion": {}, "collider": { "geometry": { "mesh": 0, "convexHull": true } } })) },
        ],
    })
}

#[test]
fn bodies_are_what_the_extension_says() {
    let content = content(playground()).unwrap();
    let body = |name: &str| content.bodies.iter().find(|body| body.name == name).unwrap();
    let names: Vec<&str> = content.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["floor", "body", "wedge", "bucket", "gate", "hull"]);
    assert_eq!(content.density, Some(1000.0));

    let floor = body("floor");
    assert_eq!((floor.kind, floor.pose.position), (Kind::Static, DVec3::new(0.0, 0.0, -1.0)));
    let up = rockfall_math::rotation::rotate(floor.pose.rotation, Vec3::Z);
    assert!((up - Vec3::Z).length() < 1e-6);

    let both = body("body");
    assert_eq!((both.kind, both.gravity_scale, both.mass.mass), (Kind::Dynamic, 0.5, Some(4.0)));
    // Velocities are the node's own, which is turned; z is then x, and y is up.
    assert!((both.velocity - DVec3::new(3.0, 0.0, 0.0)).length() < 1e-6);
    assert!((both.angular_velocity - DVec3::new(2.0, 0.0, 0.0)).length() < 1e-6);
    // In the frame of the node.
    assert!((both.mass.center.unwrap() - Vec3::Y).length() < 1e-6);
    let off = both.mass.inertia.unwrap() - Mat3::from_diagonal(Vec3::new(1.0, 2.0, 2.5));
    assert!(off.to_cols_array().iter().all(|x| x.abs() < 1e-6));
    let material = &content.materials[both.material.unwrap() as usize];
    assert_eq!((material.friction, material.restitution, material.friction_mix), (0.25, 0.5, Mix::Product));
    // A capsule of twice its size along y, and a box beside it.
    for d in directions() {
        // As the node sees it, which is turned and has y up.
        let e = DVec3::new(d.y, d.z, d.x);
        let capsule = 2.0 * e.y.abs() + 1.0;
        let cuboid = 3.0 * e.x + 0.5 * e.x.abs() + e.y.abs() + 2.0 * e.z.abs();
        let far = 5.0 * d.z + capsule.max(cuboid);
        let ours = reach(&content, both, d);
        assert!((ours - far).abs() < 2e-6, "{d}: {ours}, expected {far}");
    }

    assert_eq!(body("wedge").kind, Kind::Kinematic);
    assert_reaches(&content, body("wedge"), &WEDGE, |p| p);
    let shape =
        |name: &str| &content.geometries[content.shapes[body(name).shape as usize][0].geometry as usize];
    assert!(matches!(shape("wedge"), Geometry::Mesh(_)) && matches!(shape("hull"), Geometry::Hull(_)));
    // The end at the bottom is the wide one.
    assert_eq!(*shape("bucket"), Geometry::Cone { half_length: 1.0, lower: 1.0, upper: 0.25 });
    let up = rockfall_math::rotation::rotate(body("bucket").pose.rotation, Vec3::Z);
    assert!((up - Vec3::Z).length() < 1e-6);

    let gate = body("gate");
    assert!(gate.sensor && gate.kind == Kind::Static && !body("floor").sensor);

    let meet = |a: &str, b: &str| {
        let (a, b) = (body(a), body(b));
        a.group & b.mask != 0 && b.group & a.mask != 0
    };
    assert_eq!([meet("body", "bucket"), meet("body", "floor"), meet("bucket", "floor")], [false, true, true]);
    let notes: Vec<String> = content.notes.iter().map(ToString::to_string).collect();
    assert_eq!(
        notes,
        [
            "a trigger that moves with a body is not supported (log)",
            "a joint is not supported (bucket)",
            "a moment of inertia of 0, which stands for one without end, is not supported (bucket)",
        ]
    );
}

#[test]
fn what_makes_no_sense_is_refused_with_the_node() {
    let wrong = |collider: Value, motion: Value| {
        let node = json!({ "extensions": physics(json!({ "motion": motion, "collider": collider })) });
        content(json!({ "scenes": [{ "nodes": [0] }], "nodes": [node] })).unwrap_err()
    };
    let mesh = json!({ "geometry": { "mesh": 0, "convexHull": true } });
    for (collider, motion, expected) in [
        (json!({ "geometry": { "shape": 3 } }), json!({}), "node 0: there is no implicit shape 3"),
        (json!({ "geometry": {} }), json!({}), "node 0: its collider has neither a shape nor a mesh"),
        (json!({ "geometry": { "mesh": -1 } }), json!({}), "node 0: `mesh` is -1, expected an index"),
        (mesh.clone(), json!({ "mass": -1.0 }), "node 0: `mass` is -1, expected a number of at least 0"),
        (
            mesh.clone(),
            json!({ "linearVelocity": [1.0] }),
            "node 0: `linearVelocity` is [1.0], expected 3 numbers",
        ),
    ] {
        assert_eq!(wrong(collider, motion), expected);
    }
    let cycle = json!({ "scenes": [{ "nodes": [0] }], "nodes": [{ "children": [1] }, { "children": [0] }] });
    assert!(content(cycle).unwrap_err().contains("its own ancestor"));
    let unknown = json!({ "extensionsRequired": ["KHR_draco_mesh_compression"], "scenes": [{ "nodes": [0] }], "nodes": [{ "mesh": 0 }] });
    assert!(content(unknown).unwrap_err().contains("KHR_draco_mesh_compression"));
}

#[test]
fn no_damage_to_a_file_does_more_than_refuse_it() {
    damage("scene.gltf", &file(playground()), 31);
}
