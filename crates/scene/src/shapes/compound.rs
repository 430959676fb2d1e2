//! Compounds: shapes of the scene, put together.

use super::{Cook, ShapeKind, failed, kind_of, nothing_to_check, one};
use crate::body;
use crate::error::Problem;
use crate::node::Table;
use crate::spec::{ANY, Spec, Ty, key, required};
use crate::visual::LOOK;
use rockfall::Shape;
use rockfall_shape::Compound;
use std::collections::BTreeMap;
use std::sync::Arc;

pub(super) static COMPOUND_KEYS: Spec = Spec {
    name: "compound",
    about: "Shapes at fixed places that move as one. They may overlap; what overlaps is as heavy as if it were there twice. \
            With a mesh as a part, bodies of it are static unless their `kind` says otherwise, and can't be dynamic where the mesh is open. \
            Half-spaces and height fields, which have no end, can't be parts.",
    example: r#"[shapes.head]
kind = "box"
size = [0.3, 0.12, 0.12]

[shapes.handle]
kind = "cylinder"
radius = 0.03
length = 0.8

[shapes.hammer]
kind = "compound"
parts = [{ shape = "head", position = [0, 0, 0.4] }, { shape = "handle" }]
"#,
    groups: &[
        &[required("parts", Ty::List(&Ty::Table(&PART)), "At least one. Each is a table, see below.")],
        LOOK,
    ],
};

pub(crate) static PART: Spec = Spec {
    name: "part",
    about: "One of the `parts` of a compound.",
    example: r#"parts = [{ shape = "head", position = [0, 0, 0.4], rotation = [0, 0, 90] }]
"#,
    groups: &[&[
        required("shape", Ty::Shape, "Name of a shape, which may be a compound itself."),
        key("member", Ty::Int(0, 0xffff_ffff), "0", "Which one of a family of shapes, counted from 0."),
        key("position", Ty::Numbers(&[3], ANY), "[0, 0, 0]", "Where its origin is in the compound, m."),
        key("rotation", Ty::Rotation, "[0, 0, 0]", "How it is turned; forms as for bodies."),
    ]],
};

pub(super) static COMPOUND: ShapeKind = ShapeKind {
    spec: &COMPOUND_KEYS,
    immovable: false,
    ground: false,
    members: one,
    memory: |table| 512 * parts_of(table).count() as u64,
    check: nothing_to_check,
    cook: |table, context| Ok(vec![cook(table, context)?]),
};

/// Compounds in compounds in compounds.
const DEEPEST: usize = 32;
/// Parts of one compound, those of its compounds counted one by one.
const MOST: u64 = 1_000_000;

/// The parts of a shape; none of what is no compound.
pub(crate) fn parts_of(table: &Table) -> impl Iterator<Item = &Table> {
    let parts = table.spec.key("parts").map(|_| table.tables("parts"));
    parts.into_iter().flatten()
}

fn cook(table: &Table, context: &Cook<'_>) -> Result<Shape, Problem> {
    let part = |part: &Table| {
        let shape = context.member(part.text("shape"), part.int("member") as usize);
        let none = || Problem::at(part.span, format!("`{}` uses no shape", part.path));
        Ok((shape.ok_or_else(none)?, body::pose(part)?))
    };
    let parts = parts_of(table).map(part).collect::<Result<Vec<_>, Problem>>()?;
    let compound = Compound::new(parts).map_err(|e| failed(table, "parts", e))?;
    Ok(Shape::Compound(Arc::new(compound)))
}

/// What is known of shapes that other shapes name, and so not from their tables alone.
#[derive(Default)]
pub(crate) struct Nesting {
    known: BTreeMap<String, Known>,
}

#[derive(Clone, Copy, Default)]
struct Known {
    /// Parts that are no compounds; 1 of what is no compound.
    count: u64,
    /// No body of it can be dynamic.
    immovable: bool,
    /// Bodies of it are static unless they say otherwise.
    ground: bool,
}

impl Nesting {
    /// Looks through all shapes of a scene. Compounds must come to an end, not be too large, and name members that are there; the
    /// first that does not is a problem, and nothing is known of it.
    pub(crate) fn read(root: &Table) -> (Self, Option<Problem>) {
        let shapes: BTreeMap<&str, &Table> = root.named("shapes").collect();
        let mut nesting = Nesting::default();
        let problem =
            root.named("shapes").find_map(|(name, _)| nesting.look(name, &shapes, &mut Vec::new()).err());
        (nesting, problem)
    }

    /// Whether no body of a shape can be dynamic.
    pub(crate) fn is_immovable(&self, shape: &str) -> bool {
        self.known.get(shape).is_some_and(|known| known.immovable)
    }

    /// Whether bodies of a shape are static unless they say otherwise.
    pub(crate) fn is_ground(&self, shape: &str) -> bool {
        self.known.get(shape).is_some_and(|known| known.ground)
    }

    /// Looks at a shape; `chain` leads to it. What does not exist is somebody else's problem.
    fn look<'a>(
        &mut self,
        name: &'a str,
        shapes: &BTreeMap<&'a str, &'a Table>,
        chain: &mut Vec<&'a str>,
    ) -> Result<Known, Problem> {
        let Some(table) = shapes.get(name).copied() else { return Ok(Known::default()) };
        if let Some(&known) = self.known.get(name) {
            return Ok(known);
        }
        let wrong = |message: String| Problem::at(table.span, message);
        if let Some(at) = chain.iter().position(|other| *other == name) {
            let ring: Vec<&str> = chain[at..].iter().copied().chain([name]).collect();
            let message = format!("compounds contain one another: {}", ring.join(" → "));
            return Err(wrong(message).expecting("parts that come to an end"));
        }
        if chain.len() > DEEPEST {
            let message = format!("`{}` is in compounds that are more than {DEEPEST} deep", table.path);
            return Err(wrong(message).expecting("fewer compounds in compounds"));
        }
        chain.push(name);
        let ShapeKind { immovable, ground, .. } = *kind_of(table);
        let mut all = Known { count: 0, immovable, ground };
        for part in parts_of(table) {
            let inner = part.text("shape");
            let known = self.look(inner, shapes, chain)?;
            all.count = all.count.saturating_add(known.count);
            all.immovable |= known.immovable;
            all.ground |= known.ground;
            let members = shapes.get(inner).map_or(u64::MAX, |shape| (kind_of(shape).members)(shape));
            if part.int("member") >= members {
                let message = format!("`{}` is {}", part.path_of("member"), part.int("member"));
                let expected = format!("less than {members}, the number of shapes in `{inner}`");
                return Err(Problem::at(part.span_of("member"), message).expecting(expected));
            }
        }
        chain.pop();
        if all.count > MOST {
            let message =
                format!("`{}` has {} parts, those of its compounds included", table.path, all.count);
            return Err(wrong(message).expecting(format!("at most {MOST}")));
        }
        if table.spec.key("parts").is_none() {
            all.count = 1;
        }
        self.known.insert(name.to_owned(), all);
        Ok(all)
    }
}
