//! From TOML to checked values: every key known, every type right, every number in its range, every default there.

use crate::error::Problem;
use crate::node::{Node, Table, Value};
use crate::source::Span;
use crate::spec::{Fallback, Kinds, Range, Spec, Ty, one_of};
use crate::visual;
use std::ops::Range as Bytes;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

type Raw<'a> = Spanned<DeValue<'a>>;

/// Checks one text and gathers what is wrong with it.
pub(crate) struct Checker<'p> {
    /// Index of the text.
    pub(crate) source: u32,
    pub(crate) problems: &'p mut Vec<Problem>,
}

impl Checker<'_> {
    fn span(&self, bytes: Bytes<usize>) -> Span {
        Span { source: self.source, start: bytes.start as u32, end: bytes.end as u32 }
    }

    fn report(&mut self, problem: Problem) -> Option<Value> {
        self.problems.push(problem);
        None
    }

    /// The value has another type than it should.
    fn wrong(&mut self, raw: &Raw<'_>, ty: &Ty, path: &str) -> Option<Value> {
        let message = format!("`{path}` is {}", describe(raw.get_ref()));
        let problem = Problem::at(self.span(raw.span()), message).expecting(ty.expected());
        self.report(problem)
    }

    /// Checks a table against its spec. `span` is where the table begins.
    pub(crate) fn table(
        &mut self,
        spec: &'static Spec,
        raw: &DeTable<'_>,
        span: Span,
        path: &str,
        kind: bool,
    ) -> Table {
        self.unknown(spec, raw, path, kind);
        let entries = spec.keys().filter_map(|key| {
            let path = if path.is_empty() { key.name.to_owned() } else { format!("{path}.{}", key.name) };
            if let Some(value) = raw.get(key.name) {
                let node = self.node(&key.ty, value, &path)?;
                return Some((key.name, node));
            }
            match key.fallback {
                Fallback::Absent => None,
                Fallback::Required => {
                    let message = format!("`{path}` is missing");
                    self.problems.push(Problem::at(span, message).expecting(key.ty.expected()));
                    None
                }
                Fallback::Default(text) => {
                    let raw = DeValue::parse(text).ok()?;
                    let mut node = self.node(&key.ty, &raw, &path)?;
                    (node.span, node.given) = (span, false);
                    Some((key.name, node))
                }
            }
        });
        Table { spec, span, path: path.to_owned(), entries: entries.collect() }
    }

    fn unknown(&mut self, spec: &'static Spec, raw: &DeTable<'_>, path: &str, kind: bool) {
        let names = || spec.keys().map(|k| k.name).chain(kind.then_some("kind"));
        for key in raw.keys() {
            let name: &str = key.get_ref();
            if names().all(|n| n != name) {
                let of = if path.is_empty() { String::new() } else { format!(" in `{path}`") };
                let problem = Problem::at(self.span(key.span()), format!("unknown key `{name}`{of}"));
                self.problems.push(problem.expecting(one_of(names())).near(name, names()));
            }
        }
    }

    fn node(&mut self, ty: &Ty, raw: &Raw<'_>, path: &str) -> Option<Node> {
        let value = self.value(ty, raw, path)?;
        Some(Node { span: self.span(raw.span()), given: true, value })
    }

    fn value(&mut self, ty: &Ty, raw: &Raw<'_>, path: &str) -> Option<Value> {
        let value = raw.get_ref();
        match *ty {
            Ty::Bool => match value.as_bool() {
                Some(b) => Some(Value::Bool(b)),
                None => self.wrong(raw, ty, path),
            },
            Ty::Text | Ty::Shape | Ty::Material => match value.as_str() {
                Some(text) => Some(Value::Text(text.to_owned())),
                None => self.wrong(raw, ty, path),
            },
            Ty::Color => match value.as_str() {
                Some(text) if visual::parse(text).is_some() => Some(Value::Text(text.to_owned())),
                Some(text) => {
                    let problem = Problem::at(self.span(raw.span()), format!("`{path}` is \"{text}\""));
                    self.report(problem.expecting(ty.expected()))
                }
                None => self.wrong(raw, ty, path),
            },
            Ty::Choice(words) => match value.as_str() {
                Some(text) if words.contains(&text) => Some(Value::Text(text.to_owned())),
                Some(text) => {
                    let problem = Problem::at(self.span(raw.span()), format!("`{path}` is \"{text}\""));
                    self.report(problem.expecting(ty.expected()).near(text, words.iter().copied()))
                }
                None => self.wrong(raw, ty, path),
            },
            Ty::Int(min, max) => self.int(ty, (min, max), raw, path),
            Ty::Number(range) => self.number(ty, range, raw, path),
            Ty::Numbers(lengths, range) => {
                let list = self.list(ty, &Ty::Number(range), raw, path)?;
                self.length(ty, lengths, list, raw, path)
            }
            Ty::Ints(n, min, max) => {
                let list = self.list(ty, &Ty::Int(min, max), raw, path)?;
                self.length(ty, &[n], list, raw, path)
            }
            Ty::Interval(range) => {
                let list = self.list(ty, &Ty::Number(range), raw, path)?;
                let list = self.length(ty, &[2], list, raw, path)?;
                self.ordered(ty, list, raw, path)
            }
            Ty::IntInterval(min, max) => {
                let list = self.list(ty, &Ty::Int(min, max), raw, path)?;
                let list = self.length(ty, &[2], list, raw, path)?;
                self.ordered(ty, list, raw, path)
            }
            Ty::Choices(words) => {
                let list = self.list(ty, &Ty::Choice(words), raw, path)?;
                if let Value::List(nodes) = &list {
                    for (i, node) in nodes.iter().enumerate() {
                        if nodes[..i].contains(node) {
                            let message = format!("`{path}` has `{}` twice", node.value.text());
                            return self.report(Problem::at(node.span, message).expecting("each word once"));
                        }
                    }
                }
                Some(list)
            }
            Ty::Texts => self.list(ty, &Ty::Text, raw, path),
            Ty::Points => self.list(ty, &Ty::Numbers(&[3], crate::spec::ANY), raw, path),
            Ty::Triangles => self.list(ty, &Ty::Ints(3, 0, u64::from(u32::MAX)), raw, path),
            Ty::Shapes => match value {
                DeValue::String(_) => self.value(&Ty::Shape, raw, path),
                DeValue::Array(array) if !array.is_empty() => self.list(ty, &Ty::Shape, raw, path),
                _ => self.wrong(raw, ty, path),
            },
            Ty::Rotation => match value {
                DeValue::Array(_) => self.value(&Ty::Numbers(&[3, 4], crate::spec::ANY), raw, path),
                DeValue::Table(_) => self.value(&Ty::Table(&crate::rotation::AXIS_DEGREES), raw, path),
                _ => self.wrong(raw, ty, path),
            },
            Ty::Table(spec) => match value.as_table() {
                Some(table) => {
                    Some(Value::Table(self.table(spec, table, self.span(raw.span()), path, false)))
                }
                None => self.wrong(raw, ty, path),
            },
            Ty::Kinds(kinds) => match value.as_table() {
                Some(table) => self.kind(kinds, table, self.span(raw.span()), path),
                None => self.wrong(raw, ty, path),
            },
            Ty::Named(inner) => match value.as_table() {
                Some(table) => {
                    let mut entries: Vec<_> = table.iter().collect();
                    entries.sort_by_key(|(name, _)| name.span().start);
                    let entry = |(name, raw): (&Spanned<_>, &Raw<'_>)| {
                        let name: &std::borrow::Cow<'_, str> = name.get_ref();
                        let node = self.node(inner, raw, &format!("{path}.{name}"))?;
                        Some((name.clone().into_owned(), node))
                    };
                    Some(Value::Named(entries.into_iter().filter_map(entry).collect()))
                }
                None => self.wrong(raw, ty, path),
            },
            Ty::List(inner) => self.list(ty, inner, raw, path),
        }
    }

    fn int(&mut self, ty: &Ty, limits: (u64, u64), raw: &Raw<'_>, path: &str) -> Option<Value> {
        let Some(int) = raw.get_ref().as_integer() else { return self.wrong(raw, ty, path) };
        match u64::from_str_radix(int.as_str(), int.radix()) {
            Ok(i) if (limits.0..=limits.1).contains(&i) => Some(Value::Int(i)),
            _ => {
                let problem = Problem::at(self.span(raw.span()), format!("`{path}` is {int}"));
                self.report(problem.expecting(ty.expected()))
            }
        }
    }

    fn number(&mut self, ty: &Ty, range: Range, raw: &Raw<'_>, path: &str) -> Option<Value> {
        let (x, text) = match raw.get_ref() {
            DeValue::Float(float) => (float.as_str().parse().unwrap_or(f64::NAN), float.to_string()),
            DeValue::Integer(int) => {
                let x = i128::from_str_radix(int.as_str(), int.radix()).map_or(f64::INFINITY, |i| i as f64);
                (x, int.to_string())
            }
            _ => return self.wrong(raw, ty, path),
        };
        if range.holds(x) {
            return Some(Value::Number(x));
        }
        let expected = if !x.is_finite() {
            format!("{}, finite", ty.expected())
        } else if (x > 0.0 && x < range.min && range.min == crate::spec::SMALLEST)
            || x.abs() > crate::spec::LARGEST
        {
            format!("a number {}", range.exact())
        } else {
            ty.expected()
        };
        self.report(Problem::at(self.span(raw.span()), format!("`{path}` is {text}")).expecting(expected))
    }

    /// Checks the elements of a list; one that is wrong makes the list wrong.
    fn list(&mut self, ty: &Ty, inner: &Ty, raw: &Raw<'_>, path: &str) -> Option<Value> {
        let Some(array) = raw.get_ref().as_array() else { return self.wrong(raw, ty, path) };
        let mut nodes = Vec::with_capacity(array.len());
        for (i, item) in array.iter().enumerate() {
            nodes.extend(self.node(inner, item, &format!("{path}.{}", i + 1)));
        }
        (nodes.len() == array.len()).then_some(Value::List(nodes))
    }

    fn length(
        &mut self,
        ty: &Ty,
        allowed: &[usize],
        list: Value,
        raw: &Raw<'_>,
        path: &str,
    ) -> Option<Value> {
        let n = list.list().len();
        if (allowed.is_empty() && n > 0) || allowed.contains(&n) {
            return Some(list);
        }
        let plural = if n == 1 { "" } else { "s" };
        let message = format!("`{path}` is a list of {n} value{plural}");
        self.report(Problem::at(self.span(raw.span()), message).expecting(ty.expected()))
    }

    fn ordered(&mut self, ty: &Ty, list: Value, raw: &Raw<'_>, path: &str) -> Option<Value> {
        match list.numbers()[..] {
            [a, b] if a <= b => Some(list),
            [a, b] => {
                let problem = Problem::at(self.span(raw.span()), format!("`{path}` is [{a}, {b}]"));
                self.report(problem.expecting(ty.expected()))
            }
            _ => None,
        }
    }

    fn kind(&mut self, kinds: &'static Kinds, raw: &DeTable<'_>, span: Span, path: &str) -> Option<Value> {
        let names = || kinds.cases.iter().map(|c| c.name);
        let expected = || one_of(names());
        let word = match raw.get("kind") {
            None => match kinds.default {
                Some(word) => word,
                None => {
                    let problem = Problem::at(span, format!("`{path}.kind` is missing"));
                    return self.report(problem.expecting(expected()));
                }
            },
            Some(value) => match value.get_ref().as_str() {
                Some(word) => word,
                None => {
                    let message = format!("`{path}.kind` is {}", describe(value.get_ref()));
                    return self.report(Problem::at(self.span(value.span()), message).expecting(expected()));
                }
            },
        };
        let Some(spec) = kinds.cases.iter().find(|c| c.name == word) else {
            let at = raw.get("kind").map_or(span, |v| self.span(v.span()));
            let problem = Problem::at(at, format!("`{path}.kind` is \"{word}\""));
            return self.report(problem.expecting(expected()).near(word, names()));
        };
        Some(Value::Table(self.table(spec, raw, span, path, true)))
    }
}

/// What a value is, in words.
fn describe(value: &DeValue<'_>) -> String {
    match value {
        DeValue::String(text) => format!("the text \"{text}\""),
        DeValue::Integer(int) => format!("the number {int}"),
        DeValue::Float(float) => format!("the number {float}"),
        DeValue::Boolean(b) => b.to_string(),
        DeValue::Datetime(_) => "a date".to_owned(),
        DeValue::Array(array) if array.is_empty() => "an empty list".to_owned(),
        DeValue::Array(_) => "a list".to_owned(),
        DeValue::Table(_) => "a table".to_owned(),
    }
}
