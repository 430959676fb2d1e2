//! What a layer holds: a tree of prims with properties and metadata.

use crate::Value;

/// Named values: metadata of a layer, a prim or a property.
pub type Metadata = Vec<(&'static str, Value)>;

/// A layer: what one file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layer {
    /// `upAxis`, `metersPerUnit`, `defaultPrim` and the like.
    pub metadata: Metadata,
    /// The prims without a parent.
    pub prims: Vec<Prim>,
}

/// How a prim takes part in the composed scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(u32)]
pub enum Specifier {
    /// It defines something.
    #[default]
    Def = 0,
    /// It adds to what is defined elsewhere.
    Over = 1,
    /// It is there to be inherited from.
    Class = 2,
}

/// A node of the scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Prim {
    /// Unique among its siblings: letters, digits, underscores, not a digit first.
    pub name: String,
    /// What it is there for.
    pub specifier: Specifier,
    /// The name of its schema, as `Mesh`; empty without.
    pub type_name: &'static str,
    /// `kind`, `apiSchemas`, `references`, `clips` and the like.
    pub metadata: Metadata,
    /// Attributes and relationships.
    pub properties: Vec<Property>,
    /// The prims below it.
    pub children: Vec<Prim>,
}

impl Prim {
    /// A prim that defines something.
    pub fn def(type_name: &'static str, name: impl Into<String>) -> Self {
        Prim { name: name.into(), type_name, ..Prim::default() }
    }

    /// A prim that adds to one that is defined elsewhere.
    pub fn over(name: impl Into<String>) -> Self {
        Prim { name: name.into(), specifier: Specifier::Over, ..Prim::default() }
    }

    /// With a value of metadata.
    pub fn meta(mut self, key: &'static str, value: Value) -> Self {
        self.metadata.push((key, value));
        self
    }

    /// With a property.
    pub fn with(mut self, property: impl Into<Property>) -> Self {
        self.properties.push(property.into());
        self
    }

    /// With a prim below it.
    pub fn child(mut self, prim: Prim) -> Self {
        self.children.push(prim);
        self
    }
}

/// A property of a prim.
#[derive(Clone, Debug, PartialEq)]
pub enum Property {
    /// A value, which may change in time.
    Attribute(Attribute),
    /// Pointers to other prims or properties.
    Relationship(Relationship),
}

impl From<Attribute> for Property {
    fn from(attribute: Attribute) -> Self {
        Property::Attribute(attribute)
    }
}

impl From<Relationship> for Property {
    fn from(relationship: Relationship) -> Self {
        Property::Relationship(relationship)
    }
}

/// A value of a prim. Samples of it are given to [`Writer::sample`](crate::Writer::sample).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attribute {
    /// Unique within its prim; parts may be separated by colons, as in `primvars:displayColor`.
    pub name: String,
    /// Its type, as in `point3f[]`.
    pub type_name: &'static str,
    /// Whether it never changes in time.
    pub uniform: bool,
    /// What it is where it has no samples.
    pub default: Option<Value>,
    /// Paths of the attributes that it takes its value from.
    pub connections: Vec<String>,
    /// `interpolation` and the like.
    pub metadata: Metadata,
}

impl Attribute {
    /// An attribute with a value.
    pub fn new(type_name: &'static str, name: impl Into<String>, value: Value) -> Self {
        Attribute { default: Some(value), ..Attribute::sampled(type_name, name) }
    }

    /// An attribute with a value that never changes.
    pub fn uniform(type_name: &'static str, name: impl Into<String>, value: Value) -> Self {
        Attribute { uniform: true, ..Attribute::new(type_name, name, value) }
    }

    /// An attribute without a value but its samples, or with none at all.
    pub fn sampled(type_name: &'static str, name: impl Into<String>) -> Self {
        Attribute { name: name.into(), type_name, ..Attribute::default() }
    }

    /// An attribute that takes its value from another one.
    pub fn connected(type_name: &'static str, name: impl Into<String>, to: impl Into<String>) -> Self {
        Attribute { connections: vec![to.into()], ..Attribute::sampled(type_name, name) }
    }

    /// With a value of metadata.
    pub fn meta(mut self, key: &'static str, value: Value) -> Self {
        self.metadata.push((key, value));
        self
    }
}

/// Pointers to prims or properties.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Relationship {
    /// Unique within its prim.
    pub name: String,
    /// Absolute paths.
    pub targets: Vec<String>,
}

impl Relationship {
    /// A relationship to some paths.
    pub fn new(name: impl Into<String>, targets: Vec<String>) -> Self {
        Relationship { name: name.into(), targets }
    }
}
