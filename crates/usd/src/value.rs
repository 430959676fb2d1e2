//! Values and their types.

use half::f16;
use std::collections::BTreeMap;

/// A value of an attribute or of metadata. Quaternions are x, y, z, w; matrices rows, for vectors that stand before them.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub enum Value {
    Bool(bool),
    Int(i32),
    Int64(i64),
    Half(f16),
    Float(f32),
    Double(f64),
    String(String),
    Token(String),
    /// The path of a file.
    Asset(String),
    Float2([f32; 2]),
    Float3([f32; 3]),
    Double2([f64; 2]),
    Double3([f64; 3]),
    Half3([f16; 3]),
    Quath([f16; 4]),
    Quatf([f32; 4]),
    Matrix4d([[f64; 4]; 4]),
    Array(Array),
    Dictionary(Dictionary),
    Tokens(ListOp<String>),
    /// Absolute paths.
    Paths(ListOp<String>),
    References(ListOp<Reference>),
}

/// Values by name.
pub type Dictionary = BTreeMap<String, Value>;

/// Values of one type.
#[derive(Clone, Debug, PartialEq)]
#[allow(missing_docs)]
pub enum Array {
    Bool(Vec<bool>),
    Int(Vec<i32>),
    Int64(Vec<i64>),
    Half(Vec<f16>),
    Float(Vec<f32>),
    Double(Vec<f64>),
    String(Vec<String>),
    Token(Vec<String>),
    Asset(Vec<String>),
    Float2(Vec<[f32; 2]>),
    Float3(Vec<[f32; 3]>),
    Double2(Vec<[f64; 2]>),
    Double3(Vec<[f64; 3]>),
    Half3(Vec<[f16; 3]>),
    Quath(Vec<[f16; 4]>),
    Quatf(Vec<[f32; 4]>),
    Matrix4d(Vec<[[f64; 4]; 4]>),
}

/// A list that layers edit together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ListOp<T> {
    /// The list, whatever weaker layers say.
    Explicit(Vec<T>),
    /// What comes before that of weaker layers.
    Prepend(Vec<T>),
}

impl<T> ListOp<T> {
    pub(crate) fn items(&self) -> &[T] {
        let (ListOp::Explicit(items) | ListOp::Prepend(items)) = self;
        items
    }
}

/// A reference to a prim, in this layer or in another one.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reference {
    /// The other layer's file; empty for this one.
    pub asset: String,
    /// Absolute path of the prim; empty for the layer's default prim.
    pub prim: String,
}

/// Types as the format numbers them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u8)]
pub(crate) enum Kind {
    Bool = 1,
    Int = 3,
    Int64 = 5,
    Half = 7,
    Float = 8,
    Double = 9,
    String = 10,
    Token = 11,
    Asset = 12,
    Matrix4d = 15,
    Quatf = 17,
    Quath = 18,
    Double2 = 19,
    Float2 = 20,
    Double3 = 23,
    Float3 = 24,
    Half3 = 25,
    Dictionary = 31,
    TokenListOp = 32,
    PathListOp = 34,
    ReferenceListOp = 35,
    TokenVector = 41,
    Specifier = 42,
    Variability = 44,
    TimeSamples = 46,
    DoubleVector = 48,
}

impl Value {
    /// The kind, and whether it is an array.
    pub(crate) fn kind(&self) -> (Kind, bool) {
        let kind = match self {
            Value::Bool(_) => Kind::Bool,
            Value::Int(_) => Kind::Int,
            Value::Int64(_) => Kind::Int64,
            Value::Half(_) => Kind::Half,
            Value::Float(_) => Kind::Float,
            Value::Double(_) => Kind::Double,
            Value::String(_) => Kind::String,
            Value::Token(_) => Kind::Token,
            Value::Asset(_) => Kind::Asset,
            Value::Float2(_) => Kind::Float2,
            Value::Float3(_) => Kind::Float3,
            Value::Double2(_) => Kind::Double2,
            Value::Double3(_) => Kind::Double3,
            Value::Half3(_) => Kind::Half3,
            Value::Quath(_) => Kind::Quath,
            Value::Quatf(_) => Kind::Quatf,
            Value::Matrix4d(_) => Kind::Matrix4d,
            Value::Array(array) => return (array.kind(), true),
            Value::Dictionary(_) => Kind::Dictionary,
            Value::Tokens(_) => Kind::TokenListOp,
            Value::Paths(_) => Kind::PathListOp,
            Value::References(_) => Kind::ReferenceListOp,
        };
        (kind, false)
    }
}

impl Array {
    pub(crate) fn kind(&self) -> Kind {
        match self {
            Array::Bool(_) => Kind::Bool,
            Array::Int(_) => Kind::Int,
            Array::Int64(_) => Kind::Int64,
            Array::Half(_) => Kind::Half,
            Array::Float(_) => Kind::Float,
            Array::Double(_) => Kind::Double,
            Array::String(_) => Kind::String,
            Array::Token(_) => Kind::Token,
            Array::Asset(_) => Kind::Asset,
            Array::Float2(_) => Kind::Float2,
            Array::Float3(_) => Kind::Float3,
            Array::Double2(_) => Kind::Double2,
            Array::Double3(_) => Kind::Double3,
            Array::Half3(_) => Kind::Half3,
            Array::Quath(_) => Kind::Quath,
            Array::Quatf(_) => Kind::Quatf,
            Array::Matrix4d(_) => Kind::Matrix4d,
        }
    }
}

/// How values of a type of attributes are stored: the kind, and whether it is an array. `None` for a type that is not known.
pub(crate) fn kind_of_type(name: &str) -> Option<(Kind, bool)> {
    let (one, is_array) = match name.strip_suffix("[]") {
        Some(one) => (one, true),
        None => (name, false),
    };
    let kind = match one {
        "bool" => Kind::Bool,
        "int" => Kind::Int,
        "int64" => Kind::Int64,
        "half" => Kind::Half,
        "float" => Kind::Float,
        "double" => Kind::Double,
        "string" => Kind::String,
        "token" => Kind::Token,
        "asset" => Kind::Asset,
        "float2" | "texCoord2f" => Kind::Float2,
        "float3" | "point3f" | "normal3f" | "vector3f" | "color3f" => Kind::Float3,
        "double2" | "texCoord2d" => Kind::Double2,
        "double3" | "point3d" | "normal3d" | "vector3d" | "color3d" => Kind::Double3,
        "half3" | "point3h" | "normal3h" | "vector3h" | "color3h" => Kind::Half3,
        "quath" => Kind::Quath,
        "quatf" => Kind::Quatf,
        "matrix4d" | "frame4d" => Kind::Matrix4d,
        _ => return None,
    };
    Some((kind, is_array))
}
