//! Points of one body that are near the other one.

use super::points::{self, Point};
use super::side::{Near, Side};
use rockfall_math::Vec3;
use rockfall_shape::SAMPLES_IN_A_BALL;

/// The way to the other body may leave the cone of the surface's own normals by this angle, as cosine and sine: 60°. The nearest place may be a little further along a surface that bends.
pub(super) const NEARLY: [f32; 2] = [0.5, 0.866];

/// The same for points that stay where they are: 4°. A point of a floor beside the foot of what stands on it looks past its edge, and beside the place where two round bodies touch there are only points
/// that come near later or never.
pub(crate) const FACING: [f32; 2] = [0.997_56, 0.069_76];

/// And for those that are where the two surfaces are nearest already.
const OPPOSITE: f32 = 0.999_9;

/// A ball that is nearer than this share of the distance of its middle is looked into, also where it is out of reach: otherwise nobody would know how far the bodies are apart.
pub(super) const WORTH: f32 = 0.3;

/// Of the samples in a small ball that are further apart from the other body than this share of the spacing, the nearest one stands for all: bodies that come fast see hundreds.
const TOUCHING: f32 = 0.25;

/// Set in the names of B's points.
const OF_B: u32 = 1 << 31;

/// A point of one body near the other, in A's frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    /// Half-way between the two surfaces.
    pub(crate) position: Vec3,
    /// Unit vector from A to B.
    pub(crate) normal: Vec3,
    /// Signed distance along the normal, metres.
    pub(crate) distance: f32,
    pub(super) name: u32,
    /// Whether another point of its surface near by may be nearer to the other body: not where both surfaces look at each other already.
    pub(super) slides: bool,
    /// Whether the two surfaces face each other here.
    pub(super) faces: bool,
}

/// Whether the cosine of an angle says that it is within a cone, which is given by the cosine of its own, or by no more than `beside` beyond.
pub(crate) fn within(cosine: f32, cone: f32, [beside, sine]: [f32; 2]) -> bool {
    // The cosine of the sum of both; everything is within a cone that the sum makes a whole ball.
    let open = cone <= -beside;
    open || cosine >= cone * beside - (1.0 - cone * cone).max(0.0).sqrt() * sine
}

impl Contact {
    pub(super) fn is_of_b(&self) -> bool {
        self.name & OF_B != 0
    }

    /// Of a point of one surface, and where the other body is.
    pub(crate) fn new(of_b: bool, p: Vec3, other: Near, name: u32) -> Self {
        let Near { distance, normal: out } = other;
        let position = p - 0.5 * distance * out;
        let (normal, name) = if of_b { (out, name | OF_B) } else { (-out, name & !OF_B) };
        Contact { position, normal, distance, name, slides: true, faces: true }
    }

    /// The point of its own body.
    pub(super) fn own_point(&self) -> Vec3 {
        let out = if self.is_of_b() { self.normal } else { -self.normal };
        self.position + 0.5 * self.distance * out
    }
}

/// Appends the points of `own` no further than `reach` from `other`. Returns how far all of the others are at least.
pub(super) fn points_near(
    own: &Side,
    other: &Side,
    reach: f32,
    spacing: f32,
    of_b: bool,
    out: &mut Vec<Contact>,
) -> f32 {
    if own.field().is_some() {
        samples(own, other, reach, spacing, of_b, out)
    } else {
        corners(own, other, reach, spacing, of_b, out)
    }
}

/// Samples of a field.
fn samples(own: &Side, other: &Side, reach: f32, spacing: f32, of_b: bool, out: &mut Vec<Contact>) -> f32 {
    let Some(field) = own.field() else { return f32::INFINITY };
    let mut least = f32::INFINITY;
    let mut near = Vec::new();
    field.samples().search(
        |[x, y, z, radii]| {
            std::array::from_fn(|i| {
                let p = own.place.point(Vec3::new(x[i], y[i], z[i]));
                let Some(distance) = other.least_distance(p, reach + radii[i]) else {
                    least = least.min(reach);
                    return f32::INFINITY;
                };
                let inside = distance - radii[i];
                if inside > reach && inside >= WORTH * distance {
                    least = least.min(inside);
                    return f32::INFINITY;
                }
                f32::NEG_INFINITY
            })
        },
        |bound| bound < f32::INFINITY,
        |numbers, _| near.extend(numbers),
    );
    let points = field.samples().points();
    let distances: Vec<f32> = near
        .iter()
        .map(|&i| other.distance(own.place.point(points[i].position), reach).unwrap_or(reach))
        .collect();
    for (n, (&i, &distance)) in near.iter().zip(&distances).enumerate() {
        least = least.min(distance);
        let leads = || {
            let group =
                n - i % SAMPLES_IN_A_BALL..(n - i % SAMPLES_IN_A_BALL + SAMPLES_IN_A_BALL).min(near.len());
            group.into_iter().all(|m| distances[m] > distance || (distances[m] == distance && m >= n))
        };
        if distance >= reach || (distance > TOUCHING * spacing && !leads()) {
            continue;
        }
        let sample = &points[i];
        let p = own.place.point(sample.position);
        let Some(there) = other.nearest(p, reach) else { continue };
        let facing = own.place.vector(sample.normal).dot(-there.normal);
        if within(facing, sample.cone, NEARLY) {
            let (slides, faces) = (facing < OPPOSITE, within(facing, sample.cone, FACING));
            out.push(Contact { slides, faces, ..Contact::new(of_b, p, there, i as u32) });
        }
    }
    least
}

/// Corners and edges of any other shape, in a field.
fn corners(own: &Side, other: &Side, reach: f32, spacing: f32, of_b: bool, out: &mut Vec<Contact>) -> f32 {
    let Some(field) = other.field() else { return f32::INFINITY };
    let mut least = f32::INFINITY;
    let mut put = |point: Point| {
        let core = own.place.point(point.at);
        let surely = field.least_distance(other.place.inverse_point(core)) - point.skin;
        if surely > reach {
            least = least.min(surely);
            return;
        }
        let Some((p, there)) = skin(other, core, point.skin, reach) else { return };
        least = least.min(there.distance);
        if there.distance > reach {
            return;
        }
        let facing = own.place.vector(point.out).dot(-there.normal);
        if point.skin > 0.0 {
            out.push(Contact::new(of_b, p, there, point.name));
        } else if within(facing, point.cone, NEARLY) {
            let (slides, faces) = (facing < OPPOSITE, within(facing, point.cone, FACING));
            out.push(Contact { slides, faces, ..Contact::new(of_b, p, there, point.name) });
        }
    };
    points::near(own, other, field, reach, spacing, &mut put);
    least
}

/// The point of a ball that is nearest to a field, nearly: a field is exact near its surface, not where the middle of a large ball is.
fn skin(field: &Side, core: Vec3, radius: f32, reach: f32) -> Option<(Vec3, Near)> {
    let mut best = (core, field.nearest(core, reach)?);
    if radius == 0.0 {
        return Some(best);
    }
    let mut out = best.1.normal;
    for turn in 0..3 {
        let p = core - radius * out;
        let near = field.nearest(p, reach)?;
        if turn == 0 || near.distance < best.1.distance {
            best = (p, near);
        }
        out = near.normal;
    }
    Some(best)
}
