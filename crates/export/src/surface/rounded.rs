//! Polyhedra that have grown to all sides.
//!
//! Each face moves out. Each edge becomes a part of a cylinder between the normals of its two faces. Each corner becomes a part of a ball, bounded by the arcs
//! of its edges: for each edge a sector between its arc and the middle of the normals around the corner. All of these share the points of the arcs, so that the
//! surface is closed.

use super::{SEGMENTS, Surface, Weld};
use rockfall_math::{Vec3, trig};
use rockfall_shape::Hull;
use std::f32::consts::TAU;

/// `hull` grown by `radius`, metres.
pub(super) fn rounded(hull: &Hull, radius: f32) -> Surface {
    let mut weld = Weld::default();
    let out = |corner: u32, normal: Vec3| (hull.vertices[corner as usize] + radius * normal, normal);
    for (f, &normal) in hull.normals.iter().enumerate() {
        let face = hull.face(f);
        for w in face[1..].windows(2) {
            weld.add([face[0], w[0], w[1]].map(|corner| out(corner, normal)));
        }
    }
    let middles = middles(hull);
    for edge in &hull.edges {
        let [u, v] = edge.vertices;
        let [left, right] = edge.faces.map(|f| hull.normals[f as usize]);
        let arc = between(left, right, steps(angle(left, right)));
        for w in arc.windows(2) {
            weld.add([out(v, w[0]), out(u, w[0]), out(u, w[1])]);
            weld.add([out(v, w[0]), out(u, w[1]), out(v, w[1])]);
        }
        // Seen from outside, arcs run clockwise around the middle at the edge's start, and the other way round at its end.
        sector(&mut weld, &middles[u as usize], arc.iter().rev(), |normal| out(u, normal));
        sector(&mut weld, &middles[v as usize], arc.iter(), |normal| out(v, normal));
    }
    weld.surface
}

/// What a corner's part of a ball is spread out from.
struct Middle {
    /// The middle of the normals around the corner.
    normal: Vec3,
    /// Rings from there to the arcs; the same in all sectors of the corner, because they share their sides.
    rings: u32,
}

fn middles(hull: &Hull) -> Vec<Middle> {
    let mut middles: Vec<Middle> =
        hull.vertices.iter().map(|_| Middle { normal: Vec3::ZERO, rings: 1 }).collect();
    let around = || (0..hull.normals.len()).flat_map(|f| hull.face(f).iter().map(move |&c| (c as usize, f)));
    around().for_each(|(corner, f)| middles[corner].normal += hull.normals[f]);
    middles.iter_mut().for_each(|middle| middle.normal = middle.normal.normalize_or_zero());
    for (corner, f) in around() {
        let middle = &mut middles[corner];
        middle.rings = middle.rings.max(steps(angle(middle.normal, hull.normals[f])));
    }
    middles
}

/// The part of a ball between a corner's middle and an arc, which runs counter-clockwise around the middle.
fn sector<'a>(
    weld: &mut Weld,
    middle: &Middle,
    arc: impl Iterator<Item = &'a Vec3>,
    out: impl Fn(Vec3) -> (Vec3, Vec3),
) {
    let rays: Vec<Vec<Vec3>> = arc.map(|end| between(middle.normal, *end, middle.rings)).collect();
    for w in rays.windows(2) {
        for ring in 0..middle.rings as usize {
            let [a, b, c, d] = [w[0][ring], w[0][ring + 1], w[1][ring + 1], w[1][ring]].map(&out);
            weld.add([a, b, c]);
            weld.add([a, c, d]);
        }
    }
}

/// Unit vectors from `a` to `b` along the great circle, in equal steps; the ends are `a` and `b` to the bit.
fn between(a: Vec3, b: Vec3, steps: u32) -> Vec<Vec3> {
    let angle = angle(a, b);
    let at = |k: u32| {
        let t = k as f32 / steps as f32;
        let (from, to) = (trig::sin((1.0 - t) * angle), trig::sin(t * angle));
        (from * a + to * b).normalize_or(a)
    };
    std::iter::once(a).chain((1..steps).map(at)).chain(std::iter::once(b)).collect()
}

fn angle(a: Vec3, b: Vec3) -> f32 {
    trig::atan2(a.cross(b).length(), a.dot(b))
}

/// Steps of at most a segment's angle.
fn steps(angle: f32) -> u32 {
    // A right angle is six steps, and not seven because of its last bit.
    (angle / (TAU / SEGMENTS as f32) - 1e-3).ceil().max(1.0) as u32
}
