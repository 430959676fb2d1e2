//! The language that tables of keys are written in. From one table come the checks, the defaults, the messages,
//! the JSON schema and the lists of keys in `docs/scene.md`.

/// The keys of one kind of table.
#[derive(Debug)]
pub(crate) struct Spec {
    /// What it is called in messages and in the manual; for one of [`Kinds`], the word that chooses it.
    pub(crate) name: &'static str,
    pub(crate) about: &'static str,
    /// TOML that people can begin with.
    pub(crate) example: &'static str,
    /// Keys, in groups that several tables share.
    pub(crate) groups: &'static [&'static [Key]],
}

/// One key.
#[derive(Debug)]
pub(crate) struct Key {
    pub(crate) name: &'static str,
    pub(crate) ty: Ty,
    pub(crate) fallback: Fallback,
    /// Unit and meaning.
    pub(crate) about: &'static str,
}

/// What holds where a key is missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fallback {
    /// It may not be missing.
    Required,
    /// Nothing; `about` says what that means.
    Absent,
    /// This value, in TOML.
    Default(&'static str),
}

/// The type of a value.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Ty {
    Bool,
    Text,
    /// A whole number, bounds included.
    Int(u64, u64),
    Number(Range),
    /// A list of numbers; its length is one of these, or any where there are none.
    Numbers(&'static [usize], Range),
    /// A list of so many whole numbers, bounds included.
    Ints(usize, u64, u64),
    /// [smallest, largest].
    Interval(Range),
    /// [smallest, largest], whole numbers.
    IntInterval(u64, u64),
    Choice(&'static [&'static str]),
    /// A list of different words.
    Choices(&'static [&'static str]),
    Texts,
    /// A list of [x, y, z].
    Points,
    /// A list of [i, j, k].
    Triangles,
    Rotation,
    /// Name of a shape.
    Shape,
    /// Name of a shape, or a list of them.
    Shapes,
    /// Name of a material.
    Material,
    /// `#rrggbb`.
    Color,
    Table(&'static Spec),
    /// A table whose key `kind` says which keys it has.
    Kinds(&'static Kinds),
    /// Tables under names that the user chooses.
    Named(&'static Ty),
    /// A list of tables.
    List(&'static Ty),
}

/// A choice between tables by their key `kind`.
#[derive(Debug)]
pub(crate) struct Kinds {
    /// "shape", for messages.
    pub(crate) name: &'static str,
    /// The kind where none is given, if there is one.
    pub(crate) default: Option<&'static str>,
    pub(crate) cases: &'static [&'static Spec],
}

/// Numbers that are allowed; all must be finite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Range {
    pub(crate) min: f64,
    pub(crate) max: f64,
}

/// The largest number that a scene may hold; in single precision products of three of them are still finite.
pub(crate) const LARGEST: f64 = 1e9;
/// The smallest number where zero is not allowed.
pub(crate) const SMALLEST: f64 = 1e-6;

pub(crate) const ANY: Range = Range { min: -LARGEST, max: LARGEST };
pub(crate) const POSITIVE: Range = Range { min: SMALLEST, max: LARGEST };
pub(crate) const NOT_NEGATIVE: Range = Range { min: 0.0, max: LARGEST };
pub(crate) const SHARE: Range = Range { min: 0.0, max: 1.0 };

impl Spec {
    pub(crate) fn key(&self, name: &str) -> Option<&'static Key> {
        self.keys().find(|k| k.name == name)
    }

    pub(crate) fn keys(&self) -> impl Iterator<Item = &'static Key> {
        self.groups.iter().copied().flatten()
    }
}

impl Range {
    /// Whether `x` may stand here.
    pub(crate) fn holds(&self, x: f64) -> bool {
        (self.min..=self.max).contains(&x)
    }

    /// The rest of "a number …".
    fn limits(&self) -> String {
        match *self {
            ANY => String::new(),
            POSITIVE => " greater than 0".to_owned(),
            NOT_NEGATIVE => " of at least 0".to_owned(),
            Range { min, max } => format!(" from {min} to {max}"),
        }
    }

    /// The exact limits, for a number that fits the short words but not the range.
    pub(crate) fn exact(&self) -> String {
        format!("from {:e} to {:e}", self.min, self.max)
    }
}

/// `a`, `b` or `c`.
pub(crate) fn one_of<'a>(words: impl IntoIterator<Item = &'a str>) -> String {
    let words: Vec<String> = words.into_iter().map(|w| format!("`{w}`")).collect();
    match words.split_last() {
        None => "nothing".to_owned(),
        Some((only, [])) => only.clone(),
        Some((last, rest)) => format!("{} or {last}", rest.join(", ")),
    }
}

impl Ty {
    /// What a value of this type is, in words that follow "expected".
    pub(crate) fn expected(&self) -> String {
        let int = |min: u64, max: u64| match (min, max) {
            (0, u64::MAX) => "a whole number of at least 0".to_owned(),
            (min, max) => format!("a whole number from {min} to {max}"),
        };
        match *self {
            Ty::Bool => "true or false".to_owned(),
            Ty::Text => "a text in quotes".to_owned(),
            Ty::Int(min, max) => int(min, max),
            Ty::Number(range) => format!("a number{}", range.limits()),
            Ty::Numbers([], range) => format!("a list of numbers{}", range.limits()),
            Ty::Numbers(lengths, range) => {
                let lengths: Vec<String> = lengths.iter().map(usize::to_string).collect();
                format!("a list of {} numbers{}", lengths.join(" or "), range.limits())
            }
            Ty::Ints(n, min, max) => {
                format!("a list of {n} whole numbers from {min} to {max}")
            }
            Ty::Interval(range) => format!("[smallest, largest], two numbers{}", range.limits()),
            Ty::IntInterval(min, max) => {
                format!("[smallest, largest], two whole numbers from {min} to {max}")
            }
            Ty::Choice(words) => one_of(words.iter().copied()),
            Ty::Choices(words) => format!("a list of {}", one_of(words.iter().copied())),
            Ty::Texts => "a list of texts in quotes".to_owned(),
            Ty::Points => "a list of points [x, y, z]".to_owned(),
            Ty::Triangles => "a list of triangles [i, j, k]".to_owned(),
            Ty::Rotation => {
                "[x, y, z] in degrees, a quaternion [x, y, z, w], or { axis, degrees }".to_owned()
            }
            Ty::Shape => "the name of a shape".to_owned(),
            Ty::Shapes => "the name of a shape, or a list of names".to_owned(),
            Ty::Material => "the name of a material".to_owned(),
            Ty::Color => "a colour as \"#rrggbb\"".to_owned(),
            Ty::Table(spec) => format!("a table with {}", one_of(spec.keys().map(|k| k.name))),
            Ty::Kinds(kinds) => format!("a table that describes a {}", kinds.name),
            Ty::Named(ty) => match ty {
                Ty::Kinds(kinds) => format!("tables, one for each {}", kinds.name),
                Ty::Table(spec) => format!("tables, one for each {}", spec.name),
                _ => "tables".to_owned(),
            },
            Ty::List(_) => "a list of tables".to_owned(),
        }
    }
}

/// Shorthand for tables of keys.
pub(crate) const fn required(name: &'static str, ty: Ty, about: &'static str) -> Key {
    Key { name, ty, fallback: Fallback::Required, about }
}

/// Shorthand for tables of keys.
pub(crate) const fn optional(name: &'static str, ty: Ty, about: &'static str) -> Key {
    Key { name, ty, fallback: Fallback::Absent, about }
}

/// Shorthand for tables of keys.
pub(crate) const fn key(name: &'static str, ty: Ty, default: &'static str, about: &'static str) -> Key {
    Key { name, ty, fallback: Fallback::Default(default), about }
}
