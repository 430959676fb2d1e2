//! The bodies that move, from frame to frame, as a PointInstancer has them.

use super::Usd;
use super::stage::BODIES;
use crate::{Error, Job, Moment};
use half::f16;
use rockfall_usd::{Array, Attribute, Writer};

/// What one frame says of the bodies that are there. Made for many frames at once.
pub(super) struct Columns {
    frame: u64,
    /// Rows in the run's table.
    rows: Vec<u32>,
    positions: Vec<[f32; 3]>,
    orientations: Vec<[f16; 4]>,
    /// Empty unless they are wanted, as are the others below.
    precise: Vec<[f32; 4]>,
    velocities: Vec<[f32; 3]>,
    /// Degrees per second.
    spins: Vec<[f32; 3]>,
}

impl Usd {
    pub(super) fn columns(&self, moment: Moment) -> Columns {
        let Moment { frame, time: _, rows, positions, rotations, velocities, mut spins, columns: _ } = moment;
        spins.iter_mut().flatten().for_each(|spin| *spin = spin.to_degrees());
        Columns {
            frame,
            rows,
            positions,
            orientations: rotations.iter().map(|rotation| rotation.map(f16::from_f32)).collect(),
            precise: if self.precise { rotations } else { Vec::new() },
            velocities,
            spins,
        }
    }
}

/// All bodies that move, also those that are not there: they stay where they were last, or at the origin before they come, and are invisible.
pub(super) struct Crowd {
    frame: u64,
    ids: Vec<i64>,
    /// The place of each row of the run's table in the columns.
    places: Vec<u32>,
    columns: Vec<Column>,
    /// Who was there at the last frame.
    present: Vec<bool>,
    /// By how much a body can reach beyond its position, metres.
    radius: f32,
}

/// An attribute with a value for each body.
struct Column {
    name: &'static str,
    type_name: &'static str,
    values: Array,
}

/// The attributes whose values are those of the frame at hand, with their types.
pub(super) type Declared = Vec<(&'static str, &'static str)>;

const INVISIBLE: (&str, &str) = ("invisibleIds", "int64[]");
const EXTENT: (&str, &str) = ("extent", "float3[]");

impl Crowd {
    pub(super) fn of(job: &Job<'_>, usd: &Usd, rows: &[u32], radius: f32) -> Self {
        let table = job.run().bodies();
        let count = rows.len();
        let mut places = vec![0; table.len()];
        (0_u32..).zip(rows).for_each(|(place, &row)| places[row as usize] = place);
        let column = |name, type_name, values| Column { name, type_name, values };
        let (zero, one) = (f16::ZERO, f16::ONE);
        let mut columns = vec![
            column("positions", "point3f[]", Array::Float3(vec![[0.0; 3]; count])),
            column("orientations", "quath[]", Array::Quath(vec![[zero, zero, zero, one]; count])),
        ];
        if usd.precise {
            let values = Array::Quatf(vec![[0.0, 0.0, 0.0, 1.0]; count]);
            columns.push(column("orientationsf", "quatf[]", values));
        }
        if usd.velocities {
            columns.push(column("velocities", "vector3f[]", Array::Float3(vec![[0.0; 3]; count])));
            columns.push(column("angularVelocities", "vector3f[]", Array::Float3(vec![[0.0; 3]; count])));
        }
        // Those beyond the signed numbers become negative, each another one.
        let ids = rows.iter().map(|&row| table.ids[row as usize] as i64).collect();
        Crowd { frame: 0, ids, places, columns, present: vec![false; count], radius }
    }

    pub(super) fn frame(&self) -> u64 {
        self.frame
    }

    pub(super) fn ids(&self) -> &[i64] {
        &self.ids
    }

    pub(super) fn declared(&self) -> Declared {
        let columns = self.columns.iter().map(|column| (column.name, column.type_name));
        columns.chain([INVISIBLE, EXTENT]).collect()
    }

    /// Goes on to another frame.
    pub(super) fn move_to(&mut self, frame: Columns) {
        self.frame = frame.frame;
        self.present.fill(false);
        let places = || frame.rows.iter().map(|&row| self.places[row as usize] as usize);
        places().for_each(|place| self.present[place] = true);
        for column in &mut self.columns {
            match &mut column.values {
                Array::Quath(to) => scatter(&frame.orientations, places(), to),
                Array::Quatf(to) => scatter(&frame.precise, places(), to),
                Array::Float3(to) => {
                    let from = match column.name {
                        "positions" => &frame.positions,
                        "velocities" => &frame.velocities,
                        _ => &frame.spins,
                    };
                    scatter(from, places(), to);
                }
                _ => {}
            }
        }
    }

    /// Writes the frame.
    pub(super) fn sample(&self, writer: &mut Writer) -> Result<(), Error> {
        let time = self.frame as f64;
        let mut put = |name: &str, values: &Array| writer.sample(&format!("{BODIES}.{name}"), time, values);
        for column in &self.columns {
            put(column.name, &column.values)?;
        }
        let absent = self.ids.iter().zip(&self.present).filter(|(_, present)| !**present);
        put(INVISIBLE.0, &Array::Int64(absent.map(|(&id, _)| id).collect()))?;
        put(EXTENT.0, &Array::Float3(self.extent()))?;
        Ok(())
    }

    /// The corners of a box around all bodies that are there.
    fn extent(&self) -> Vec<[f32; 3]> {
        let Array::Float3(positions) = &self.columns[0].values else { return Vec::new() };
        let there = positions.iter().zip(&self.present).filter(|(_, present)| **present);
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for (position, _) in there {
            for axis in 0..3 {
                low[axis] = low[axis].min(position[axis] - self.radius);
                high[axis] = high[axis].max(position[axis] + self.radius);
            }
        }
        if low[0] > high[0] { vec![[0.0; 3]; 2] } else { vec![low, high] }
    }
}

/// Attributes without a value, for a layer whose values are samples.
pub(super) fn attributes(declared: &Declared) -> impl Iterator<Item = Attribute> {
    declared.iter().map(|&(name, type_name)| Attribute::sampled(type_name, name))
}

fn scatter<T: Copy>(from: &[T], places: impl Iterator<Item = usize>, to: &mut [T]) {
    from.iter().zip(places).for_each(|(&value, place)| to[place] = value);
}
