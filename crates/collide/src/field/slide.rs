//! From a sample along its surface to where the other body is nearest.
//!
//! On both surfaces the nearest points look at each other. A point goes along the part of the other body's direction that lies in its own tangent plane, for as far as the change of that
//! part over the last step says (the secant method, with the length of Barzilai and Borwein, "Two-Point Step Size Gradient Methods", IMA Journal of Numerical Analysis 8, 1988), and back to its surface. A
//! step that leads further away is taken back and tried shorter; so edges and corners stay where they are.

use super::gather::{Contact, FACING, within};
use super::side::{Near, Side};
use rockfall_math::Vec3;
use std::collections::BTreeMap;

/// Steps of one point.
const STEPS: usize = 6;

/// Sine of the angle between the two directions at which they look at each other.
const ALIGNED: f32 = 0.01;

/// The first step, and the way after which a point is left where it is, in spacings.
const FIRST: f32 = 0.25;
const FAR: f32 = 1.0;

/// Points nearer than that to one that has slid, in spacings, belong to the same place.
const PLACE: f32 = 2.0;

/// Cosine of the angle between the directions of two contacts of one place.
const ALIKE: f32 = 0.8;

/// Contacts from which on their places are looked for by cells.
const MANY: usize = 256;

/// Moves the nearest point of each place to where the distance is least.
pub(super) fn settle(a: &Side, b: &Side, spacing: f32, contacts: &mut [Contact]) {
    let mut order: Vec<usize> = (0..contacts.len()).collect();
    order.sort_by(|&i, &j| contacts[i].distance.total_cmp(&contacts[j].distance).then(i.cmp(&j)));
    let mut places = Places::new(PLACE * spacing, contacts.len());
    for (rank, i) in order.into_iter().enumerate() {
        let contact = contacts[i];
        if places.near(contact.position).any(|normal| normal.dot(contact.normal) > ALIKE) {
            continue;
        }
        // Where two bodies touch and nothing is nearer there is a contact, whichever way the surfaces look.
        let touches = contact.distance <= 0.0 || rank == 0;
        let alone = touches && places.near(contact.position).next().is_none();
        places.add(contact.position, contact.normal);
        if contact.slides {
            let sides = if contact.is_of_b() { [b, a] } else { [a, b] };
            contacts[i] = slid(sides, spacing, &contact);
        }
        contacts[i].faces |= alone;
    }
}

/// Places of contacts, with their normals, by cells as wide as a place where there are many: a field next to something a thousand times as large.
struct Places {
    reach: f32,
    /// Width of a cell; without end where there is one.
    cell: f32,
    cells: BTreeMap<[i32; 3], Vec<(Vec3, Vec3)>>,
}

impl Places {
    fn new(reach: f32, contacts: usize) -> Self {
        let cell = if contacts > MANY { reach } else { f32::INFINITY };
        Places { reach, cell, cells: BTreeMap::new() }
    }

    fn cell_of(&self, at: Vec3) -> [i32; 3] {
        // A cast saturates, so that what is out of range is in the last cell.
        (at / self.cell).floor().to_array().map(|x| x as i32)
    }

    /// Normals of the places within reach of a point.
    fn near(&self, at: Vec3) -> impl Iterator<Item = Vec3> + '_ {
        let [x, y, z] = self.cell_of(at);
        let beside = i32::from(self.cell.is_finite());
        let along = move |i: i32| i.saturating_sub(beside)..=i.saturating_add(beside);
        let cells = along(x).flat_map(move |i| along(y).flat_map(move |j| along(z).map(move |k| [i, j, k])));
        let reach = self.reach * self.reach;
        cells
            .filter_map(|cell| self.cells.get(&cell))
            .flatten()
            .filter(move |(place, _)| place.distance_squared(at) < reach)
            .map(|(_, normal)| *normal)
    }

    fn add(&mut self, at: Vec3, normal: Vec3) {
        self.cells.entry(self.cell_of(at)).or_default().push((at, normal));
    }
}

fn slid([own, other]: [&Side; 2], spacing: f32, contact: &Contact) -> Contact {
    let start = contact.own_point();
    let (mut p, mut distance) = (start, contact.distance);
    let mut out = if contact.is_of_b() { contact.normal } else { -contact.normal };
    let mut faces = contact.faces;
    let limit = distance.abs() + 2.0 * spacing;
    let Some(at) = own.nearest(p, limit) else { return *contact };
    let mut down = tangent(-out, at.normal);
    let mut step = FIRST * spacing;
    for _ in 0..STEPS {
        let steep = down.length();
        if steep < ALIGNED || step < 0.01 * spacing {
            break;
        }
        let ahead = p + step / steep * down;
        // The surface is no further from there than the step is long.
        let Some(foot) = own.foot(ahead, 1.01 * step) else { break };
        let next = foot.point;
        let Some(there) = other.nearest(next, limit) else { break };
        if there.distance >= distance || next.distance(start) > FAR * spacing {
            step *= 0.3;
            continue;
        }
        let Some(at) = own.nearest(next, limit) else { break };
        let after = tangent(-there.normal, at.normal);
        // Along the step the slope falls by so much a metre.
        let bend = (steep - after.dot(down) / steep) / next.distance(p).max(1e-3 * step);
        let left = after.length();
        step = if bend * FAR * spacing > left { left / bend } else { spacing };
        (p, distance, out, down) = (next, there.distance, there.normal, after);
        // What has not come to the nearest place within its way leaves that to others.
        faces = foot.cone.is_none_or(|(normal, cone)| within(normal.dot(-out), cone, FACING));
    }
    let slid = Contact::new(contact.is_of_b(), p, Near { distance, normal: out }, contact.name);
    Contact { faces, ..slid }
}

fn tangent(v: Vec3, normal: Vec3) -> Vec3 {
    v - v.dot(normal) * normal
}
