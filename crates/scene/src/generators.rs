//! Generators: bodies in bulk.

mod container;
mod fill;
mod grid;
mod pour;
mod pyramid;
mod wall;

pub(crate) use pour::Pour;

use crate::error::Problem;
use crate::node::Table;
use crate::plan::Yard;
use crate::shapes::Nesting;
use crate::sizes::SIZES;
use crate::spec::{Key, Kinds, Spec, Ty, key, optional, required};

/// One kind of generator. To add one, copy the file of a neighbour and add it to [`KINDS`] and [`GENERATORS`].
#[derive(Debug)]
pub(crate) struct GeneratorKind {
    pub(crate) spec: &'static Spec,
    /// Bodies that it makes, all in all.
    pub(crate) count: fn(&Table) -> u128,
    /// What the types of its keys can't say.
    pub(crate) check: fn(&Table) -> Result<(), Problem>,
    /// Makes the bodies. The label names the generator for the random numbers.
    pub(crate) place: fn(&Table, &str, &mut Yard<'_>) -> Result<(), Problem>,
}

static KINDS: [&GeneratorKind; 6] =
    [&grid::GRID, &wall::WALL, &pyramid::PYRAMID, &fill::FILL, &pour::POUR, &container::CONTAINER];

pub(crate) static GENERATORS: Kinds = Kinds {
    name: "generator",
    default: None,
    cases: &[
        &grid::GRID_KEYS,
        &wall::WALL_KEYS,
        &pyramid::PYRAMID_KEYS,
        &fill::FILL_KEYS,
        &pour::POUR_KEYS,
        &container::CONTAINER_KEYS,
    ],
};

/// Which shapes a generator uses, and how large.
const SHAPED: &[Key] = &[
    required(
        "shape",
        Ty::Shapes,
        "Name of the shape or family of shapes; of several names each body takes one at random.",
    ),
    optional(
        "size",
        Ty::Table(&SIZES),
        "Random sizes. All bodies keep the size of their shape where not given.",
    ),
];

/// How the bodies of a fill or a pour are turned.
const TURNED: &[Key] = &[
    key(
        "orientation",
        Ty::Choice(&["random", "fixed"]),
        "\"random\"",
        "Each body its own, or all as `rotation`.",
    ),
    key(
        "rotation",
        Ty::Rotation,
        "[0, 0, 0]",
        "Of all bodies where `orientation` is `fixed`; forms as for bodies.",
    ),
];

/// The kind of a generator's table.
pub(crate) fn kind_of(table: &Table) -> &'static GeneratorKind {
    KINDS.iter().copied().find(|k| std::ptr::eq(k.spec, table.spec)).unwrap_or(&grid::GRID)
}

/// Checks a generator; `root` is the whole scene, `nesting` what is known of its shapes.
pub(crate) fn check(table: &Table, root: &Table, nesting: &Nesting) -> Result<(), Problem> {
    (kind_of(table).check)(table)?;
    if let Some(size) = table.spec.key("size").and_then(|_| table.table("size"))
        && size.f64("min") > size.f64("max")
    {
        let message = format!("`{}` is larger than `max`", size.path_of("min"));
        return Err(Problem::at(size.span_of("min"), message).expecting("at most `max`"));
    }
    if table.spec.key("rotation").is_some() {
        crate::rotation::read(table, "rotation")?;
    }
    let Some(shape) = table.spec.key("shape").and_then(|_| table.node("shape")) else { return Ok(()) };
    let names = if shape.value.list().is_empty() { std::slice::from_ref(shape) } else { shape.value.list() };
    for name in names {
        let found = root.named("shapes").find(|(n, _)| *n == name.value.text());
        if let Some((_, found)) = found
            && nesting.is_immovable(name.value.text())
        {
            let kind = found.spec.name;
            let message = format!("`{}` makes dynamic bodies, but the shape is a {kind}", table.path);
            return Err(Problem::at(name.span, message).expecting("a shape with an inside"));
        }
    }
    Ok(())
}

fn nothing_to_check(_: &Table) -> Result<(), Problem> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_in_both_lists() {
        assert_eq!(KINDS.len(), GENERATORS.cases.len());
        for (kind, spec) in KINDS.iter().zip(GENERATORS.cases) {
            assert!(std::ptr::eq(kind.spec, *spec), "{}", spec.name);
        }
    }
}
