//! A scene after checking: a tree of values in which every default is filled in.

use crate::source::Span;
use crate::spec::Spec;
use crate::visual::{self, Color};
use rockfall_math::{DVec3, Vec3};

/// A value and where it was written.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    /// A value that was not written has the place of its table.
    pub(crate) span: Span,
    pub(crate) given: bool,
    pub(crate) value: Value,
}

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Bool(bool),
    Int(u64),
    Number(f64),
    Text(String),
    List(Vec<Node>),
    Table(Table),
    /// A table whose keys the user chose, in the order of the file.
    Named(Vec<(String, Node)>),
}

/// A table with the keys of its [`Spec`], in that order; optional keys that were not given are absent.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    pub(crate) spec: &'static Spec,
    /// Where it begins.
    pub(crate) span: Span,
    /// The table's name in messages: `shapes.ball`.
    pub(crate) path: String,
    pub(crate) entries: Vec<(&'static str, Node)>,
}

/// Places don't matter: a scene equals its own text with all defaults filled in.
impl PartialEq for Node {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl PartialEq for Table {
    fn eq(&self, other: &Self) -> bool {
        self.spec.name == other.spec.name && self.entries == other.entries
    }
}

impl Value {
    fn number(&self) -> f64 {
        match self {
            Value::Number(x) => *x,
            Value::Int(i) => *i as f64,
            _ => 0.0,
        }
    }

    pub(crate) fn text(&self) -> &str {
        if let Value::Text(t) = self { t } else { "" }
    }

    pub(crate) fn list(&self) -> &[Node] {
        if let Value::List(l) = self { l } else { &[] }
    }

    pub(crate) fn numbers(&self) -> Vec<f64> {
        self.list().iter().map(|n| n.value.number()).collect()
    }

    pub(crate) fn ints(&self) -> Vec<u64> {
        let int = |n: &Node| if let Value::Int(i) = n.value { i } else { 0 };
        self.list().iter().map(int).collect()
    }
}

/// Reading typed values. The checker has seen to it that a key that is not optional is there and has its type; a
/// name that the spec lacks is a mistake in this crate, which any test that reads the table brings to light.
impl Table {
    pub(crate) fn node(&self, key: &str) -> Option<&Node> {
        debug_assert!(self.spec.key(key).is_some(), "{} has no key `{key}`", self.spec.name);
        self.entries.iter().find(|(k, _)| *k == key).map(|(_, n)| n)
    }

    pub(crate) fn has(&self, key: &str) -> bool {
        self.node(key).is_some()
    }

    /// Where a key was written; the table where it was not.
    pub(crate) fn span_of(&self, key: &str) -> Span {
        self.node(key).map_or(self.span, |n| n.span)
    }

    /// The name of a key in messages: `shapes.ball.radius`.
    pub(crate) fn path_of(&self, key: &str) -> String {
        format!("{}.{key}", self.path)
    }

    /// Sets a value, in the order of the spec.
    pub(crate) fn set(&mut self, key: &'static str, value: Value) {
        let node = Node { span: self.span, given: true, value };
        if let Some((_, slot)) = self.entries.iter_mut().find(|(k, _)| *k == key) {
            *slot = node;
            return;
        }
        self.insert(key, node);
    }

    /// Adds a key that is not there, in the order of the spec.
    pub(crate) fn insert(&mut self, key: &'static str, node: Node) {
        let place = |key: &str| self.spec.keys().position(|k| k.name == key);
        let at = self.entries.iter().position(|(k, _)| place(k) > place(key)).unwrap_or(self.entries.len());
        self.entries.insert(at, (key, node));
    }

    pub(crate) fn unset(&mut self, key: &str) {
        self.entries.retain(|(k, _)| *k != key);
    }

    fn value(&self, key: &str) -> Option<&Value> {
        self.node(key).map(|n| &n.value)
    }

    pub(crate) fn bool(&self, key: &str) -> bool {
        matches!(self.value(key), Some(Value::Bool(true)))
    }

    pub(crate) fn int(&self, key: &str) -> u64 {
        if let Some(Value::Int(i)) = self.value(key) { *i } else { 0 }
    }

    pub(crate) fn f64(&self, key: &str) -> f64 {
        self.value(key).map_or(0.0, Value::number)
    }

    pub(crate) fn f32(&self, key: &str) -> f32 {
        self.f64(key) as f32
    }

    pub(crate) fn text(&self, key: &str) -> &str {
        self.value(key).map_or("", Value::text)
    }

    pub(crate) fn color(&self, key: &str) -> Option<Color> {
        visual::parse(self.text(key))
    }

    pub(crate) fn list(&self, key: &str) -> &[Node] {
        self.value(key).map_or(&[], Value::list)
    }

    pub(crate) fn numbers(&self, key: &str) -> Vec<f64> {
        self.value(key).map_or(Vec::new(), Value::numbers)
    }

    pub(crate) fn ints(&self, key: &str) -> Vec<u64> {
        self.value(key).map_or(Vec::new(), Value::ints)
    }

    pub(crate) fn dvec3(&self, key: &str) -> DVec3 {
        match self.numbers(key)[..] {
            [x, y, z] => DVec3::new(x, y, z),
            _ => DVec3::ZERO,
        }
    }

    pub(crate) fn vec3(&self, key: &str) -> Vec3 {
        self.dvec3(key).as_vec3()
    }

    /// Two numbers.
    pub(crate) fn pair(&self, key: &str) -> (f64, f64) {
        match self.numbers(key)[..] {
            [a, b] => (a, b),
            _ => (0.0, 0.0),
        }
    }

    /// A list of points.
    pub(crate) fn points(&self, key: &str) -> Vec<Vec3> {
        let point = |n: &Node| match n.value.numbers()[..] {
            [x, y, z] => DVec3::new(x, y, z).as_vec3(),
            _ => Vec3::ZERO,
        };
        self.list(key).iter().map(point).collect()
    }

    pub(crate) fn table(&self, key: &str) -> Option<&Table> {
        match self.value(key) {
            Some(Value::Table(t)) => Some(t),
            _ => None,
        }
    }

    /// The tables of a list.
    pub(crate) fn tables(&self, key: &str) -> impl Iterator<Item = &Table> {
        self.list(key).iter().filter_map(Node::table)
    }

    /// Tables under names that the user chose.
    pub(crate) fn named(&self, key: &str) -> impl Iterator<Item = (&str, &Table)> {
        let entries = if let Some(Value::Named(n)) = self.value(key) { n.as_slice() } else { &[] };
        entries.iter().filter_map(|(name, node)| node.table().map(|t| (name.as_str(), t)))
    }
}

impl Node {
    pub(crate) fn table(&self) -> Option<&Table> {
        if let Value::Table(t) = &self.value { Some(t) } else { None }
    }
}
