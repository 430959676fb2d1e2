//! The triangles of bodies, each where it is. They are made while they are written, since they may take far more memory than the bodies.

use super::bodies::{XYZ, speeds};
use super::file::{Array, Cells, Number, PolyData};
use crate::prototypes::Prototypes;
use crate::{Inventory, Moment, Run, Surface};
use bytemuck::NoUninit;
use rockfall_math::{DVec3, Quat, Vec3, rotation};
use std::io::{self, Write};
use std::sync::Arc;

/// A body to be drawn.
#[derive(Clone, Copy)]
struct Placed<'a> {
    surface: &'a Surface,
    position: Vec3,
    rotation: Quat,
}

/// The bodies of a moment, whose shapes are all among the prototypes. Of these all have normals, or none.
pub(super) fn of<'a>(
    run: &'a Run,
    inventory: &'a Inventory,
    prototypes: &'a Prototypes,
    moment: &'a Moment,
) -> PolyData<'a> {
    let poses = moment.rows.iter().zip(moment.positions.iter().zip(&moment.rotations));
    let placed = |(&row, (position, rotation)): (&u32, (&[f32; 3], &[f32; 4]))| {
        let surface = prototypes.get(inventory.shape_of[row as usize])?;
        Some(Placed { surface, position: Vec3::from_array(*position), rotation: Quat::from_array(*rotation) })
    };
    let placed: Arc<[Placed<'a>]> = poses.filter_map(placed).collect();
    let rows = || moment.rows.iter().map(|&row| row as usize);
    let mut of_cells = vec![
        repeated::<u64, _>("id", &[], &placed, rows().map(|row| run.bodies().ids[row]).collect()),
        repeated::<u32, _>("shape", &[], &placed, rows().map(|row| inventory.shape_of[row]).collect()),
        repeated::<u32, _>("material", &[], &placed, rows().map(|row| inventory.material_of[row]).collect()),
    ];
    if !moment.velocities.is_empty() {
        of_cells.push(repeated::<f32, _>("velocity", XYZ, &placed, moment.velocities.clone()));
        of_cells.push(repeated::<f32, _>("speed", &[], &placed, speeds(moment)));
    }
    assemble(moment.time, run.origin(), placed, of_cells)
}

/// A shape in its own frame.
pub(super) fn prototype(surface: &Surface) -> PolyData<'_> {
    let placed = [Placed { surface, position: Vec3::ZERO, rotation: Quat::IDENTITY }];
    assemble(f64::NAN, DVec3::ZERO, Arc::new(placed), Vec::new())
}

fn assemble<'a>(
    time: f64,
    origin: DVec3,
    placed: Arc<[Placed<'a>]>,
    of_cells: Vec<Array<'a>>,
) -> PolyData<'a> {
    let sum = |of: fn(&Surface) -> usize| placed.iter().map(|body| of(body.surface) as u64).sum::<u64>();
    let (points, triangles) =
        (sum(|surface| surface.positions.len()), sum(|surface| surface.triangles.len()));
    let normals = placed.iter().any(|body| !body.surface.normals.is_empty());
    let of_points = normals.then(|| {
        each::<f32, _>("Normals", 3 * points, &placed, |body, out| {
            let turned = |n: &Vec3| rotation::rotate(body.rotation, *n).to_array();
            out.extend(body.surface.normals.iter().map(turned));
        })
    });
    PolyData {
        time,
        count: points,
        points: places(origin, points, &placed),
        vertices: None,
        polygons: Some(cells(triangles, &placed)),
        of_points: of_points.into_iter().collect(),
        of_cells,
    }
}

/// Where the corners are: in double precision where the run's origin is not the world's.
fn places<'a>(origin: DVec3, points: u64, placed: &Arc<[Placed<'a>]>) -> Array<'a> {
    let corner = |body: &Placed<'_>, p: Vec3| body.position + rotation::rotate(body.rotation, p);
    if origin == DVec3::ZERO {
        return each::<f32, _>("Points", 3 * points, placed, move |body, out| {
            out.extend(body.surface.positions.iter().map(|p| corner(body, *p).to_array()));
        });
    }
    each::<f64, _>("Points", 3 * points, placed, move |body, out| {
        let place = |p: &Vec3| (origin + corner(body, *p).as_dvec3()).to_array();
        out.extend(body.surface.positions.iter().map(place));
    })
}

fn cells<'a>(triangles: u64, placed: &Arc<[Placed<'a>]>) -> Cells<'a> {
    let bodies = placed.clone();
    let connectivity = move |to: &mut dyn Write| {
        let (mut first, mut out) = (0, Vec::new());
        for body in bodies.iter() {
            out.extend(body.surface.triangles.iter().map(|t| t.map(|c| first + i64::from(c))));
            to.write_all(bytemuck::cast_slice(&out))?;
            out.clear();
            first += body.surface.positions.len() as i64;
        }
        Ok(())
    };
    let offsets = move |to: &mut dyn Write| {
        (1..=triangles as i64).try_for_each(|cell| to.write_all(&(3 * cell).to_ne_bytes()))
    };
    Cells {
        count: triangles,
        connectivity: Array::streamed::<i64>("connectivity", &[], 3 * triangles, connectivity),
        offsets: Array::streamed::<i64>("offsets", &[], triangles, offsets),
    }
}

/// Vectors that each body adds to.
fn each<'a, T: Number, R: NoUninit>(
    name: &'static str,
    count: u64,
    placed: &Arc<[Placed<'a>]>,
    add: impl Fn(&Placed<'_>, &mut Vec<R>) + 'a,
) -> Array<'a> {
    let bodies = placed.clone();
    Array::streamed::<T>(name, XYZ, count, move |to| {
        let mut out = Vec::new();
        for body in bodies.iter() {
            add(body, &mut out);
            to.write_all(bytemuck::cast_slice(&out))?;
            out.clear();
        }
        Ok(())
    })
}

/// A value of each body for each of its triangles.
fn repeated<'a, T: Number, R: NoUninit + 'a>(
    name: &'static str,
    components: &'static [&'static str],
    placed: &Arc<[Placed<'a>]>,
    values: Vec<R>,
) -> Array<'a> {
    let numbers = (size_of::<R>() / size_of::<T>()) as u64;
    let triangles = placed.iter().map(|body| body.surface.triangles.len() as u64).sum::<u64>();
    let bodies = placed.clone();
    Array::streamed::<T>(name, components, numbers * triangles, move |to: &mut dyn Write| -> io::Result<()> {
        for (body, value) in bodies.iter().zip(&values) {
            let bytes = bytemuck::bytes_of(value);
            body.surface.triangles.iter().try_for_each(|_| to.write_all(bytes))?;
        }
        Ok(())
    })
}
