//! Manifolds of convex shapes of any kind: the nearest points, and what lies around them.
//!
//! Around the point where it touches, a surface may be flat (a face of a polyhedron, the end of a cylinder), straight along
//! a line (the side of a cylinder or a cone, the core of a capsule), or neither. Each shape gives this patch of its surface
//! for the normal that the nearest points have, and two patches are laid on each other along it.
//!
//! The end of a cylinder is a disc, taken as a polygon of the corners [`RIM`]. They have their directions from the other
//! body, so that the points of a cylinder that stands stay where they are when it spins about its axis, and four of them,
//! always the same, are chosen. The deepest point of the rim takes the place of one of them where it is deeper by more than
//! [`LEVEL`].

use crate::clip::{self, End, SLACK};
use crate::closest::Closest;
use crate::feature;
use crate::form::{Form, RIM, Solid};
use crate::gjk::{Core, Placed, Walk, walk};
use crate::half_space::HalfSpace;
use crate::penetration::least_overlap;
use crate::poly::Poly;
use crate::reduce::{reduce_within, start};
use crate::{Cache, ContactPoint, Manifold, direction};
use rockfall_math::{Isometry, Vec3};
use rockfall_shape::Frustum;
use smallvec::SmallVec;

/// Cosine of the angle between the normal and a flat patch below which only the nearest points touch: 37 degrees, as for
/// polyhedra.
const FLAT: f32 = 0.8;

/// Sine of the angle up to which the core of a capsule lies along a face.
const LIES: f32 = 0.2;

/// Share of a disc's radius by which the deepest point of its rim must be deeper than the corners that are shown.
pub(crate) const LEVEL: f32 = 1e-4;

/// Cosine of the angle up to which two lines may be side by side, and how far aside they may be from each other where they
/// are said to touch, as a share of the smaller shape.
const PARALLEL: f32 = 0.99;
const ASIDE: f32 = 0.1;

/// Share of the shorter line below which a stretch is a point.
const SHORT: f32 = 1e-3;

type Corners = SmallVec<[Vec3; 24]>;

/// What a surface is like around the point where it touches.
pub(crate) struct Patch {
    /// Of a flat patch counter-clockwise from outside; the ends of a line; or nothing.
    pub(crate) corners: Corners,
    /// Outward normal of a flat patch.
    outward: Vec3,
    /// Its cosine with the direction of the other shape.
    pub(crate) cosine: f32,
    /// Number of the face.
    pub(crate) face: usize,
    /// Depths that differ by less are equal, metres.
    pub(crate) tie: f32,
}

impl Patch {
    fn none() -> Self {
        Patch { corners: Corners::new(), outward: Vec3::ZERO, cosine: -1.0, face: 0, tie: 0.0 }
    }

    fn placed(mut self, pose: &Isometry) -> Self {
        self.corners.iter_mut().for_each(|c| *c = pose.point(*c));
        self.outward = pose.vector(self.outward);
        self
    }

    /// Height of a point over the plane of a flat patch.
    pub(crate) fn height(&self, p: Vec3) -> f32 {
        self.outward.dot(p - self.corners[0])
    }

    /// Corners and outward directions (not unit) of the sides of a flat patch.
    pub(crate) fn sides(&self) -> impl Iterator<Item = (Vec3, Vec3)> + '_ {
        let next = |k: usize| self.corners[if k + 1 == self.corners.len() { 0 } else { k + 1 }];
        self.corners.iter().enumerate().map(move |(k, &c)| (c, (next(k) - c).cross(self.outward)))
    }
}

/// The patch of a shape in a direction, unit, in the shape's frame. Corners of discs start at `spoke`.
pub(crate) fn patch(shape: &Solid, towards: Vec3, spoke: Vec3) -> Patch {
    match &shape.form {
        Form::Segment(half) if *half > 0.0 && towards.z.abs() <= LIES => {
            let end = Vec3::new(0.0, 0.0, *half);
            Patch { corners: [-end, end].into_iter().collect(), ..Patch::none() }
        }
        Form::Segment(_) | Form::Ellipsoid(_) => Patch::none(),
        Form::Hull(poly) => face(poly, towards),
        Form::Box(cuboid) => face(&cuboid.poly(), towards),
        Form::Frustum(frustum) => round(frustum, towards, spoke),
    }
}

fn face(poly: &Poly, towards: Vec3) -> Patch {
    let (face, cosine) = poly.face_at_support(towards);
    if cosine < FLAT {
        return Patch::none();
    }
    let corners = poly.face(face).iter().map(|&c| poly.vertices[c as usize]).collect();
    Patch { corners, outward: poly.normals[face], cosine, face, tie: 0.0 }
}

/// An end or a line of the side, whichever looks most to the direction.
fn round(frustum: &Frustum, towards: Vec3, spoke: Vec3) -> Patch {
    let Frustum { half_length, lower, upper } = *frustum;
    let (across, along) = frustum.side();
    let away = (towards.x * towards.x + towards.y * towards.y).sqrt();
    let side = across as f32 * away + along as f32 * towards.z;
    let end = towards.z.abs();
    let high = towards.z >= 0.0;
    let radius = if high { upper } else { lower };
    if radius > 0.0 && end >= side && end >= FLAT {
        let normal = if high { Vec3::Z } else { Vec3::NEG_Z };
        let u = spoke.with_z(0.0).normalize_or(Vec3::X);
        let v = normal.cross(u);
        let middle = half_length * normal;
        let corners = RIM.iter().map(|&[c, s]| middle + radius * (c * u + s * v)).collect();
        return Patch { corners, outward: normal, cosine: end, face: usize::from(high), tie: LEVEL * radius };
    }
    if side < FLAT || away <= 0.0 {
        return Patch::none();
    }
    let radial = towards.with_z(0.0) / away;
    let ends = [(lower, -half_length), (upper, half_length)];
    Patch { corners: ends.map(|(r, z)| r * radial + Vec3::Z * z).into_iter().collect(), ..Patch::none() }
}

/// Appends the manifold of two shapes if they come within `margin`. Returns how far apart they are at least, or 0.
pub(crate) fn collide(
    a: &Solid,
    b: &Solid,
    b_in_a: &Isometry,
    margin: f32,
    cache: &mut Cache,
    out: &mut Vec<Manifold>,
) -> f32 {
    let skins = a.skin + b.skin;
    if let Some(axis) = direction::unpack(cache.word) {
        let apart = surely_apart(a, b, b_in_a, axis);
        if apart > margin {
            return apart;
        }
    }
    let cores = match nearest(a, b, b_in_a, margin + skins) {
        Err(axis) => {
            cache.word = direction::pack(axis);
            return surely_apart(a, b, b_in_a, axis.normalize_or(Vec3::Z)).max(margin);
        }
        Ok(closest) => closest,
    };
    cache.word = direction::pack(cores.normal);
    if cores.distance - skins > margin {
        return cores.distance - skins;
    }
    let spoke = start(cores.normal);
    let of_a = patch(a, cores.normal, spoke);
    let of_b = patch(b, -b_in_a.inverse_vector(cores.normal), b_in_a.inverse_vector(spoke)).placed(b_in_a);
    let rounding = 4e-7 * (a.size() + b.size() + b_in_a.translation.length());
    let mut manifold = lay(&of_a, &of_b, &cores, [a, b], margin + skins, rounding);
    manifold.grow(a.skin, b.skin);
    out.push(manifold);
    0.0
}

/// Signed distance of two shapes.
pub(crate) fn closest(a: &Solid, b: &Solid, b_in_a: &Isometry) -> Option<Closest> {
    nearest(a, b, b_in_a, f32::INFINITY).ok().map(|c| c.with_skins(a.skin, b.skin))
}

/// The nearest points of the cores, or a direction in which they are further apart than `limit`.
fn nearest(a: &Solid, b: &Solid, b_in_a: &Isometry, limit: f32) -> Result<Closest, Vec3> {
    let placed = Placed::new(b_in_a);
    match walk(&a.form, &b.form, &placed, f64::from(limit)) {
        Walk::Apart(near) => Ok(near.closest()),
        Walk::Beyond(axis) => Err(axis.normalize_or_zero().as_vec3()),
        Walk::Overlap => Ok(least_overlap(&a.form, &b.form, &placed).closest()),
    }
}

/// The distance that `axis` proves, with room for all rounding: the slow way must agree that there is so much.
fn surely_apart(a: &Solid, b: &Solid, b_in_a: &Isometry, axis: Vec3) -> f32 {
    let furthest = a.reach(axis, &Isometry::IDENTITY);
    let nearest = -b.reach(-axis, b_in_a);
    let rounding = 1e-5 * (furthest.abs() + nearest.abs() + b_in_a.translation.abs().element_sum());
    (nearest - furthest - (a.skin + b.skin)) * (1.0 - 1e-5) - rounding
}

/// The manifold of two patches, no further than `margin`; the nearest points are `cores`.
fn lay(
    a: &Patch,
    b: &Patch,
    cores: &Closest,
    [of_a, of_b]: [&Solid; 2],
    margin: f32,
    rounding: f32,
) -> Manifold {
    let slack = SLACK * of_a.breadth().min(of_b.breadth());
    let mut points: SmallVec<[ContactPoint; 24]> = SmallVec::new();
    let tie = a.tie.max(b.tie);
    match (a.corners.len(), b.corners.len()) {
        (0, _) | (_, 0) => return cores.manifold(),
        (2, 2) => {
            let breadth = of_a.breadth().min(of_b.breadth());
            side_by_side(&a.corners, &b.corners, cores, breadth, &mut points);
        }
        (_, 2) => over(a, &b.corners, false, cores, slack, &mut points),
        (2, _) => over(b, &a.corners, true, cores, slack, &mut points),
        // A's face unless B's is clearly nearer to the normal, see `polyhedra::around`.
        _ if b.cosine > a.cosine + 1e-3 => cut(b, a, true, cores, slack, &mut points),
        _ => cut(a, b, false, cores, slack, &mut points),
    }
    points.retain(|p| p.distance <= margin);
    let shown = points.iter().fold(f32::INFINITY, |d, p| d.min(p.distance));
    if shown > cores.distance + rounding {
        points.push(cores.point());
    }
    reduce_within(cores.normal, &points, start(cores.normal), tie)
}

/// A contact point of a place on the incident patch and its distance from the reference, along the normal.
fn contact(p: Vec3, distance: f32, reference_is_b: bool, normal: Vec3, feature: u32) -> ContactPoint {
    let half = if reference_is_b { 0.5 * distance } else { -0.5 * distance };
    ContactPoint { position: p + half * normal, distance, feature }
}

/// How far a point of the incident patch is from the plane of the reference patch along the normal.
fn gap(reference: &Patch, p: Vec3, cores: &Closest) -> f32 {
    let lean = reference.outward.dot(cores.normal).abs();
    (reference.height(p) / lean).max(cores.distance)
}

/// Two flat patches.
fn cut(
    reference: &Patch,
    incident: &Patch,
    reference_is_b: bool,
    cores: &Closest,
    slack: f32,
    points: &mut SmallVec<[ContactPoint; 24]>,
) {
    let names = feature::faces(reference_is_b, reference.face, incident.face);
    let mut left = clip::incident(incident.corners.iter().copied());
    clip::clip(&mut left, &reference.corners, reference.outward, cores.normal, slack);
    points.extend(left.iter().map(|c| {
        let distance = gap(reference, c.position, cores);
        let name = feature::corner(names, c.before, c.after);
        contact(c.position, distance, reference_is_b, cores.normal, name)
    }));
}

/// A line over a flat patch.
fn over(
    reference: &Patch,
    line: &[Vec3],
    reference_is_b: bool,
    cores: &Closest,
    slack: f32,
    points: &mut SmallVec<[ContactPoint; 24]>,
) {
    let ends = [line[0], line[1]];
    let along = if reference_is_b { -cores.normal } else { cores.normal };
    let Some([low, high]) = clip::segment(reference.sides(), reference.outward, along, ends, slack) else {
        return;
    };
    let names = feature::faces(reference_is_b, reference.face, 0);
    let point = |End { t, before, after }: End| {
        let p = ends[0].lerp(ends[1], t);
        contact(
            p,
            gap(reference, p, cores),
            reference_is_b,
            cores.normal,
            feature::corner(names, before, after),
        )
    };
    let (low_point, high_point) = (point(low), point(high));
    if high.t - low.t > SHORT {
        points.extend([low_point, high_point]);
    } else {
        points.push(if high_point.distance < low_point.distance { high_point } else { low_point });
    }
}

/// Two lines: both ends of what they have in common, where they are side by side.
fn side_by_side(
    a: &[Vec3],
    b: &[Vec3],
    cores: &Closest,
    breadth: f32,
    points: &mut SmallVec<[ContactPoint; 24]>,
) {
    let (along_a, along_b) = (a[1] - a[0], b[1] - b[0]);
    let (length_a, length_b) = (along_a.length(), along_b.length());
    let (u, v) = (along_a / length_a, along_b / length_b);
    if u.dot(v).abs() < PARALLEL {
        return;
    }
    let (from, to) = (u.dot(b[0] - a[0]), u.dot(b[1] - a[0]));
    let (low, high) = (from.min(to).max(0.0), from.max(to).min(length_a));
    let stretch = high - low;
    if stretch <= SHORT * length_a.min(length_b)
        || stretch * u.cross(v).dot(cores.normal).abs() > ASIDE * breadth
    {
        return;
    }
    for (k, at) in [low, high].into_iter().enumerate() {
        let on_a = a[0] + at * u;
        let on_b = b[0] + along_b * ((at - from) / (to - from));
        let across = on_b - on_a;
        let distance = across.dot(cores.normal);
        if (across - distance * cores.normal).length() > ASIDE * breadth {
            continue;
        }
        let distance = distance.max(cores.distance);
        let own_end = at == 0.0 || at == length_a;
        let feature = feature::pair(4 + 2 * k + usize::from(own_end), 1);
        points.push(ContactPoint { position: 0.5 * (on_a + on_b), distance, feature });
    }
}

/// The manifold of a half-space and a shape, or how far apart they are.
pub(crate) fn on_half_space(
    a: &HalfSpace,
    b: &Solid,
    b_in_a: &Isometry,
    margin: f32,
) -> Result<Manifold, f32> {
    let lowest = half_space_closest(a, b, b_in_a);
    if lowest.distance > margin {
        return Err(lowest.distance);
    }
    let (normal, spoke) = (a.normal, start(a.normal));
    let patch = patch(b, -b_in_a.inverse_vector(normal), b_in_a.inverse_vector(spoke)).placed(b_in_a);
    let points = patch.corners.iter().enumerate().map(|(k, &p)| {
        let distance = normal.dot(p) - a.offset - b.skin;
        let name = feature::pair(patch.face + 1, k);
        contact(p - b.skin * normal, distance, false, normal, name)
    });
    let mut points: SmallVec<[ContactPoint; 24]> = points.filter(|p| p.distance <= margin).collect();
    let shown = points.iter().fold(f32::INFINITY, |d, p| d.min(p.distance));
    let rounding = 4e-7 * (b.size() + b_in_a.translation.length());
    if shown > lowest.distance + rounding {
        points.push(lowest.point());
    }
    Ok(reduce_within(normal, &points, spoke, patch.tie))
}

/// The point of a shape that is deepest in a half-space.
pub(crate) fn half_space_closest(a: &HalfSpace, b: &Solid, b_in_a: &Isometry) -> Closest {
    let down = -b_in_a.inverse_vector(a.normal);
    let p = b_in_a.point(b.form.point(b.form.support(down.as_dvec3())).as_vec3());
    let height = a.normal.dot(p) - a.offset;
    let on_a = p - height * a.normal;
    let feature = feature::pair(0x7ffe, 0xfd);
    Closest { distance: height, normal: a.normal, on_a, on_b: p, feature }.with_skins(0.0, b.skin)
}
