//! What a beam sees of the shapes that pictures have most of: balls, boxes, hulls, and patches of height fields. In single precision, relative to the eye: what that
//! is off by, a ten-millionth of the distance, is a thousandth of a pixel.

use super::hierarchy::{Beam, WIDTH, all, inverse};
use rockfall_math::lanes::Lanes;
use rockfall_math::{Vec2, Vec3};
use rockfall_shape::{HeightField, Hull};

/// Where a line comes into a solid and where it leaves it.
pub(super) type Ends = (f32, f32);

/// What of a solid a beam meets: where it comes in, or, from within, where it leaves.
#[inline(always)]
pub(super) fn seen((enter, exit): Ends, max: f32) -> Option<f32> {
    let t = if enter >= 0.0 { enter } else { exit };
    (enter <= exit && t >= 0.0 && t <= max).then_some(t)
}

/// From the point of the line that is nearest to the centre, half a chord to either side: without the difference of large squares
/// (Haines et al., "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems, 2019).
#[inline(always)]
pub(super) fn ball(center: Vec3, radius: f32, beam: &Beam) -> Option<Ends> {
    let from = center - beam.origin;
    let squared = beam.direction.length_squared();
    let middle = from.dot(beam.direction) / squared;
    let left = radius * radius - (from - middle * beam.direction).length_squared();
    if left < 0.0 {
        return None;
    }
    let half = (left / squared).sqrt();
    Some((middle - half, middle + half))
}

/// Whether a beam comes near a ball.
#[inline(always)]
pub(super) fn nears(center: Vec3, radius: f32, beam: &Beam) -> bool {
    let from = center - beam.origin;
    let squared = beam.direction.length_squared();
    let middle = from.dot(beam.direction) / squared;
    (from - middle * beam.direction).length_squared() <= radius * radius
}

/// Balls side by side: centres and radii.
pub(super) type Balls = [[f32; WIDTH]; 4];

/// Which of eight balls a beam comes near.
#[inline(always)]
pub(super) fn nears_of<L: Lanes>(token: L::Token, balls: &Balls, beam: &Beam) -> u16 {
    let (o, d): ([L; 3], [L; 3]) = (all(token, beam.origin), all(token, beam.direction));
    let (center, radius) = (load::<L>(token, balls), L::load(token, &balls[3]));
    let from = [center[0] - o[0], center[1] - o[1], center[2] - o[2]];
    let middle = dot(from, d) * L::splat(token, 1.0 / beam.direction.length_squared());
    let off = [from[0] - middle * d[0], from[1] - middle * d[1], from[2] - middle * d[2]];
    !L::bits((radius * radius).lt(dot(off, off)))
}

/// A box about the origin.
#[inline(always)]
pub(super) fn cuboid(half: Vec3, origin: Vec3, direction: Vec3) -> Option<Ends> {
    let inverse = inverse(direction);
    let (a, b) = ((-half - origin) * inverse, (half - origin) * inverse);
    let (near, far) = (a.min(b), a.max(b));
    let (enter, exit) = (near.x.max(near.y).max(near.z), far.x.min(far.y).min(far.z));
    (enter <= exit).then_some((enter, exit))
}

/// The face of a box that a point of its surface is on, as its normal.
pub(super) fn face(half: Vec3, at: Vec3) -> Vec3 {
    let share = (at / half).abs();
    let axis = if share.x >= share.y && share.x >= share.z {
        Vec3::X
    } else if share.y >= share.z {
        Vec3::Y
    } else {
        Vec3::Z
    };
    axis * axis.dot(at).signum()
}

/// Planes of a hull, side by side; those that fill up the last eight leave everything inside.
#[derive(Debug)]
pub(super) struct Planes {
    sides: Vec<[[f32; WIDTH]; 4]>,
}

impl Planes {
    pub(super) fn new(hull: &Hull) -> Self {
        let plane = |face: usize| match hull.normals.get(face) {
            Some(normal) => [normal.x, normal.y, normal.z, hull.offsets[face]],
            None => [0.0, 0.0, 0.0, f32::INFINITY],
        };
        let eight =
            |first: usize| std::array::from_fn(|k| std::array::from_fn(|lane| plane(first + lane)[k]));
        Planes { sides: (0..hull.normals.len()).step_by(WIDTH).map(eight).collect() }
    }

    /// Clips a line by all faces (Cyrus and Beck, "Generalized two- and three-dimensional clipping", Computers & Graphics 3, 1978).
    #[inline(always)]
    pub(super) fn clip<L: Lanes>(&self, token: L::Token, origin: Vec3, direction: Vec3) -> Option<Ends> {
        let ([ox, oy, oz], [dx, dy, dz]): ([L; 3], [L; 3]) = (all(token, origin), all(token, direction));
        let zero = L::splat(token, 0.0);
        let (low, high) = (L::splat(token, f32::NEG_INFINITY), L::splat(token, f32::INFINITY));
        let (mut enter, mut exit) = (low, high);
        for side in &self.sides {
            let [nx, ny, nz] = load::<L>(token, side);
            let offset = L::load(token, &side[3]);
            let room = offset - (nx * ox + ny * oy + nz * oz);
            let slope = nx * dx + ny * dy + nz * dz;
            // Along a face: infinitely far on one side or on the other.
            let t = room / slope;
            let (inwards, outwards) = (slope.lt(zero), zero.lt(slope));
            enter = L::select(inwards, t, low).max(enter);
            exit = L::select(outwards, t, high).min(exit);
            // Neither in nor out: what is above the face misses all.
            let level = L::select(inwards, zero, L::select(outwards, zero, room));
            enter = L::select(level.lt(zero), high, enter);
        }
        let (mut enters, mut exits) = ([0.0; WIDTH], [0.0; WIDTH]);
        enter.store(&mut enters);
        exit.store(&mut exits);
        let (mut enter, mut exit) = (f32::NEG_INFINITY, f32::INFINITY);
        for lane in 0..WIDTH {
            enter = if enters[lane] > enter { enters[lane] } else { enter };
            exit = if exits[lane] < exit { exits[lane] } else { exit };
        }
        (enter <= exit).then_some((enter, exit))
    }
}

/// The face of a hull that a point of its surface is on, as its normal.
pub(super) fn hull_face(hull: &Hull, at: Vec3) -> Vec3 {
    let height = |face: usize| hull.normals[face].dot(at) - hull.offsets[face];
    let highest = (0..hull.normals.len()).reduce(|a, b| if height(b) > height(a) { b } else { a });
    highest.map_or(Vec3::Z, |face| hull.normals[face])
}

/// Three coordinates of eight points.
#[inline(always)]
fn load<L: Lanes>(token: L::Token, from: &[[f32; WIDTH]]) -> [L; 3] {
    [L::load(token, &from[0]), L::load(token, &from[1]), L::load(token, &from[2])]
}

#[inline(always)]
fn cross<L: Lanes>(p: [L; 3], q: [L; 3]) -> [L; 3] {
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}

#[inline(always)]
fn dot<L: Lanes>(p: [L; 3], q: [L; 3]) -> L {
    p[0] * q[0] + p[1] * q[1] + p[2] * q[2]
}

/// Where a number lies between two others; what is no number is nowhere.
#[inline(always)]
fn within<L: Lanes>(x: L, low: L, high: L) -> u16 {
    L::bits(low.lt(x)) & L::bits(x.lt(high))
}

/// Cells along each side of a patch, two triangles each.
const SIDE: u32 = 2;

/// By how much triangles are larger than they are, so that no beam slips through between two, as a share of their size, and of the distance by which places are off.
const OVERLAP: f32 = 1e-4;
const OFF: f32 = 1e-6;

/// Eight triangles of a height field, from a corner of the patch.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// In the frame of the field.
    pub(super) corner: Vec3,
    pub(super) low: Vec3,
    pub(super) high: Vec3,
    /// A corner of each triangle, and its sides from there; triangles that are not there have no sides.
    triangles: [[[f32; WIDTH]; 3]; 3],
    /// A triangle's size, about.
    size: f32,
}

/// A height field as patches.
pub(super) fn patches(field: &HeightField) -> Vec<Patch> {
    let [columns, rows] = [field.columns - 1, field.rows - 1];
    let starts = |cells: u32| (0..cells).step_by(SIDE as usize);
    let patch = |i: u32, j: u32| {
        let corner = field.sample(i, j);
        let cells = (j..(j + SIDE).min(rows)).flat_map(|j| (i..(i + SIDE).min(columns)).map(move |i| (i, j)));
        let triangles: Vec<[Vec3; 3]> =
            cells.flat_map(|(i, j)| field.cell(i, j)).map(|corners| corners.map(|at| at - corner)).collect();
        let all = || triangles.iter().flatten().copied();
        let part = |lane: usize, k: usize| match triangles.get(lane) {
            Some([a, ..]) if k == 0 => *a,
            Some(corners) => corners[k] - corners[0],
            None => Vec3::ZERO,
        };
        Patch {
            corner,
            low: all().fold(Vec3::splat(f32::INFINITY), Vec3::min),
            high: all().fold(Vec3::splat(f32::NEG_INFINITY), Vec3::max),
            triangles: std::array::from_fn(|k| {
                std::array::from_fn(|axis| std::array::from_fn(|lane| part(lane, k)[axis]))
            }),
            size: Vec2::min_element(field.spacing),
        }
    };
    starts(rows).flat_map(|j| starts(columns).map(move |i| (i, j))).map(|(i, j)| patch(i, j)).collect()
}

impl Patch {
    /// Where a line first meets a triangle at `from` ≤ t ≤ `until`, and which one (Möller and Trumbore, "Fast, minimum storage ray/triangle intersection", Journal of Graphics
    /// Tools 2, 1997). `origin` is relative to the corner; places are off by some ten-millionth of `distance`.
    #[inline(always)]
    pub(super) fn meet<L: Lanes>(
        &self,
        token: L::Token,
        origin: Vec3,
        direction: Vec3,
        [from, until]: [f32; 2],
        distance: f32,
    ) -> Option<(f32, usize)> {
        // From where it comes near, so that products are of the patch's size.
        let (o, d) = (all::<L>(token, origin + from * direction), all::<L>(token, direction));
        let [a, b, c] = &self.triangles;
        let (a, b, c) = (load::<L>(token, a), load::<L>(token, b), load::<L>(token, c));
        let (zero, one) = (L::splat(token, 0.0), L::splat(token, 1.0));
        let across = cross(d, c);
        let inverse = one / dot(b, across);
        let away = [o[0] - a[0], o[1] - a[1], o[2] - a[2]];
        let u = dot(away, across) * inverse;
        let turned = cross(away, b);
        let v = dot(d, turned) * inverse;
        let t = dot(c, turned) * inverse;
        let over = OVERLAP.max(OFF * distance / self.size);
        let (low, high) = (L::splat(token, -over), L::splat(token, 1.0 + over));
        // A little before it came near the patch and a little after it went: a flat patch has no depth.
        let slack = 2.0 * over * self.size;
        let (start, end) = (L::splat(token, -slack.min(from)), L::splat(token, until - from + slack));
        let met =
            within(u, low, high) & within(v, low, high) & L::bits((u + v).lt(high)) & within(t, start, end);
        if met == 0 {
            return None;
        }
        let mut places = [0.0; WIDTH];
        t.max(zero - L::splat(token, from)).store(&mut places);
        let mut best: Option<(f32, usize)> = None;
        for lane in (0..WIDTH).filter(|lane| met >> lane & 1 != 0) {
            if best.is_none_or(|(t, _)| places[lane] < t) {
                best = Some((places[lane], lane));
            }
        }
        best.map(|(t, lane)| (from + t, lane))
    }

    /// The normal of a triangle.
    pub(super) fn normal(&self, lane: usize) -> Vec3 {
        let side = |k: usize| Vec3::from_array([0, 1, 2].map(|axis| self.triangles[k][axis][lane]));
        side(1).cross(side(2)).normalize_or(Vec3::Z)
    }
}
