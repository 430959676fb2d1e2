//! A scene as TOML, every default filled in.

use crate::node::{Node, Table, Value};
use crate::source::Sources;
use crate::spec::Ty;
use std::fmt::Write;

/// The whole scene as one file. Paths of other files become absolute, so that the text means the same in any folder.
pub(crate) fn scene(root: &Table, sources: &Sources) -> String {
    let writer = Writer { sources };
    let mut out = String::new();
    for (name, node) in &root.entries {
        match &node.value {
            Value::Table(table) => writer.section(&mut out, &format!("[{name}]"), table),
            Value::Named(tables) => {
                for (key, node) in tables {
                    if let Value::Table(table) = &node.value {
                        writer.section(&mut out, &format!("[{name}.{}]", quoted_key(key)), table);
                    }
                }
            }
            Value::List(tables) => {
                for table in tables.iter().filter_map(Node::table) {
                    writer.section(&mut out, &format!("[[{name}]]"), table);
                }
            }
            _ => {}
        }
    }
    out
}

struct Writer<'a> {
    sources: &'a Sources,
}

impl Writer<'_> {
    fn section(&self, out: &mut String, header: &str, table: &Table) {
        if !out.is_empty() {
            out.push('\n');
        }
        out.push_str(header);
        out.push('\n');
        for (key, value) in self.pairs(table) {
            // Writing to a String can't fail.
            let _ = writeln!(out, "{key} = {value}");
        }
    }

    fn pairs(&self, table: &Table) -> Vec<(&'static str, String)> {
        let kind = is_case(table).then(|| ("kind", quoted(table.spec.name)));
        let pair = |(key, node): &(&'static str, Node)| {
            let path = *key == "file" && table.spec.key(key).is_some_and(|k| matches!(k.ty, Ty::Text));
            let text = if path {
                let joined = self.sources.get(node.span).base.join(node.value.text());
                let absolute = std::path::absolute(&joined).unwrap_or(joined);
                quoted(&absolute.display().to_string())
            } else {
                self.value(&node.value)
            };
            (*key, text)
        };
        kind.into_iter().chain(table.entries.iter().map(pair)).collect()
    }

    fn value(&self, value: &Value) -> String {
        match value {
            Value::Bool(b) => b.to_string(),
            Value::Int(i) => i.to_string(),
            Value::Number(x) => number(*x),
            Value::Text(text) => quoted(text),
            Value::List(list) => {
                let items: Vec<String> = list.iter().map(|n| self.value(&n.value)).collect();
                format!("[{}]", items.join(", "))
            }
            Value::Table(table) => {
                let pairs = self.pairs(table).into_iter().map(|(k, v)| format!("{k} = {v}"));
                format!("{{ {} }}", pairs.collect::<Vec<String>>().join(", "))
            }
            Value::Named(_) => String::new(),
        }
    }
}

/// Whether a table is one of several kinds.
fn is_case(table: &Table) -> bool {
    let kinds = [&crate::shapes::SHAPES, &crate::generators::GENERATORS, &crate::region::REGIONS];
    kinds.iter().any(|k| k.cases.iter().any(|c| std::ptr::eq(*c, table.spec)))
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
