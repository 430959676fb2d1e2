//! Shapes: from their tables to geometry. A table makes one shape, or a family of them.

mod boulders;
mod boxes;
mod compound;
mod decomposition;
mod field;
mod height_field;
mod hull;
mod mesh;
mod round;
mod rounded;

use crate::error::Problem;
use crate::node::Table;
use crate::spec::{Kinds, Spec};
use rockfall::Shape;
use rockfall_math::{Pose, Vec3};
use rockfall_shape::{Compound, Hull, Mesh, MeshReport, Part};
use std::collections::BTreeMap;
use std::sync::Arc;

pub(crate) use compound::{Nesting, PART, parts_of};
pub(crate) use decomposition::{cook as cook_decomposition, is_decomposition};
pub(crate) use field::folder as field_folder;
pub(crate) use hull::cook as cook_hull;

/// One kind of shape. To add one, copy the file of a neighbour and add it to [`KINDS`] and [`SHAPES`].
#[derive(Debug)]
pub(crate) struct ShapeKind {
    pub(crate) spec: &'static Spec,
    /// It has no inside, so that it can't be dynamic.
    pub(crate) immovable: bool,
    /// Bodies of it are static unless they say otherwise.
    pub(crate) ground: bool,
    /// Shapes in its family.
    pub(crate) members: fn(&Table) -> u64,
    /// Rough size in memory, bytes, from the table alone.
    pub(crate) memory: fn(&Table) -> u64,
    /// What the types of its keys can't say.
    pub(crate) check: fn(&Table) -> Result<(), Problem>,
    pub(crate) cook: fn(&Table, &Cook<'_>) -> Result<Vec<Shape>, Problem>,
}

/// What cooking may need besides the table.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cook<'a> {
    pub(crate) seed: u64,
    root: &'a Table,
    /// Families that are cooked, by their place in the file; those of the parts of a compound are among them.
    families: &'a BTreeMap<usize, Vec<Shape>>,
}

impl<'a> Cook<'a> {
    pub(crate) fn new(seed: u64, root: &'a Table, families: &'a BTreeMap<usize, Vec<Shape>>) -> Self {
        Cook { seed, root, families }
    }

    /// A shape by its name and its number in the family.
    fn member(&self, name: &str, member: usize) -> Option<Shape> {
        let index = self.root.named("shapes").position(|(n, _)| n == name)?;
        self.families.get(&index)?.get(member).cloned()
    }
}

static KINDS: [&ShapeKind; 17] = [
    &round::SPHERE,
    &round::BOX,
    &round::CAPSULE,
    &round::CYLINDER,
    &round::CONE,
    &round::ELLIPSOID,
    &rounded::ROUNDED_BOX,
    &hull::HULL,
    &rounded::ROUNDED_HULL,
    &round::HALF_SPACE,
    &mesh::MESH,
    &field::FIELD,
    &height_field::HEIGHT_FIELD,
    &compound::COMPOUND,
    &decomposition::DECOMPOSITION,
    &boulders::BOULDERS,
    &boxes::BOXES,
];

pub(crate) static SHAPES: Kinds = Kinds {
    name: "shape",
    default: None,
    cases: &[
        &round::SPHERE_KEYS,
        &round::BOX_KEYS,
        &round::CAPSULE_KEYS,
        &round::CYLINDER_KEYS,
        &round::CONE_KEYS,
        &round::ELLIPSOID_KEYS,
        &rounded::ROUNDED_BOX_KEYS,
        &hull::HULL_KEYS,
        &rounded::ROUNDED_HULL_KEYS,
        &round::HALF_SPACE_KEYS,
        &mesh::MESH_KEYS,
        &field::FIELD_KEYS,
        &height_field::HEIGHT_FIELD_KEYS,
        &compound::COMPOUND_KEYS,
        &decomposition::DECOMPOSITION_KEYS,
        &boulders::BOULDERS_KEYS,
        &boxes::BOXES_KEYS,
    ],
};

/// The kind of a shape's table.
pub(crate) fn kind_of(table: &Table) -> &'static ShapeKind {
    KINDS.iter().copied().find(|k| std::ptr::eq(k.spec, table.spec)).unwrap_or(&round::SPHERE)
}

/// For kinds that make one shape.
fn one(_: &Table) -> u64 {
    1
}

/// For kinds whose keys say everything.
fn nothing_to_check(_: &Table) -> Result<(), Problem> {
    Ok(())
}

/// For shapes without tables of their own.
fn small(_: &Table) -> u64 {
    256
}

/// The one of `keys` that is given.
fn only_one_of(table: &Table, keys: &[&'static str]) -> Result<&'static str, Problem> {
    let given: Vec<&'static str> = keys.iter().copied().filter(|k| table.has(k)).collect();
    let expected = crate::spec::one_of(keys.iter().copied());
    match given[..] {
        [one] => Ok(one),
        [] => {
            let message = format!("`{}` does not say where its geometry comes from", table.path);
            Err(Problem::at(table.span, message).expecting(expected))
        }
        [first, second, ..] => {
            let message = format!("`{}` has both `{first}` and `{second}`", table.path);
            Err(Problem::at(table.span_of(second), message).expecting(format!("only one of {expected}")))
        }
    }
}

/// Something went wrong with what a key gives.
pub(crate) fn failed(table: &Table, key: &str, why: impl std::fmt::Display) -> Problem {
    Problem::at(table.span_of(key), format!("`{}`: {why}", table.path_of(key)))
}

/// A ball around a shape: its centre in the shape's frame and its radius; none for what has no end.
pub(crate) fn bounding_ball(shape: &Shape) -> Option<(Vec3, f32)> {
    Some(match shape {
        Shape::Sphere { radius } => (Vec3::ZERO, *radius),
        Shape::Box { half } => (Vec3::ZERO, half.length()),
        Shape::Capsule { half_length, radius } => (Vec3::ZERO, half_length + radius),
        Shape::Cylinder { .. } | Shape::Cone { .. } | Shape::Ellipsoid { .. } | Shape::RoundedBox { .. } => {
            (Vec3::ZERO, shape.radius_about(Vec3::ZERO))
        }
        Shape::Hull(hull) | Shape::RoundedHull { hull, .. } => (hull.center, shape.radius_about(hull.center)),
        Shape::Field(_) | Shape::Mesh(_) | Shape::Compound(_) => {
            let center = shape.bounds().center();
            (center, shape.radius_about(center))
        }
        Shape::HalfSpace { .. } | Shape::HeightField(_) => return None,
    })
}

/// A shape at another size.
///
/// # Errors
/// What hull and mesh cooking say of the scaled corners.
pub(crate) fn scaled(shape: &Shape, by: f32) -> Result<Shape, String> {
    Ok(match shape {
        Shape::Sphere { radius } => Shape::Sphere { radius: radius * by },
        Shape::Box { half } => Shape::Box { half: *half * by },
        Shape::Capsule { half_length, radius } => {
            Shape::Capsule { half_length: half_length * by, radius: radius * by }
        }
        Shape::Cylinder { half_length, radius } => {
            Shape::Cylinder { half_length: half_length * by, radius: radius * by }
        }
        Shape::Cone { half_length, lower, upper } => {
            Shape::Cone { half_length: half_length * by, lower: lower * by, upper: upper * by }
        }
        Shape::Ellipsoid { half } => Shape::Ellipsoid { half: *half * by },
        Shape::RoundedBox { half, radius } => Shape::RoundedBox { half: *half * by, radius: radius * by },
        Shape::Hull(hull) if by != 1.0 => Shape::Hull(scaled_hull(hull, by)?),
        Shape::RoundedHull { hull, radius } if by != 1.0 => {
            Shape::RoundedHull { hull: scaled_hull(hull, by)?, radius: radius * by }
        }
        Shape::Compound(compound) if by != 1.0 => {
            let part = |part: &Part| {
                let pose = Pose { position: part.pose.position * f64::from(by), ..part.pose };
                Ok((scaled(&part.shape, by)?, pose))
            };
            let parts = compound.parts().iter().map(part).collect::<Result<Vec<_>, String>>()?;
            let whole = Compound::new(parts).map_err(|e| e.to_string())?;
            Shape::Compound(Arc::new(match compound.solid() {
                Some(solid) => whole.standing_for(solid.scaled(by)),
                None => whole,
            }))
        }
        Shape::Field(field) if by != 1.0 => {
            Shape::Field(Arc::new(field.scaled(by).map_err(|e| e.to_string())?))
        }
        Shape::Mesh(mesh) if by != 1.0 => {
            let corners: Vec<Vec3> = mesh.vertices.iter().map(|v| *v * by).collect();
            Shape::Mesh(Arc::new(Mesh::from_triangles(&corners, &mesh.triangles).map_err(|e| e.to_string())?))
        }
        other => other.clone(),
    })
}

/// What keeps a shape that was cooked from being dynamic, as in "the shape is …".
pub(crate) fn why_immovable(shape: &Shape) -> Option<String> {
    match shape {
        _ if shape.can_move() => None,
        Shape::Compound(compound) => {
            let parts = compound.parts().iter().map(|part| why_immovable(&part.shape));
            parts
                .zip(1..)
                .find_map(|(why, number)| Some(format!("a compound whose part {number} is {}", why?)))
        }
        Shape::Mesh(mesh) if mesh.closed => Some("a mesh that is inside out".to_owned()),
        Shape::Mesh(mesh) => {
            let MeshReport { open_edges, tangled_edges, .. } = mesh.report;
            Some(format!(
                "a mesh that is not closed: {open_edges} edges have one triangle, and at {tangled_edges} triangles don't go on in one way"
            ))
        }
        _ => Some(format!("a {}", shape.name())),
    }
}

fn scaled_hull(hull: &Hull, by: f32) -> Result<Arc<Hull>, String> {
    let corners: Vec<Vec3> = hull.vertices.iter().map(|v| *v * by).collect();
    hull::cook(&corners, corners.len()).map_err(|e| e.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_is_in_both_lists() {
        assert_eq!(KINDS.len(), SHAPES.cases.len());
        for (kind, spec) in KINDS.iter().zip(SHAPES.cases) {
            assert!(std::ptr::eq(kind.spec, *spec), "{}", spec.name);
        }
    }
}
