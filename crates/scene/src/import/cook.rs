//! From the geometry of files to shapes.

use crate::error::Problem;
use crate::node::Table;
use crate::shapes::{cook_hull, field_folder};
use rockfall::Shape;
use rockfall_decompose::{Options, decompose};
use rockfall_import::mesh_file::TriangleSoup;
use rockfall_import::{Content, Geometry};
use rockfall_math::Vec3;
use rockfall_shape::{Compound, Field, FieldSettings, MassProperties, Mesh};
use std::sync::Arc;

/// Corners of a hull, as in scene files.
const HULL_CORNERS: usize = 64;

/// A shape, and the mass of each of its parts at 1 kg/m³, where they have an inside.
pub(super) struct Cooked {
    pub(super) shape: Shape,
    pub(super) parts: Vec<Option<MassProperties>>,
}

/// Cooks all shapes of a file, in their order; each geometry once.
pub(super) fn shapes(content: &Content, table: &Table) -> Result<Vec<Cooked>, Problem> {
    let mut geometries = Vec::with_capacity(content.geometries.len());
    for (index, geometry) in content.geometries.iter().enumerate() {
        let cooked = cook(geometry).and_then(|shape| match shape.validate() {
            Ok(()) => Ok(shape),
            Err(why) => Err(why.to_string()),
        });
        geometries.push(cooked.map_err(|why| {
            let uses =
                |parts: &Vec<rockfall_import::Part>| parts.iter().any(|p| p.geometry as usize == index);
            let shape = content.shapes.iter().position(uses).unwrap_or_default();
            name(Problem::at(table.span_of("file"), why), content, shape as u32)
        })?);
    }
    let shape = |(index, parts): (usize, &Vec<rockfall_import::Part>)| {
        let masses = |geometry: u32| geometries[geometry as usize].mass_properties(1.0);
        let shape = match &parts[..] {
            [part] => geometries[part.geometry as usize].clone(),
            parts => {
                let placed = parts.iter().map(|part| (geometries[part.geometry as usize].clone(), part.pose));
                let compound = Compound::new(placed).map_err(|why| {
                    let problem = Problem::at(table.span_of("file"), why.to_string());
                    name(problem, content, index as u32)
                })?;
                Shape::Compound(Arc::new(compound))
            }
        };
        Ok(Cooked { shape, parts: parts.iter().map(|part| masses(part.geometry)).collect() })
    };
    content.shapes.iter().enumerate().map(shape).collect()
}

/// The problem with the name of the first body that has the shape.
pub(super) fn name(problem: Problem, content: &Content, shape: u32) -> Problem {
    let body = content.bodies.iter().find(|body| body.shape == shape);
    problem.about(body.map_or("", |body| body.name.as_str()))
}

fn cook(geometry: &Geometry) -> Result<Shape, String> {
    let mesh = |soup: &TriangleSoup| {
        Mesh::from_triangles(&soup.vertices, &soup.triangles).map(Arc::new).map_err(|why| why.to_string())
    };
    Ok(match geometry {
        Geometry::Sphere { radius } => Shape::Sphere { radius: *radius },
        Geometry::Box { half } => Shape::Box { half: *half },
        Geometry::Ellipsoid { half } => Shape::Ellipsoid { half: *half },
        Geometry::Capsule { half_length, radius } => {
            Shape::Capsule { half_length: *half_length, radius: *radius }
        }
        Geometry::Cone { half_length, lower, upper } if lower == upper => {
            Shape::Cylinder { half_length: *half_length, radius: *lower }
        }
        Geometry::Cone { half_length, lower, upper } => {
            Shape::Cone { half_length: *half_length, lower: *lower, upper: *upper }
        }
        Geometry::HalfSpace => Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 },
        Geometry::Hull(points) => {
            Shape::Hull(cook_hull(points, HULL_CORNERS).map_err(|why| why.to_string())?)
        }
        Geometry::Mesh(soup) => Shape::Mesh(mesh(soup)?),
        Geometry::Decomposition { soup, max_hulls } => {
            let most = max_hulls.unwrap_or(Options::default().max_hulls);
            let options = Options { max_hulls: most, ..Options::default() };
            let cut = decompose(&*mesh(soup)?, &options).map_err(|why| why.to_string())?;
            Shape::Compound(Arc::new(cut.compound))
        }
        Geometry::Field { soup, resolution } => {
            let mesh = mesh(soup)?;
            let (low, high) = (
                mesh.vertices.iter().copied().reduce(Vec3::min),
                mesh.vertices.iter().copied().reduce(Vec3::max),
            );
            let longest = (high.unwrap_or_default() - low.unwrap_or_default()).max_element();
            let settings = FieldSettings::with_error(longest / *resolution as f32);
            let field = match field_folder() {
                Some(folder) => Field::cached(mesh, settings, &folder).map(|(field, _)| field),
                None => Field::new(mesh, settings),
            };
            Shape::Field(Arc::new(field.map_err(|why| why.to_string())?))
        }
    })
}

/// Rough size of a shape in memory, bytes.
pub(super) fn memory(geometry: &Geometry) -> u64 {
    match geometry {
        Geometry::Hull(_) => 16 << 10,
        Geometry::Mesh(soup) => 160 * soup.triangles.len() as u64,
        Geometry::Decomposition { max_hulls, .. } => (16 << 10) * u64::from(max_hulls.unwrap_or(32)),
        Geometry::Field { .. } => 4 << 20,
        _ => 256,
    }
}
