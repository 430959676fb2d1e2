//! OpenUSD itself reads what is written here.

use half::f16;
use rockfall_usd::{
    Array, Attribute, Dictionary, Layer, ListOp, Prim, Reference, Relationship, Specifier, Value, Writer,
};
use std::ffi::OsStr;
use std::fs;
use std::path::Path;
use std::process::Command;

/// The variable that names a Python with the packages `usd-core` and `numpy`; the `test` script sets it.
const PYTHON: &str = "ROCKFALL_PYTHON";

/// What the script says with these arguments; nothing where there is no Python.
fn script<S: AsRef<OsStr>>(arguments: &[S]) -> Option<String> {
    let Some(python) = std::env::var_os(PYTHON) else {
        println!("SKIPPED: {PYTHON} is not set; `./test` makes a Python with OpenUSD and sets it");
        return None;
    };
    let output = Command::new(&python)
        .arg(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/read_with_usd.py"))
        .args(arguments)
        .output()
        .unwrap_or_else(|error| panic!("cannot start {}: {error}", python.display()));
    let said = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    let wrong = String::from_utf8_lossy(&output.stderr);
    // OpenUSD tells what it can't read on standard error and goes on.
    assert!(output.status.success() && wrong.is_empty(), "{said}{wrong}");
    Some(said)
}

#[test]
fn every_type_and_field_is_what_the_text_says() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("everything.usdc");
    let mut writer = Writer::create(&path).unwrap();
    let two = Array::Float3(vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
    writer.sample("/World.velocities", -1.0, &two).unwrap();
    writer.sample("/World.velocities", 0.1, &Array::Float3(vec![])).unwrap();
    writer.sample("/World.velocities", 12.5, &two).unwrap();
    writer.sample("/World.counts", 0.1, &Array::Int(vec![2])).unwrap();
    let bytes = writer.finish(&everything()).unwrap();
    assert_eq!(fs::metadata(&path).unwrap().len(), bytes);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing else is left");

    let text = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/everything.usda");
    if let Some(said) = script(&["same".as_ref(), path.as_os_str(), text.as_os_str()]) {
        assert!(said.starts_with("59 specs with "), "{said}");
    }
}

fn token(text: &str) -> Value {
    Value::Token(text.to_owned())
}

fn texts(texts: &[&str]) -> Vec<String> {
    texts.iter().map(|&text| text.to_owned()).collect()
}

fn halves<const N: usize>(values: [f32; N]) -> [f16; N] {
    values.map(f16::from_f32)
}

/// The same as `everything.usda`.
fn everything() -> Layer {
    let inner = Dictionary::from([
        ("flag".to_owned(), Value::Bool(true)),
        ("numbers".to_owned(), Value::Array(Array::Double(vec![0.1, 2.0, 1e300]))),
    ]);
    let data = Dictionary::from([
        ("inner".to_owned(), Value::Dictionary(inner)),
        ("text".to_owned(), Value::String("a \"quoted\" line".to_owned())),
    ]);
    let metadata = vec![
        ("defaultPrim", token("World")),
        ("documentation", Value::String("what the test writes, in words".to_owned())),
        ("endTimeCode", Value::Double(12.5)),
        ("framesPerSecond", Value::Double(24.0)),
        ("metersPerUnit", Value::Double(1.0)),
        ("startTimeCode", Value::Double(-1.0)),
        ("timeCodesPerSecond", Value::Double(24.0)),
        ("upAxis", token("Z")),
        ("customLayerData", Value::Dictionary(data)),
    ];
    let class = Prim { name: "_Class".to_owned(), specifier: Specifier::Class, ..Prim::default() };
    Layer { metadata, prims: vec![world(), class] }
}

fn world() -> Prim {
    let schemas = ListOp::Prepend(texts(&["PhysicsRigidBodyAPI", "MaterialBindingAPI"]));
    let prim = Prim::def("Xform", "World")
        .meta("kind", token("assembly"))
        .meta("apiSchemas", Value::Tokens(schemas));
    arrays(values(prim))
        .with(Attribute::sampled("normal3f[]", "normals").meta("interpolation", token("faceVarying")))
        .with(Attribute::sampled("vector3f[]", "velocities"))
        .with(Attribute::new("int[]", "counts", Value::Array(Array::Int(vec![1]))))
        .child(looks())
        .child(ball())
        .child(clips())
}

fn values(prim: Prim) -> Prim {
    let place = [[1.0, 0.0, 0.0, 0.0], [0.0, 2.0, 0.0, 0.0], [0.0, 0.0, 3.0, 0.0], [4.0, 5.0, 6.5, 1.0]];
    prim.with(Attribute::new("bool", "flag", Value::Bool(true)))
        .with(Attribute::new("int", "small", Value::Int(-7)))
        .with(Attribute::new("int64", "big", Value::Int64(9_007_199_254_740_993)))
        .with(Attribute::new("half", "tiny", Value::Half(f16::from_f32(0.5))))
        .with(Attribute::new("float", "third", Value::Float(1.0 / 3.0)))
        .with(Attribute::new("double", "tenth", Value::Double(0.1)))
        .with(Attribute::new("double", "minus", Value::Double(-0.0)))
        .with(Attribute::new("string", "text", Value::String("ä string".to_owned())))
        .with(Attribute::new("token", "word", token("word")))
        .with(Attribute::new("asset", "file", Value::Asset("./other.usdc".to_owned())))
        .with(Attribute::new("float2", "two", Value::Float2([1.5, -2.5])))
        .with(Attribute::new("float3", "three", Value::Float3([0.1, 0.2, 0.3])))
        .with(Attribute::new("double2", "two_d", Value::Double2([0.1, 1e100])))
        .with(Attribute::new("double3", "three_d", Value::Double3([0.1, 0.2, 0.3])))
        .with(Attribute::new("half3", "three_h", Value::Half3(halves([0.5, 0.25, -2.0]))))
        .with(Attribute::new("quath", "turn_h", Value::Quath(halves([0.0, 0.5, 0.0, 1.0]))))
        .with(Attribute::new("quatf", "turn_f", Value::Quatf([0.2, 0.3, 0.4, 0.1])))
        .with(Attribute::new("matrix4d", "place", Value::Matrix4d(place)))
}

fn arrays(prim: Prim) -> Prim {
    let many = vec![5, 5, 5, 6, 7, 8, 1000, -1000, 100_000, i32::MIN, i32::MAX, 0, 0, 0, 0, 0, 1];
    let mut ids: Vec<i64> = (1..=14).collect();
    ids.extend([9_007_199_254_740_993, -9_007_199_254_740_993, 0]);
    let one = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];
    let turns = vec![halves([0.0, 0.0, 0.0, 1.0]), halves([0.5, 0.5, 0.0, 0.0])];
    let uniform =
        |prim: Prim, kind, name, array| prim.with(Attribute::uniform(kind, name, Value::Array(array)));
    let with = |prim: Prim, kind, name, array| prim.with(Attribute::new(kind, name, Value::Array(array)));
    let mut prim = prim;
    prim = uniform(prim, "bool[]", "flags", Array::Bool(vec![true, false, true]));
    prim = uniform(prim, "int[]", "few", Array::Int(vec![3, -1, 2]));
    prim = uniform(prim, "int[]", "many", Array::Int(many));
    prim = uniform(prim, "int64[]", "ids", Array::Int64(ids));
    prim = with(prim, "half[]", "halves", Array::Half(halves([0.5, -65504.0]).to_vec()));
    prim = with(prim, "float[]", "floats", Array::Float(vec![0.1, -0.0, 3e38]));
    prim = with(prim, "double[]", "doubles", Array::Double(vec![0.1]));
    prim = with(prim, "string[]", "texts", Array::String(texts(&["", "b", "word"])));
    prim = with(prim, "token[]", "words", Array::Token(texts(&["word", "", "other"])));
    prim = with(prim, "asset[]", "files", Array::Asset(texts(&["a.usdc", "./b c.usdc"])));
    prim = with(prim, "texCoord2f[]", "coordinates", Array::Float2(vec![[0.0, 1.0]]));
    prim = with(prim, "point3f[]", "points", Array::Float3(vec![[0.1, 0.2, 0.3], [-1.0, -2.0, -3.0]]));
    prim = with(prim, "double2[]", "pairs", Array::Double2(vec![[0.0, 1.0], [2.0, 3.0]]));
    prim = with(prim, "point3d[]", "exact", Array::Double3(vec![[0.1, 0.2, 0.3]]));
    prim = with(prim, "half3[]", "rough", Array::Half3(vec![halves([1.0, 2.0, 3.0])]));
    prim = with(prim, "quath[]", "turns_h", Array::Quath(turns));
    prim = with(prim, "quatf[]", "turns_f", Array::Quatf(vec![[0.2, 0.3, 0.4, 0.1]]));
    prim = with(prim, "matrix4d[]", "places", Array::Matrix4d(vec![one]));
    with(prim, "point3f[]", "none", Array::Float3(vec![]))
}

fn looks() -> Prim {
    let surface = "/World/Looks/Red/Shader.outputs:surface";
    let shader = Prim::def("Shader", "Shader")
        .with(Attribute::uniform("token", "info:id", token("UsdPreviewSurface")))
        .with(Attribute::new("color3f", "inputs:diffuseColor", Value::Float3([1.0, 0.0, 0.0])))
        .with(Attribute::sampled("token", "outputs:surface"));
    let red = Prim::def("Material", "Red")
        .with(Attribute::connected("token", "outputs:surface", surface))
        .child(shader);
    Prim::def("Scope", "Looks").child(red)
}

fn ball() -> Prim {
    let reference = |asset: &str, prim: &str| Reference { asset: asset.to_owned(), prim: prim.to_owned() };
    let references = ListOp::Prepend(vec![
        reference("./other.usdc", "/Ball"),
        reference("third.usdc", ""),
        reference("", "/World/Looks"),
    ]);
    let several = texts(&["/World", "/World/Ball.points", "/Elsewhere/not/here"]);
    Prim::def("Mesh", "Ball")
        .meta("instanceable", Value::Bool(true))
        .meta("references", Value::References(references))
        .with(Relationship::new("material:binding", texts(&["/World/Looks/Red"])))
        .with(Relationship::new("several", several))
}

fn clips() -> Prim {
    let array = |values: &[[f64; 2]]| Value::Array(Array::Double2(values.to_vec()));
    let clips = Dictionary::from([
        ("active".to_owned(), array(&[[0.0, 0.0], [10.0, 1.0]])),
        ("assetPaths".to_owned(), Value::Array(Array::Asset(texts(&["./a.usdc", "./b.usdc"])))),
        ("manifestAssetPath".to_owned(), Value::Asset("./manifest.usdc".to_owned())),
        ("primPath".to_owned(), Value::String("/World/Clips".to_owned())),
        ("times".to_owned(), array(&[[0.0, 0.0], [10.0, 10.0], [20.0, 20.0]])),
    ]);
    let sets = Dictionary::from([("default".to_owned(), Value::Dictionary(clips))]);
    Prim::over("Clips").meta("clips", Value::Dictionary(sets))
}

#[test]
fn samples_that_went_to_the_file_one_by_one_are_all_there() {
    const BODIES: usize = 5_003;
    const FRAMES: usize = 13;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("samples.usdc");
    let expected = folder.path().join("expected");
    fs::create_dir(&expected).unwrap();

    let mut writer = Writer::create(&path).unwrap();
    let (mut times, mut sizes) = (Vec::new(), Vec::new());
    for frame in 0..FRAMES {
        let time = frame as f64 * 0.7 - 2.0;
        // In two frames nothing moves.
        let moved = frame.min(FRAMES - 3);
        let number = |k: usize| ((k * 2_654_435_761 + moved * 40_503) % 100_003) as f32 / 1000.0 - 50.0;
        let positions: Vec<[f32; 3]> =
            (0..BODIES).map(|k| [3 * k, 3 * k + 1, 3 * k + 2].map(number)).collect();
        let turns: Vec<[f16; 4]> =
            (0..BODIES).map(|k| [k, k + 1, k + 2, k + 3].map(|k| f16::from_f32(number(k) / 50.0))).collect();
        let write = |name: &str, bytes: Vec<u8>| fs::write(expected.join(name), bytes).unwrap();
        let flat = positions.as_flattened();
        write(&format!("positions-{frame}.f32"), flat.iter().flat_map(|x| x.to_le_bytes()).collect());
        let flat = turns.as_flattened();
        write(&format!("turns-{frame}.f16"), flat.iter().flat_map(|x| x.to_le_bytes()).collect());
        let before = writer.bytes();
        writer.sample("/World/Points.positions", time, &Array::Float3(positions)).unwrap();
        writer.sample("/World/Points.orientations", time, &Array::Quath(turns)).unwrap();
        sizes.push((writer.bytes() - before) as usize);
        times.extend(time.to_le_bytes());
    }
    fs::write(expected.join("time.f64"), times).unwrap();
    assert!(
        sizes[..FRAMES - 2].iter().all(|size| (20 * BODIES..20 * BODIES + 32).contains(size)),
        "{sizes:?}"
    );
    assert_eq!(sizes[FRAMES - 2..], [0, 0], "a frame in which nothing has moved takes no room");

    let points = Prim::def("PointInstancer", "Points")
        .with(Attribute::new("int64[]", "ids", Value::Array(Array::Int64((1..=BODIES as i64).collect()))))
        .with(Attribute::sampled("point3f[]", "positions"))
        .with(Attribute::sampled("quath[]", "orientations"));
    let layer = Layer { prims: vec![Prim::def("Xform", "World").child(points)], ..Layer::default() };
    writer.finish(&layer).unwrap();
    if let Some(said) = script(&["samples".as_ref(), path.as_os_str(), expected.as_os_str()]) {
        assert_eq!(said, format!("{FRAMES} frames with {} numbers are equal", FRAMES * BODIES * 7));
    }
}
