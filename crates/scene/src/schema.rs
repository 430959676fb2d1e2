//! The JSON schema of scene files, made from the tables of keys.

use crate::root::ROOT;
use crate::rotation::AXIS_DEGREES;
use crate::spec::{ANY, Fallback, Kinds, Range, Spec, Ty};
use serde_json::{Map, Value, json};

/// Tables that others name, by their names.
type Definitions = Map<String, Value>;

/// The JSON schema of scene files (draft 2020-12), as text; the file `docs/scene.schema.json`.
pub fn schema() -> String {
    let mut definitions = Definitions::new();
    let mut schema = table(&ROOT, None, &mut definitions);
    schema["$defs"] = Value::Object(definitions);
    schema["$schema"] = json!("https://json-schema.org/draft/2020-12/schema");
    schema["title"] = json!("Rockfall scene");
    // A value of plain maps and numbers can always be written.
    let mut text = serde_json::to_string_pretty(&schema).unwrap_or_default();
    text.push('\n');
    text
}

fn table(spec: &Spec, kind: Option<&Kinds>, definitions: &mut Definitions) -> Value {
    let mut properties = Map::new();
    let mut required = Vec::new();
    if let Some(kinds) = kind {
        properties.insert("kind".to_owned(), json!({ "const": spec.name }));
        if kinds.default != Some(spec.name) {
            required.push("kind");
        }
    }
    for key in spec.keys() {
        let mut schema = value(&key.ty, definitions);
        schema["description"] = json!(key.about);
        match key.fallback {
            Fallback::Required => required.push(key.name),
            Fallback::Absent => {}
            Fallback::Default(text) => {
                let parsed = format!("default = {text}").parse::<toml::Table>().unwrap_or_default();
                for (word, default) in parsed {
                    schema[word] = serde_json::to_value(default).unwrap_or_default();
                }
            }
        }
        properties.insert(key.name.to_owned(), schema);
    }
    json!({
        "type": "object",
        "description": spec.about,
        "properties": properties,
        "required": required,
        "additionalProperties": false,
    })
}

/// A table that may stand in many places.
fn shared(spec: &Spec, definitions: &mut Definitions) -> Value {
    if !definitions.contains_key(spec.name) {
        // Its place is taken before it is made, for the one that names itself.
        definitions.insert(spec.name.to_owned(), Value::Null);
        let made = table(spec, None, definitions);
        definitions.insert(spec.name.to_owned(), made);
    }
    json!({ "$ref": format!("#/$defs/{}", spec.name) })
}

fn value(ty: &Ty, definitions: &mut Definitions) -> Value {
    let number = |range: Range| json!({ "type": "number", "minimum": range.min, "maximum": range.max });
    let int = |min: u64, max: u64| match max {
        u64::MAX => json!({ "type": "integer", "minimum": min }),
        max => json!({ "type": "integer", "minimum": min, "maximum": max }),
    };
    let list =
        |items: Value, n: usize| json!({ "type": "array", "items": items, "minItems": n, "maxItems": n });
    match *ty {
        Ty::Bool => json!({ "type": "boolean" }),
        Ty::Text | Ty::Shape | Ty::Material => json!({ "type": "string" }),
        Ty::Color => json!({ "type": "string", "pattern": "^#[0-9a-fA-F]{6}$" }),
        Ty::Int(min, max) => int(min, max),
        Ty::Number(range) => number(range),
        Ty::Numbers([], range) => json!({ "type": "array", "items": number(range), "minItems": 1 }),
        Ty::Numbers([n], range) => list(number(range), *n),
        Ty::Numbers(lengths, range) => {
            json!({ "anyOf": lengths.iter().map(|&n| list(number(range), n)).collect::<Vec<Value>>() })
        }
        Ty::Ints(n, min, max) => list(int(min, max), n),
        Ty::Interval(range) => list(number(range), 2),
        Ty::IntInterval(min, max) => list(int(min, max), 2),
        Ty::Choice(words) => json!({ "enum": words }),
        Ty::Choices(words) => json!({ "type": "array", "items": { "enum": words }, "uniqueItems": true }),
        Ty::Texts => json!({ "type": "array", "items": { "type": "string" } }),
        Ty::Points => json!({ "type": "array", "items": list(number(ANY), 3) }),
        Ty::Triangles => json!({ "type": "array", "items": list(int(0, u32::MAX.into()), 3) }),
        Ty::Rotation => {
            json!({ "anyOf": [list(number(ANY), 3), list(number(ANY), 4), shared(&AXIS_DEGREES, definitions)] })
        }
        Ty::Shapes => json!({
            "anyOf": [{ "type": "string" }, { "type": "array", "items": { "type": "string" }, "minItems": 1 }]
        }),
        Ty::Table(spec) => shared(spec, definitions),
        Ty::Kinds(kinds) => {
            let cases = kinds.cases.iter().map(|case| table(case, Some(kinds), definitions));
            json!({ "oneOf": cases.collect::<Vec<Value>>() })
        }
        Ty::Named(inner) => json!({ "type": "object", "additionalProperties": value(inner, definitions) }),
        Ty::List(inner) => json!({ "type": "array", "items": value(inner, definitions) }),
    }
}
