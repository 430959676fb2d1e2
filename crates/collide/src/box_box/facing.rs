//! A face of one box over a face of the other: what lies over what, and the manifold of that.
//!
//! Everything is seen along the normal of the contact, on the plane of the reference face. There the incident
//! face is a parallelogram and the reference face a rectangle along the axes. What both have in common has its
//! corners at sixteen places at most, of which eight at a time: corners of the one in the other, and where an
//! edge of the incident face comes in between the sides of the other and where it leaves (Liang and Barsky, "A
//! new concept and method for line clipping", ACM TOG 3, 1984). All of them are computed, without a branch, and
//! those that are there are picked out.

use super::gaps::NEXT;
use super::{Boxes, Grip, Seen};
use crate::feature;
use crate::reduce::{Flat, MOST, with_bits};
use crate::{ContactPoint, Manifold};
use rockfall_math::Vec3;
use rockfall_math::lanes::{Kernel, Lanes, Lanes3, Width};

/// Corners beside the reference face by this share of a side of the incident face count as inside: corner and
/// edge must not both be lost to rounding.
const INSIDE: f32 = 1.0 + 1e-6;

/// The incident face in the frame of the reference face: x and y along its sides where it is met along the
/// normal, z out of it, zero at its plane.
pub(super) struct Facing {
    centre: Vec3,
    u: Vec3,
    v: Vec3,
    half: [f32; 2],
    /// How far along x and y, and out of the plane, the normal leads for each metre of height and of itself.
    shear: [f32; 2],
    lean: f32,
    /// The three axes in the frame of A.
    frame: [Vec3; 3],
    /// The centre of the reference box in the frame of A.
    origin: Vec3,
    /// Height of the face above the centre of its box.
    plane: f32,
    reference_is_b: bool,
    names: u32,
}

/// Places that the corners of the common part may have, and which ones are there.
pub(super) struct Places {
    /// Four corners of the incident face, four places where its edges come in, four where they leave, and
    /// four corners of the reference face.
    at: [Four; 4],
    /// Bit 4 i + k for place k of `at[i]`.
    there: u32,
    /// The side through which each edge comes in, and the one through which it leaves: −x, x, −y, y.
    through: [Row; 2],
    /// Whether the incident face is seen counter-clockwise.
    forwards: bool,
}

/// x, y and z of four places.
type Four = [Row; 3];
type Row = [f32; 4];

/// A sign for each corner of a face, counter-clockwise: along x, along y, and both of the corner that comes
/// next; zero in lanes that are idle.
const SIGNS: [[f32; 16]; 4] = [
    [-1.0, 1.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [-1.0, -1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [1.0, 1.0, -1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [-1.0, 1.0, 1.0, -1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
];

impl Boxes {
    /// What is seen from reference face `axis` of a box, on the side of `sign`, of face `m` of the other box
    /// on the side of `towards`, along
    /// `direction` in the frame of the reference box, of unit length.
    pub(super) fn facing(
        &self,
        reference_is_b: bool,
        (axis, sign): (usize, f32),
        (m, towards): (usize, f32),
        direction: Vec3,
    ) -> Facing {
        let t = Vec3::from_array(self.t);
        // The frame of the reference box: axes, own half extents, and the other box's centre, axes, half
        // extents.
        let [a, b, c] = self.r;
        let (along, own, other, centre, seen) = if reference_is_b {
            let centre = self.axes_of_b.map(|axis| -axis.dot(t));
            (
                self.axes_of_b,
                self.b,
                self.a,
                centre,
                [[a[0], b[0], c[0]], [a[1], b[1], c[1]], [a[2], b[2], c[2]]],
            )
        } else {
            (Vec3::AXES, self.a, self.b, self.t, [a, b, c])
        };
        let [x, y] = NEXT[axis];
        let [u, v] = NEXT[m];
        let lean = sign * direction[axis];
        let shear = [direction[x] / lean, direction[y] / lean];
        let flat = |p: Vec3| Vec3::new(p.x - shear[0] * p.z, p.y - shear[1] * p.z, p.z);
        let (row_x, row_y, row_z) = (seen[x], seen[y], seen[axis]);
        let local = |j: usize, scale: f32| scale * Vec3::new(row_x[j], row_y[j], sign * row_z[j]);
        let middle =
            Vec3::new(centre[x], centre[y], sign * centre[axis] - own[axis]) + local(m, towards * other[m]);
        Facing {
            centre: flat(middle),
            u: flat(local(u, other[u])),
            v: flat(local(v, other[v])),
            half: [own[x], own[y]],
            shear,
            lean,
            frame: [along[x], along[y], sign * along[axis]],
            origin: if reference_is_b { t } else { Vec3::ZERO },
            plane: own[axis],
            reference_is_b,
            names: feature::faces(
                reference_is_b,
                2 * axis + usize::from(sign > 0.0),
                2 * m + usize::from(towards > 0.0),
            ),
        }
    }
}

impl Facing {
    /// Of the reference face, from A to B.
    pub(super) fn normal(&self) -> Vec3 {
        if self.reference_is_b { -self.frame[2] } else { self.frame[2] }
    }

    /// What the incident face and the reference face have in common, its sides moved out by `slack`.
    pub(super) fn clip(&self, slack: f32) -> Places {
        let Facing { centre, u, v, half, .. } = *self;
        let reach = [half[0] + slack, half[1] + slack];
        let sticks_out = |i: usize| centre[i].abs() + (u[i].abs() + v[i].abs()) > reach[i];
        if sticks_out(0) || sticks_out(1) {
            return Width::native().at_most(4).run(Cut { facing: self, reach });
        }
        let mut places =
            Places { at: [[[0.0; 4]; 3]; 4], there: 0xf, through: [[0.0; 4]; 2], forwards: true };
        for (k, corner) in [centre - u - v, centre + u - v, centre + u + v, centre - u + v].iter().enumerate()
        {
            for i in 0..3 {
                places.at[0][i][k] = corner[i];
            }
        }
        places
    }

    /// The manifold of what lies over the reference face, its sides moved out by `slack`, no further away
    /// than `margin`; no point is nearer than `seen.distance`.
    /// `nearest` is one more point, if nothing else is as near as that.
    pub(super) fn manifold(
        &self,
        seen: Seen,
        slack: f32,
        margin: f32,
        nearest: Option<(ContactPoint, f32)>,
        grip: &mut Grip,
    ) -> Manifold {
        let places = self.clip(slack);
        let mut near = [(0, 0.0); 16];
        let (mut count, mut deepest, mut there) = (0, f32::INFINITY, places.there);
        while there != 0 {
            let place = there.trailing_zeros() as usize;
            there &= there - 1;
            let height = places.at[place / 4][2][place % 4] / self.lean;
            let distance = if height > seen.distance { height } else { seen.distance };
            near[count] = (place, distance);
            count += usize::from(distance <= margin);
            deepest = if distance < deepest { distance } else { deepest };
        }
        let point = |&(place, distance): &(usize, f32)| ContactPoint {
            position: self.half_way(places.point(place), distance),
            distance,
            feature: self.name(&places, place),
        };
        let near = &near[..count];
        let mut manifold = Manifold { normal: seen.normal, ..Manifold::default() };
        let extra = nearest.filter(|&(_, limit)| deepest > limit).map(|(point, _)| point);
        let all = count + usize::from(extra.is_some());
        // More than eight are one place twice.
        if all > 4 {
            let mut flat = Flat::new();
            for &(place, distance) in near {
                let [x, y, _] = places.point(place);
                flat.push([x, y], distance);
            }
            if let Some(extra) = &extra {
                flat.push(self.flat(extra.position), extra.distance);
            }
            let names = near.iter().map(|&(place, _)| self.name(&places, place));
            let names = names.chain(extra.iter().map(|p| p.feature)).take(MOST);
            let kept = if grip.corners == 0 { None } else { with_bits(names, grip.corners) };
            let four = flat.best_four(kept);
            manifold.points = four.map(|i| near.get(i).map_or(extra.unwrap_or_default(), point));
            manifold.count = 4;
        } else {
            let mut put = |point: ContactPoint| {
                manifold.points[manifold.count as usize] = point;
                manifold.count += 1;
            };
            near.iter().for_each(|near| put(point(near)));
            extra.into_iter().for_each(&mut put);
            if all == 0 {
                // Rounding took the whole face: its lowest corner remains.
                let z = &places.at[0][2];
                let lowest = (1..4).fold(0, |m, k| if z[k] < z[m] { k } else { m });
                put(point(&(lowest, seen.distance)));
            }
        }
        grip.corners = manifold.points().iter().fold(0, |bits, p| bits | feature::corner_bit(p.feature));
        manifold
    }

    fn name(&self, places: &Places, place: usize) -> u32 {
        let (before, after) = places.tags(place);
        feature::corner(self.names, before, after)
    }

    /// The point half-way back to the reference plane from a place, in the frame of A.
    fn half_way(&self, [x, y, z]: [f32; 3], distance: f32) -> Vec3 {
        let height = z - 0.5 * distance * self.lean;
        let [x, y] = [x + self.shear[0] * height, y + self.shear[1] * height];
        self.frame[0] * x + self.frame[1] * y + self.frame[2] * (self.plane + height) + self.origin
    }

    /// A point in the frame of A, seen on the reference plane.
    fn flat(&self, p: Vec3) -> [f32; 2] {
        let [x, y, z] = self.frame.map(|axis| axis.dot(p - self.origin));
        [x - self.shear[0] * (z - self.plane), y - self.shear[1] * (z - self.plane)]
    }
}

impl Places {
    fn point(&self, place: usize) -> [f32; 3] {
        let [x, y, z] = &self.at[place / 4];
        [x[place % 4], y[place % 4], z[place % 4]]
    }

    /// The tags of the edges before and after a place.
    fn tags(&self, place: usize) -> (u8, u8) {
        let k = place % 4;
        let edge = feature::edge_tag(k);
        let side = |through: &Row| feature::side_tag(through[k] as usize);
        match place / 4 {
            0 => (feature::edge_tag((k + 3) % 4), edge),
            1 => (side(&self.through[0]), edge),
            2 => (edge, side(&self.through[1])),
            _ => {
                // Counter-clockwise from −x to −y to x to y.
                let [before, after] = [[0, 2], [2, 1], [1, 3], [3, 0]][k].map(feature::side_tag);
                if self.forwards { (before, after) } else { (after, before) }
            }
        }
    }

    /// Whether one of them is no higher than `limit`.
    pub(super) fn reach(&self, limit: f32) -> bool {
        (0..16).any(|place| self.there >> place & 1 == 1 && self.at[place / 4][2][place % 4] <= limit)
    }
}

/// Finds all places, an edge or a corner in each lane.
struct Cut<'a> {
    facing: &'a Facing,
    /// Of the sides of the reference face.
    reach: [f32; 2],
}

impl Kernel for Cut<'_> {
    type Output = Places;

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::Token) -> Places {
        let Cut { facing: &Facing { centre, u, v, .. }, reach } = self;
        let turn = u.x * v.y - u.y * v.x;
        let number = |x: f32| L::splat(token, x);
        let (zero, one) = (number(0.0), number(1.0));
        let (of_x, of_y, turn_of) = (number(reach[0]), number(reach[1]), number(turn));
        let centre = Lanes3::<L>::splat(token, centre);
        let (u, v) = (Lanes3::<L>::splat(token, u), Lanes3::<L>::splat(token, v));
        let mut places =
            Places { at: [[[0.0; 4]; 3]; 4], there: 0, through: [[0.0; 4]; 2], forwards: turn > 0.0 };
        for l in (0..4).step_by(L::WIDTH) {
            let sign = |k: usize| L::load(token, &SIGNS[k][l..]);
            let here = centre + u.scale(sign(0)) + v.scale(sign(1));
            let next = centre + u.scale(sign(2)) + v.scale(sign(3));
            let (mut enters, mut leaves, mut outside) = (zero, one, number(f32::NEG_INFINITY));
            let (mut entered, mut left) = (zero, zero);
            // How far both ends of each edge are beyond each side.
            for (side, first, second) in [
                (0.0, -here.x - of_x, -next.x - of_x),
                (1.0, here.x - of_x, next.x - of_x),
                (2.0, -here.y - of_y, -next.y - of_y),
                (3.0, here.y - of_y, next.y - of_y),
            ] {
                let crosses = first / (first - second);
                let (out, then_out) = (zero.lt(first), zero.lt(second));
                let comes = L::select(out, L::select(then_out, number(2.0), crosses), zero);
                let goes = L::select(then_out, L::select(out, number(-1.0), crosses), one);
                let (later, sooner) = (enters.lt(comes), goes.lt(leaves));
                enters = L::select(later, comes, enters);
                leaves = L::select(sooner, goes, leaves);
                entered = L::select(later, number(side), entered);
                left = L::select(sooner, number(side), left);
                outside = first.max(outside);
            }
            // The corners of the reference face, in shares of the sides of the incident one.
            let (x, y) = (of_x * sign(0), of_y * sign(1));
            let (from_x, from_y) = (x - centre.x, y - centre.y);
            let along_u = (from_x * v.y - from_y * v.x) / turn_of;
            let along_v = (from_y * u.x - from_x * u.y) / turn_of;
            let height = centre.z + along_u * u.z + along_v * v.z;

            let way = next - here;
            let (came, gone) = (here + way.scale(enters), here + way.scale(leaves));
            let at = [here, came, gone, Lanes3::new(x, y, height)];
            for (from, to) in at.into_iter().zip(&mut places.at) {
                put(from.x, l, &mut to[0]);
                put(from.y, l, &mut to[1]);
                put(from.z, l, &mut to[2]);
            }
            put(entered, l, &mut places.through[0]);
            put(left, l, &mut places.through[1]);
            let in_use = (1 << L::WIDTH.min(4)) - 1;
            let crosses = !u32::from(L::bits(leaves.lt(enters))) & in_use;
            let is_in = !u32::from(L::bits(zero.lt(outside))) & in_use;
            let is_over = along_u.abs().max(along_v.abs()).lt(number(INSIDE));
            places.there |= (is_in
                | (crosses & u32::from(L::bits(zero.lt(enters)))) << 4
                | (crosses & u32::from(L::bits(leaves.lt(one)))) << 8
                | (u32::from(L::bits(is_over)) & in_use) << 12)
                << l;
        }
        places
    }
}

/// Writes the lanes that are in use, from number `l` on.
#[inline(always)]
fn put<L: Lanes>(from: L, l: usize, to: &mut Row) {
    let mut row = [0.0; 16];
    from.store(&mut row);
    let count = L::WIDTH.min(4);
    to[l..l + count].copy_from_slice(&row[..count]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clip;
    use rockfall_math::hash::mix;

    /// Beside Sutherland and Hodgman's way, which cuts by one side after the other; and the same bits at each
    /// width.
    #[test]
    fn the_common_part_has_the_corners_that_cuts_leave() {
        let (mut cut, mut beside) = (0, 0);
        for i in 0..20_000 {
            // Between -1 and 1.
            let wave = |k: u64| (mix(32 * i + k) >> 40) as f32 / (1_u64 << 23) as f32 - 1.0;
            let vector = |k: u64| Vec3::new(wave(k), wave(k + 1), wave(k + 2));
            let facing = Facing {
                centre: 1.5 * vector(0),
                u: vector(3),
                v: vector(6),
                half: [0.2 + wave(9).abs(), 0.2 + wave(10).abs()],
                shear: [0.0; 2],
                lean: 1.0,
                frame: Vec3::AXES,
                origin: Vec3::ZERO,
                plane: 0.0,
                reference_is_b: false,
                names: 0,
            };
            let Facing { centre, u, v, half: [x, y], .. } = facing;
            if (u.x * v.y - u.y * v.x).abs() < 0.1 {
                continue;
            }
            let slack = 0.01;
            let mut polygon =
                clip::incident([centre - u - v, centre + u - v, centre + u + v, centre - u + v].into_iter());
            let side = |x: f32, y: f32| Vec3::new(x, y, 0.0);
            let rectangle = [side(-x, -y), side(x, -y), side(x, y), side(-x, y)];
            clip::clip(&mut polygon, &rectangle, Vec3::Z, Vec3::Z, slack);
            let places = facing.clip(slack);
            let found: Vec<Vec3> = (0..16)
                .filter(|place| places.there >> place & 1 == 1)
                .map(|place| Vec3::from_array(places.point(place)))
                .collect();
            let left: Vec<Vec3> = polygon.iter().map(|corner| corner.position).collect();
            let is_among = |p: &Vec3, points: &[Vec3]| points.iter().any(|q| p.distance(*q) < 2e-5);
            assert!(found.iter().all(|p| is_among(p, &left)), "{i}");
            assert!(left.iter().all(|p| is_among(p, &found)), "{i}");
            // No two of them share a name, and what is after one is before another.
            let tags: Vec<(u8, u8)> = (0..16)
                .filter(|place| places.there >> place & 1 == 1)
                .map(|place| places.tags(place))
                .collect();
            for (k, (_, after)) in tags.iter().enumerate() {
                assert!(tags.iter().skip(k + 1).all(|(_, other)| other != after), "{i}: {tags:?}");
                assert!(tags.iter().any(|(before, _)| before == after), "{i}: {tags:?}");
            }
            cut += usize::from(found.len() > 4);
            beside += usize::from(found.is_empty());
            let reach = facing.half.map(|half| half + slack);
            let bits = |places: &Places| {
                let there = (0..16).filter(|place| places.there >> place & 1 == 1);
                there
                    .map(|place| (places.point(place).map(f32::to_bits), places.tags(place)))
                    .collect::<Vec<_>>()
            };
            let scalar = bits(&Width::Scalar.run(Cut { facing: &facing, reach }));
            let at = |width: Width| bits(&width.run(Cut { facing: &facing, reach }));
            assert!(Width::all().all(|width| at(width) == scalar), "{i}");
        }
        assert!(cut > 1000 && beside > 1000, "{cut} {beside}");
    }
}
