//! A run on disk.

use super::{Known, Seen, Sight, world};
use crate::Error;
use rockfall::BodyId;
use rockfall_cache::{Contacts, Values, mean_velocities};
use rockfall_export::{Inventory, Run, linear};
use rockfall_math::{Pose, Vec3, rotation::rotate};

/// The frames of a run.
#[derive(Debug)]
pub struct Recorded<'a> {
    run: &'a Run,
    inventory: &'a Inventory,
}

impl<'a> Recorded<'a> {
    /// Lays out the scene of the run.
    ///
    /// # Errors
    /// Those of [`Run::inventory`].
    pub fn new(run: &'a Run) -> Result<Self, Error> {
        Ok(Recorded { run, inventory: run.inventory()? })
    }

    /// The bodies at a frame.
    ///
    /// # Errors
    /// Those of [`Run::poses`].
    pub fn at(&self, frame: u64) -> Result<Sight, Error> {
        let Recorded { run, inventory } = self;
        let poses = run.poses(frame)?;
        let velocities = run.velocities(frame)?;
        // Where it has no velocities: the mean over the step that led here, or over the one that follows the start.
        let other = match (&velocities, frame) {
            (Some(_), _) => None,
            (None, 0) if run.frames() > 1 => Some(1),
            (None, 0) => None,
            (None, frame) => Some(frame - 1),
        };
        let other = other.map(|frame| Ok::<_, Error>((frame, run.poses(frame)?))).transpose()?;
        let time = |frame: u64| run.times().get(frame as usize).copied().unwrap_or(f64::NAN);
        let columns = run.columns().iter().map(|column| column.name.as_str()).zip(run.values(frame)?);
        let columns: Vec<(&str, Values)> = columns.collect();
        let mut rows = Vec::new();
        let mut sight = Sight {
            frame,
            time: time(frame),
            step: if run.frames() > 1 { time(1) - time(0) } else { 0.0 },
            shapes: inventory.shapes.clone(),
            materials: inventory.materials.clone(),
            colors: inventory.colors.iter().map(|color| color.map(linear)).collect(),
            origin: run.origin(),
            ..Sight::default()
        };
        for row in 0..run.bodies().len() {
            let Some((position, rotation)) = poses.at(row).filter(|_| !inventory.sensors[row]) else {
                continue;
            };
            let arm = rotate(rotation, inventory.centers[row]);
            let (velocity, spin) = match (&velocities, &other) {
                (Some(velocities), _) => velocities.at(row).unwrap_or_default(),
                (None, Some((frame, others))) => {
                    let there =
                        others.at(row).map(|(p, q)| (time(*frame), p + rotate(q, inventory.centers[row]), q));
                    let here = (sight.time, position + arm, rotation);
                    there.map_or((Vec3::ZERO, Vec3::ZERO), |there| mean_velocities(there, here))
                }
                (None, None) => (Vec3::ZERO, Vec3::ZERO),
            };
            let position = run.origin() + position.as_dvec3();
            rows.push(row);
            let (name, id) = (&run.bodies().names[row], run.bodies().ids[row]);
            if !name.is_empty() {
                sight.names.insert(name.clone(), id);
            }
            sight.bodies.push(Seen {
                id,
                shape: inventory.shape_of[row],
                shown: inventory.shown_of[row],
                color: inventory.color_of[row].map(linear),
                material: inventory.material_of[row],
                kind: inventory.kinds[row],
                pose: Pose { position, rotation },
                center: position + arm.as_dvec3(),
                velocity,
                spin,
            });
        }
        sight.contacts = self.contacts(frame)?;
        let asleep = column(&columns, "asleep", &rows, |values, row| match values {
            Values::U8(asleep) => asleep.get(row).map(|&asleep| asleep != 0),
            _ => None,
        });
        sight.asleep = asleep.ok_or_else(|| lacks("which bodies are asleep", "columns = [\"asleep\"]"));
        let forces = column(&columns, "contact_force", &rows, |values, row| match values {
            Values::F32(forces) => forces.get(row).copied(),
            _ => None,
        });
        sight.forces = match (forces, &sight.contacts) {
            (Some(forces), _) => Ok(forces),
            (None, Ok(contacts)) => {
                let ids: Vec<BodyId> = sight.bodies.iter().map(|body| BodyId(body.id)).collect();
                Ok(world::forces(&ids, contacts))
            }
            (None, Err(_)) => Err(lacks("forces", "columns = [\"contact_force\"]")),
        };
        Ok(sight)
    }

    fn contacts(&self, frame: u64) -> Result<Known<Contacts>, Error> {
        let Some(wanted) = self.run.wanted_contacts() else {
            return Ok(Err(lacks("contacts", "contacts = true")));
        };
        if frame > 0 && !frame.is_multiple_of(wanted.every) {
            return Ok(Err(format!(
                "the run has the contacts of every {} frames, and not of {frame}",
                wanted.every
            )));
        }
        Ok(Ok(self.run.contacts(frame)?))
    }
}

/// The values of a column for some rows of the table, where the run has it.
fn column<T>(
    columns: &[(&str, Values)],
    name: &str,
    rows: &[usize],
    read: impl Fn(&Values, usize) -> Option<T>,
) -> Option<Vec<T>> {
    let (_, values) = columns.iter().find(|(known, _)| *known == name)?;
    rows.iter().map(|&row| read(values, row)).collect()
}

/// Why something is not known, and what to do about it.
fn lacks(what: &str, key: &str) -> String {
    format!(
        "the run does not know {what}: run its scene again with `{key}` in `[output]`, or render the scene itself"
    )
}
