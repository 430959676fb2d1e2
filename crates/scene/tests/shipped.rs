//! The scenes that ship: each can be read, has the bodies that it promises, validates against the schema, reads back from
//! its filled form, and becomes a world that steps.

use rockfall_scene::Scene;
use serde_json::Value;
use std::path::{Path, PathBuf};

fn scenes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

/// Name, and bodies including those that are poured.
const SHIPPED: [(&str, u64); 15] = [
    ("hello", 10),
    ("rockslide", 20_001),
    ("pyramid", 5_051),
    ("brick-wall", 492),
    ("ball-pit", 100_005),
    ("box-pile", 10_005),
    ("hull-pile", 10_005),
    ("bunny-drop", 205),
    ("impulse", 16),
    ("reflect", 80),
    ("shapes", 241),
    ("compounds", 167),
    ("cup", 14),
    ("hare-in-cup", 3),
    ("hares", 126),
];

fn load(name: &str) -> Scene {
    Scene::load(scenes().join(format!("{name}.toml"))).unwrap_or_else(|e| panic!("{}", e.render(false)))
}

#[test]
fn every_file_in_the_folder_is_in_the_list() {
    let mut found: Vec<String> = std::fs::read_dir(scenes())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned())
        .collect();
    let mut listed = SHIPPED.map(|(name, _)| name);
    found.sort();
    listed.sort();
    assert_eq!(found, listed);
}

#[test]
fn every_scene_has_its_bodies_with_ids_from_one() {
    for (name, bodies) in SHIPPED {
        let scene = load(name);
        assert_eq!(scene.body_count(), bodies, "{name}");
        let table = scene.body_table().unwrap_or_else(|e| panic!("{}", e.render(false)));
        assert_eq!(table.len() as u64, bodies, "{name}");
        assert!(table.iter().zip(1..).all(|(row, id)| row.id == id), "{name}");
    }
}

#[test]
fn the_filled_scene_reads_back_as_the_same_scene() {
    for (name, _) in SHIPPED {
        let mut scene = load(name);
        scene.override_seed(u64::MAX);
        scene.override_substeps(7);
        scene.override_frames(11);
        scene.override_solver(rockfall::Solver::Impulse);
        let text = scene.to_toml_filled();
        let again = Scene::parse(&text, "filled.toml", "/nowhere")
            .unwrap_or_else(|e| panic!("{}\n{text}", e.render(false)));
        assert!(scene == again, "{name}\n{text}");
        assert_eq!((scene.settings, scene.frames, scene.seed), (again.settings, again.frames, again.seed));
        assert_eq!(text, again.to_toml_filled(), "{name}");
        assert!(scene != load(name), "{name}");
    }
}

#[test]
fn the_filled_scene_has_the_same_bodies() {
    for name in ["hello", "brick-wall", "bunny-drop", "hull-pile"] {
        let scene = load(name);
        let again = Scene::parse(&scene.to_toml_filled(), "filled.toml", "/nowhere").unwrap();
        assert_eq!(scene.body_table().unwrap(), again.body_table().unwrap(), "{name}");
    }
}

#[test]
fn every_scene_becomes_a_world_that_steps() {
    for (name, bodies) in SHIPPED {
        let mut running = load(name).build().unwrap_or_else(|e| panic!("{name}: {}", e.render(false)));
        assert_eq!((running.world.len() + running.waiting()) as u64, bodies, "{name}");
        for frame in 0..3 {
            let before = running.world.len();
            let emitted = running.before_step(frame).unwrap();
            assert_eq!(running.world.len(), before + emitted, "{name}");
            running.world.step();
        }
        assert_eq!(running.world.frozen(), [], "{name}");
        assert_eq!((running.world.len() + running.waiting()) as u64, bodies, "{name}");
    }
}

/// Each section of the guide to shapes has a picture, made by the command that stands there of the scene beside it.
#[test]
fn every_shape_of_the_guide_has_a_picture_and_the_scene_that_it_shows() {
    let docs = scenes().join("../docs");
    let text = std::fs::read_to_string(docs.join("shapes.md")).unwrap();
    let mut shown = Vec::new();
    for section in text.split("\n## ").skip(1) {
        let (title, rest) = section.split_once('\n').unwrap();
        let found = rest.split("](images/shapes/").nth(1).and_then(|rest| rest.split_once(".png)"));
        let (name, _) = found.unwrap_or_else(|| panic!("{title} has no picture"));
        let picture = docs.join(format!("images/shapes/{name}.png"));
        let size = std::fs::metadata(&picture).unwrap_or_else(|e| panic!("{}: {e}", picture.display())).len();
        assert!((1000..25_000).contains(&size), "{name} has {size} bytes");
        let scene =
            Scene::load(picture.with_extension("toml")).unwrap_or_else(|e| panic!("{}", e.render(false)));
        scene.inventory().unwrap_or_else(|e| panic!("{}", e.render(false)));
        shown.push(name.to_owned());
    }
    let entries = std::fs::read_dir(docs.join("images/shapes")).unwrap().map(|entry| entry.unwrap().path());
    let scenes = entries.filter(|path| path.extension().is_some_and(|e| e == "toml"));
    let mut there: Vec<String> =
        scenes.map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned()).collect();
    there.sort();
    shown.sort();
    assert_eq!(shown, there);
}

/// The words of JSON schema that the schema uses; any other word is an error. `whole` has the definitions.
fn complaints(whole: &Value, schema: &Value, value: &Value, at: &str, out: &mut Vec<String>) {
    let mut complain = |what: String| out.push(format!("{at}: {what}"));
    let mut inner = Vec::new();
    for (word, rule) in schema.as_object().unwrap() {
        match word.as_str() {
            "$schema" | "$defs" | "title" | "description" | "default" => {}
            "$ref" => {
                let name = rule.as_str().and_then(|rule| rule.strip_prefix("#/$defs/")).unwrap();
                inner.push((whole["$defs"][name].clone(), value));
                assert!(whole["$defs"][name].is_object(), "{name}");
            }
            "type" => {
                let good = match rule.as_str().unwrap() {
                    "object" => value.is_object(),
                    "array" => value.is_array(),
                    "string" => value.is_string(),
                    "boolean" => value.is_boolean(),
                    "integer" => value.is_u64() || value.is_i64(),
                    "number" => value.is_number(),
                    other => panic!("unknown type {other}"),
                };
                if !good {
                    complain(format!("is no {rule}"));
                }
            }
            "minimum" | "maximum" => {
                let (x, limit) = (value.as_f64().unwrap_or(f64::NAN), rule.as_f64().unwrap());
                if (word == "minimum" && x < limit) || (word == "maximum" && x > limit) {
                    complain(format!("{x} against {word} {limit}"));
                }
            }
            "minItems" | "maxItems" => {
                let (n, limit) = (value.as_array().map_or(0, Vec::len) as u64, rule.as_u64().unwrap());
                if value.is_array()
                    && ((word == "minItems" && n < limit) || (word == "maxItems" && n > limit))
                {
                    complain(format!("{n} items against {word} {limit}"));
                }
            }
            "const" if value != rule => complain(format!("is not {rule}")),
            "enum" if !rule.as_array().unwrap().contains(value) => complain(format!("is not one of {rule}")),
            "const" | "enum" | "uniqueItems" => {}
            "pattern" => {
                assert_eq!(rule, "^#[0-9a-fA-F]{6}$", "the only one so far");
                let digits = value.as_str().and_then(|text| text.strip_prefix('#')).unwrap_or_default();
                if digits.len() != 6 || !digits.bytes().all(|byte| byte.is_ascii_hexdigit()) {
                    complain(format!("does not match {rule}"));
                }
            }
            "required" => {
                for key in rule.as_array().unwrap() {
                    if value.is_object() && value.get(key.as_str().unwrap()).is_none() {
                        complain(format!("{key} is missing"));
                    }
                }
            }
            "items" => {
                value.as_array().into_iter().flatten().for_each(|item| inner.push((rule.clone(), item)));
            }
            "properties" => {
                for (key, item) in value.as_object().into_iter().flatten() {
                    rule.get(key).into_iter().for_each(|rule| inner.push((rule.clone(), item)));
                }
            }
            "additionalProperties" => {
                for (key, item) in value.as_object().into_iter().flatten() {
                    if schema.get("properties").is_some_and(|known| known.get(key).is_some()) {
                        continue;
                    }
                    match rule {
                        Value::Bool(false) => complain(format!("unknown key {key}")),
                        rule => inner.push((rule.clone(), item)),
                    }
                }
            }
            "anyOf" | "oneOf" => {
                let fits = |case: &&Value| {
                    let mut found = Vec::new();
                    complaints(whole, case, value, at, &mut found);
                    found.is_empty()
                };
                let fitting = rule.as_array().unwrap().iter().filter(fits).count();
                if fitting == 0 || (word == "oneOf" && fitting > 1) {
                    complain(format!("fits {fitting} cases of {word}"));
                }
            }
            other => panic!("the schema uses {other}"),
        }
    }
    inner.into_iter().for_each(|(rule, item)| complaints(whole, &rule, item, at, out));
}

#[test]
fn every_scene_validates_and_the_schema_rejects_what_the_reader_rejects() {
    let schema: Value = serde_json::from_str(&rockfall_scene::schema()).unwrap();
    let check = |text: &str| {
        let value = serde_json::to_value(text.parse::<toml::Table>().unwrap()).unwrap();
        let mut out = Vec::new();
        complaints(&schema, &schema, &value, "scene", &mut out);
        out
    };
    for (name, _) in SHIPPED {
        let text = std::fs::read_to_string(scenes().join(format!("{name}.toml"))).unwrap();
        assert_eq!(check(&text), [""; 0], "{name}");
        assert_eq!(check(&load(name).to_toml_filled()), [""; 0], "{name}, filled");
    }
    for wrong in [
        "wrld = {}",
        "[world]\nrate = 0",
        "[world]\nsolver = \"none\"",
        "[shapes.x]\nkind = \"sphere\"",
        "[shapes.x]\nkind = \"sphere\"\nradius = 1\nlength = 2",
        "[[bodies]]\nshape = \"x\"\nposition = [0, 0]",
        "[materials.x]\ncolor = \"red\"",
    ] {
        assert!(!check(wrong).is_empty(), "{wrong}");
        assert!(Scene::parse(wrong, "x", ".").is_err(), "{wrong}");
    }
}
