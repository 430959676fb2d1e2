//! From a sample along its surface to where the other body is nearest.
//!
//! On both surfaces the nearest points look at each other. A point goes along the part of the other body's direction that lies in its own tangent plane, for as far as the change of that
//! part over the last step says (the secant method, with the length of Barzilai and Borwein, "Two-Point Step Size Gradient Methods", IMA Journal of Numerical Analysis 8, 1988), and back to its surface. A
//! step that leads further away is taken back and tried shorter; so edges and corners stay where they are.

use super::gather::{Contact, FACING, within};
use super::side::{Near, Side};
use rockfall_math::Vec3;

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

/// Moves the nearest point of each place to where the distance is least.
pub(super) fn settle(a: &Side, b: &Side, spacing: f32, contacts: &mut [Contact]) {
    let mut order: Vec<usize> = (0..contacts.len()).collect();
    order.sort_by(|&i, &j| contacts[i].distance.total_cmp(&contacts[j].distance).then(i.cmp(&j)));
    let mut places: Vec<(Vec3, Vec3)> = Vec::new();
    for i in order {
        let contact = contacts[i];
        let near = |(place, _): &&(Vec3, Vec3)| {
            place.distance_squared(contact.position) < (PLACE * spacing) * (PLACE * spacing)
        };
        if places.iter().filter(near).any(|(_, normal)| normal.dot(contact.normal) > ALIKE) {
            continue;
        }
        // Where two bodies touch and nothing is nearer there is a contact, whichever way the surfaces look.
        let touches = contact.distance <= 0.0 || places.is_empty();
        let alone = touches && !places.iter().any(|place| near(&place));
        places.push((contact.position, contact.normal));
        if contact.slides {
            let sides = if contact.is_of_b() { [b, a] } else { [a, b] };
            contacts[i] = slid(sides, spacing, &contact);
        }
        contacts[i].faces |= alone;
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
