//! A scene as TOML, every default filled in.

use crate::node::{Node, Table, Value};
use crate::spec::Ty;
use std::fmt::Write;

/// The whole scene as one file.
pub(crate) fn scene(root: &Table) -> String {
    let mut out = String::new();
    for (name, node) in &root.entries {
        let kinds = matches!(*name, "shapes" | "generators" | "cameras");
        match &node.value {
            Value::Table(table) => section(&mut out, &format!("[{name}]"), table, kinds),
            Value::Named(tables) => {
                for (key, node) in tables {
                    if let Value::Table(table) = &node.value {
                        section(&mut out, &format!("[{name}.{}]", quoted_key(key)), table, kinds);
                    }
                }
            }
            Value::List(tables) => {
                for table in tables.iter().filter_map(Node::table) {
                    section(&mut out, &format!("[[{name}]]"), table, kinds);
                }
            }
            _ => {}
        }
    }
    out
}

fn section(out: &mut String, header: &str, table: &Table, kinds: bool) {
    if !out.is_empty() {
        out.push('\n');
    }
    out.push_str(header);
    out.push('\n');
    for (key, value) in pairs(table, kinds) {
        // Writing to a String can't fail.
        let _ = writeln!(out, "{key} = {value}");
    }
}

/// Keys and values as text; `kinds` where the table's kind is one of its keys.
fn pairs(table: &Table, kinds: bool) -> Vec<(&'static str, String)> {
    let kind = kinds.then(|| ("kind", quoted(table.spec.name)));
    let pair = |(key, node): &(&'static str, Node)| {
        let kinds = table.spec.key(key).is_some_and(|k| matches!(k.ty, Ty::Kinds(_)));
        (*key, spell(&node.value, kinds))
    };
    kind.into_iter().chain(table.entries.iter().map(pair)).collect()
}

fn spell(value: &Value, kinds: bool) -> String {
    match value {
        Value::Bool(b) => b.to_string(),
        Value::Int(i) => i.to_string(),
        Value::Number(x) => number(*x),
        Value::Text(text) => quoted(text),
        Value::List(list) => {
            let items: Vec<String> = list.iter().map(|n| spell(&n.value, kinds)).collect();
            format!("[{}]", items.join(", "))
        }
        Value::Table(table) => {
            let pairs = pairs(table, kinds).into_iter().map(|(k, v)| format!("{k} = {v}"));
            format!("{{ {} }}", pairs.collect::<Vec<String>>().join(", "))
        }
        Value::Named(_) => String::new(),
    }
}

/// The shortest text that reads back as the same number.
fn number(x: f64) -> String {
    if x.abs() >= 1e-5 || x == 0.0 { x.to_string() } else { format!("{x:e}") }
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

fn quoted_key(key: &str) -> String {
    let bare = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if !key.is_empty() && key.chars().all(bare) { key.to_owned() } else { quoted(key) }
}
