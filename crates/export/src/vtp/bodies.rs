//! A point for each body.

use super::file::{Array, Cells, PolyData};
use crate::{Inventory, Moment, Run, prototypes};
use rockfall_cache::Values;
use rockfall_math::{DVec3, Vec3};
use std::borrow::Cow;

/// Names of the components of vectors.
pub(super) const XYZ: &[&str] = &["x", "y", "z"];

/// The bodies of a moment, with all that is known of them. Their order is that of ids.
pub(super) fn of<'a>(run: &'a Run, inventory: &'a Inventory, moment: &'a Moment) -> PolyData<'a> {
    let count = moment.rows.len() as u64;
    let rows = || moment.rows.iter().map(|&row| row as usize);
    let table = run.bodies();
    // ParaView wants the real part first.
    let turned = |&[x, y, z, w]: &[f32; 4]| [w, x, y, z];
    let size = |row: usize| prototypes::size(&inventory.shapes[inventory.shape_of[row] as usize]).to_array();
    let mut of_points = vec![
        Array::new::<u64, _>("id", &[], rows().map(|row| table.ids[row]).collect()),
        Array::new::<u32, _>("shape", &[], rows().map(|row| inventory.shape_of[row]).collect()),
        Array::new::<u32, _>("material", &[], rows().map(|row| inventory.material_of[row]).collect()),
        Array::new::<f32, _>("scale", &[], rows().map(|row| table.scales[row]).collect()),
        Array::new::<f32, _>("size", XYZ, rows().map(size).collect()),
        Array::new::<f32, _>(
            "orientation",
            &["w", "x", "y", "z"],
            moment.rotations.iter().map(turned).collect(),
        ),
        Array::new::<f32, _>("velocity", XYZ, moment.velocities.clone()),
        Array::new::<f32, _>("speed", &[], speeds(moment)),
        Array::new::<f32, _>("angular_velocity", XYZ, moment.spins.clone()),
    ];
    for (column, values) in run.columns().iter().zip(&moment.columns) {
        // A name can't be there twice.
        let name: Cow<'_, str> = match of_points.iter().any(|array| array.name() == column.name) {
            true => format!("run_{}", column.name).into(),
            false => column.name.as_str().into(),
        };
        of_points.push(match values {
            Values::F32(numbers) => Array::new::<f32, _>(name, &[], numbers.clone()),
            Values::F64(numbers) => Array::new::<f64, _>(name, &[], numbers.clone()),
            Values::U8(numbers) => Array::new::<u8, _>(name, &[], numbers.clone()),
            Values::U32(numbers) => Array::new::<u32, _>(name, &[], numbers.clone()),
            Values::U64(numbers) => Array::new::<u64, _>(name, &[], numbers.clone()),
        });
    }
    PolyData {
        time: moment.time,
        count,
        points: places(run, moment),
        // A cell for each point, so that filters that choose cells choose bodies.
        vertices: Some(Cells {
            count,
            connectivity: Array::new::<i64, _>("connectivity", &[], (0..count as i64).collect()),
            offsets: Array::new::<i64, _>("offsets", &[], (1..=count as i64).collect()),
        }),
        polygons: None,
        of_points,
        of_cells: Vec::new(),
    }
}

/// The speed of each body, m/s.
pub(super) fn speeds(moment: &Moment) -> Vec<f32> {
    moment.velocities.iter().map(|v| Vec3::from_array(*v).length()).collect()
}

/// Where the bodies are: in double precision where the run's origin is not the world's.
fn places(run: &Run, moment: &Moment) -> Array<'static> {
    let origin = run.origin();
    if origin == DVec3::ZERO {
        return Array::new::<f32, _>("Points", XYZ, moment.positions.clone());
    }
    let place = |p: &[f32; 3]| (origin + Vec3::from_array(*p).as_dvec3()).to_array();
    Array::new::<f64, _>("Points", XYZ, moment.positions.iter().map(place).collect())
}
