//! A world that is being simulated.

use super::{Seen, Sight};
use rockfall::BodyId;
use rockfall_cache::{Contacts, WantedContacts};
use rockfall_export::linear;
use rockfall_math::DVec3;
use rockfall_scene::{BodyRow, Running, Scene};
use std::collections::BTreeMap;

impl Sight {
    /// The world of a scene after `frame` steps.
    pub fn of_world(scene: &Scene, running: &Running, frame: u64) -> Sight {
        let world = &running.world;
        let rows: BTreeMap<u64, &BodyRow> = running.body_table().iter().map(|row| (row.id, row)).collect();
        let ids = world.ids();
        let centers: BTreeMap<u64, DVec3> =
            world.row_ids().iter().copied().zip(world.centers_of_mass().iter().copied()).collect();
        let (poses, shapes, kinds) = (world.poses(), world.shapes_of_bodies(), world.kinds());
        let (velocities, sleeping) = (world.velocities(), world.sleeping());
        let first_visual = world.shapes().len() as u32;
        let origin = poses.first().map_or(DVec3::ZERO, |pose| pose.position);
        let contacts = WantedContacts::ALL.gather(world, origin, frame);
        let of_all = forces(&ids, &contacts);
        let mut sight = Sight {
            frame,
            time: frame as f64 / f64::from(world.settings().rate),
            step: 1.0 / f64::from(world.settings().rate),
            shapes: world.shapes().iter().chain(running.visuals()).cloned().collect(),
            materials: scene.materials(),
            colors: running.colors().iter().map(|color| color.map(linear)).collect(),
            origin,
            ..Sight::default()
        };
        let (mut asleep, mut pressed) = (Vec::new(), Vec::new());
        for (k, id) in ids.iter().enumerate() {
            let Some(row) = rows.get(&id.0).filter(|row| !row.sensor) else { continue };
            let shape = shapes[k].index();
            let center = centers.get(&id.0).copied().filter(|_| kinds[k] == rockfall::Kind::Dynamic);
            sight.bodies.push(Seen {
                id: id.0,
                shape: shape as u32,
                shown: row.look.visual.map_or(shape as u32, |visual| first_visual + visual),
                color: row.look.color.map(linear),
                material: row.material as u32,
                kind: kinds[k],
                pose: poses[k],
                center: center.unwrap_or(poses[k].position),
                velocity: velocities[k].0,
                spin: velocities[k].1,
            });
            sight.names.extend(row.name.clone().map(|name| (name, id.0)));
            asleep.push(sleeping[k]);
            pressed.push(of_all[k]);
        }
        (sight.asleep, sight.forces, sight.contacts) = (Ok(asleep), Ok(pressed), Ok(contacts));
        sight
    }
}

/// The sum of the normal forces on each body, N. Contacts come in the order of ids, and are summed in it.
pub(super) fn forces(ids: &[BodyId], contacts: &Contacts) -> Vec<f32> {
    let mut sums = vec![0.0_f64; ids.len()];
    for ((&a, &b), &force) in contacts.a.iter().zip(&contacts.b).zip(&contacts.forces) {
        for id in [a, b] {
            if let Ok(row) = ids.binary_search(&BodyId(id)) {
                sums[row] += f64::from(force);
            }
        }
    }
    sums.into_iter().map(|sum| sum as f32).collect()
}
