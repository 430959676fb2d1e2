//! Where a ray meets a shape.
//!
//! Everything here is in double precision: a ray that comes from ten kilometres away meets a pebble as exactly as one from beside it. A line
//! meets a convex shape in one stretch; each kind of shape says where that begins and ends, and one function says what of it a ray
//! sees. Surfaces are met triangle by triangle.
//!
//! A new convex shape needs an arm in `stretch` and one in `normal`; until it has a closed form, [`cast_ray_by_distance`] serves it.

mod by_distance;
mod surface;
mod triangle;

pub use by_distance::cast_ray_by_distance;

use crate::{compound, round};
use rockfall_math::{DVec3, Vec3};
use rockfall_shape::{Field, Frustum, Hull, Shape};

/// The points `origin + t direction` with 0 ≤ t ≤ `max`, in the frame of the shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Metres.
    pub origin: DVec3,
    /// Of any length but zero.
    pub direction: DVec3,
    /// May be infinite.
    pub max: f64,
}

/// Where a [`Ray`] first meets a shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayHit {
    /// In lengths of the ray's direction.
    pub t: f64,
    /// Unit vector out of the shape, also where the ray comes from within or from behind; zero where it starts inside of a solid.
    pub normal: Vec3,
    /// What was met: a box's face (−x, +x, −y, +y, −z, +z), a hull's face, the lower end, the upper end or the side of a capsule, a cylinder or a cone (0, 1, 2), a mesh's
    /// triangle; of cell (i, j) of a height field the triangle towards +x is 2 (j (columns − 1) + i), the other one comes next; the part of a compound. 0 for other
    /// shapes; [`INSIDE`] where the ray starts inside of a solid.
    pub part: u64,
}

/// The part that a ray meets that starts inside of a solid.
pub const INSIDE: u64 = u64::MAX;

impl Ray {
    /// The point at `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }

    fn makes_sense(&self) -> bool {
        self.origin.is_finite()
            && self.direction.is_finite()
            && self.direction != DVec3::ZERO
            && self.max >= 0.0
    }
}

/// The first point of a shape that the ray meets. Touching counts. A ray that starts in a convex shape meets it at t = 0 if
/// it is `solid`, and where the ray leaves it if not; the word is that of `parry3d`. A field is its mesh, but solid. Meshes and height fields are surfaces: they are met from
/// either side, and have no inside. No ray slips through between two triangles of theirs that share an edge or a corner; one that lies in the
/// plane of a triangle does not meet that one. Of a compound the first part that is met counts, also where that part's surface lies inside of another part.
///
/// Nothing where the ray is not finite, its direction is zero, or `max` is negative or not a number.
///
/// # Examples
/// ```
/// use rockfall_collide::{INSIDE, Ray, cast_ray};
/// use rockfall_math::{DVec3, Vec3};
/// use rockfall_shape::Shape;
///
/// let cube = Shape::Box { half: Vec3::ONE };
/// let ray = Ray { origin: DVec3::new(5.0, 0.5, 0.0), direction: DVec3::NEG_X, max: f64::INFINITY };
/// let hit = cast_ray(&cube, &ray, true).expect("it is aimed at the cube");
/// assert_eq!((hit.t, hit.normal, hit.part), (4.0, Vec3::X, 1));
///
/// let inside = Ray { origin: DVec3::ZERO, ..ray };
/// let hit = cast_ray(&cube, &inside, true).expect("it starts in the cube");
/// assert_eq!((hit.t, hit.part), (0.0, INSIDE));
/// let hit = cast_ray(&cube, &inside, false).expect("it leaves the cube");
/// assert_eq!((hit.t, hit.normal), (1.0, -Vec3::X));
/// ```
pub fn cast_ray(shape: &Shape, ray: &Ray, solid: bool) -> Option<RayHit> {
    if !ray.makes_sense() {
        return None;
    }
    match shape {
        Shape::Mesh(mesh) => surface::mesh(mesh, ray),
        Shape::Field(field) if solid && is_inside(field, ray.origin) => {
            Some(RayHit { t: 0.0, normal: Vec3::ZERO, part: INSIDE })
        }
        Shape::Field(field) => surface::mesh(field.mesh(), ray),
        Shape::HeightField(field) => surface::height_field(field, ray),
        Shape::Compound(parts) => compound::cast_ray(parts, ray, solid),
        Shape::RoundedBox { .. } | Shape::RoundedHull { .. } => cast_ray_by_distance(shape, ray, solid),
        _ => {
            let stretch = stretch(shape, ray)?;
            let (t, part) = stretch.seen(ray, solid)?;
            let normal = if part == INSIDE { Vec3::ZERO } else { normal(shape, ray.at(t), part) };
            Some(RayHit { t, normal, part })
        }
    }
}

fn is_inside(field: &Field, p: DVec3) -> bool {
    field.mesh().nearest(p, f64::INFINITY).is_some_and(|near| near.distance < 0.0)
}

/// The stretch of a line that lies in a convex shape, and which parts of the surface it passes at its ends. May be infinite.
struct Stretch {
    enter: f64,
    exit: f64,
    parts: [u64; 2],
}

impl Stretch {
    const WHOLE: Stretch = Stretch { enter: f64::NEG_INFINITY, exit: f64::INFINITY, parts: [0; 2] };

    /// What a ray sees of it.
    fn seen(&self, ray: &Ray, solid: bool) -> Option<(f64, u64)> {
        let hit = if self.enter >= 0.0 {
            (self.enter, self.parts[0])
        } else if self.exit < 0.0 {
            return None;
        } else if solid {
            (0.0, INSIDE)
        } else {
            (self.exit, self.parts[1])
        };
        (hit.0 <= ray.max && hit.0 < f64::INFINITY).then_some(hit)
    }

    /// What of it is where `height + t slope` ≤ 0; `part` is the surface where that is zero.
    #[inline]
    fn below(&mut self, height: f64, slope: f64, part: u64) -> bool {
        if slope == 0.0 {
            return height <= 0.0;
        }
        let t = -height / slope;
        if slope < 0.0 {
            if t > self.enter {
                (self.enter, self.parts[0]) = (t, part);
            }
        } else if t < self.exit {
            (self.exit, self.parts[1]) = (t, part);
        }
        self.enter <= self.exit
    }
}

fn stretch(shape: &Shape, ray: &Ray) -> Option<Stretch> {
    match shape {
        Shape::Sphere { radius } => ball(DVec3::ZERO, f64::from(*radius), ray),
        Shape::Box { half } => cuboid(half.as_dvec3(), ray),
        Shape::Capsule { half_length, radius } => capsule(f64::from(*half_length), f64::from(*radius), ray),
        Shape::Cylinder { .. } | Shape::Cone { .. } => frustum(&Frustum::of(shape)?, ray),
        Shape::Ellipsoid { half } => {
            let half = half.as_dvec3();
            ball(
                DVec3::ZERO,
                1.0,
                &Ray { origin: ray.origin / half, direction: ray.direction / half, ..*ray },
            )
        }
        Shape::Hull(hull) => polyhedron(hull, ray),
        Shape::HalfSpace { normal, offset } => {
            let normal = normal.as_dvec3();
            let mut whole = Stretch::WHOLE;
            let height = normal.dot(ray.origin) - f64::from(*offset);
            whole.below(height, normal.dot(ray.direction), 0).then_some(whole)
        }
        Shape::RoundedBox { .. }
        | Shape::RoundedHull { .. }
        | Shape::Mesh(_)
        | Shape::Field(_)
        | Shape::HeightField(_)
        | Shape::Compound(_) => None,
    }
}

/// Unit vector out of a convex shape at a point of its surface.
fn normal(shape: &Shape, at: DVec3, part: u64) -> Vec3 {
    match shape {
        Shape::Sphere { .. } => at.normalize_or(DVec3::Z).as_vec3(),
        Shape::Box { .. } => {
            let axis = Vec3::AXES[(part / 2) as usize % 3];
            if part & 1 == 0 { -axis } else { axis }
        }
        Shape::Capsule { half_length, .. } => {
            let half = f64::from(*half_length);
            let core = DVec3::Z * at.z.clamp(-half, half);
            (at - core).normalize_or(DVec3::X).as_vec3()
        }
        Shape::Cylinder { .. } | Shape::Cone { .. } => match (part, Frustum::of(shape)) {
            (2, Some(f)) => {
                let (across, along) = f.side();
                let radial = at.with_z(0.0).normalize_or(DVec3::X);
                (across * radial + along * DVec3::Z).as_vec3()
            }
            (0, _) => Vec3::NEG_Z,
            _ => Vec3::Z,
        },
        Shape::Ellipsoid { half } => {
            let half = half.as_dvec3();
            (at / (half * half)).normalize_or(DVec3::Z).as_vec3()
        }
        Shape::Hull(hull) => hull.normals[part as usize],
        Shape::HalfSpace { normal, .. } => *normal,
        Shape::RoundedBox { .. }
        | Shape::RoundedHull { .. }
        | Shape::Mesh(_)
        | Shape::Field(_)
        | Shape::HeightField(_)
        | Shape::Compound(_) => Vec3::ZERO,
    }
}

/// From the point of the line that is nearest to the centre, half a chord to either side: without the difference of large squares that
/// the quadratic formula takes far away (Haines et al., "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems, 2019).
fn ball(center: DVec3, radius: f64, ray: &Ray) -> Option<Stretch> {
    let from = ray.origin - center;
    let squared = ray.direction.length_squared();
    let middle = -from.dot(ray.direction) / squared;
    let nearest = from + middle * ray.direction;
    let half = half_chord(radius * radius - nearest.length_squared(), squared)?;
    Some(Stretch { enter: middle - half, exit: middle + half, parts: [0; 2] })
}

/// √(left / squared); none where the line passes by.
fn half_chord(left: f64, squared: f64) -> Option<f64> {
    (left >= 0.0).then(|| (left / squared).sqrt())
}

fn cuboid(half: DVec3, ray: &Ray) -> Option<Stretch> {
    let mut stretch = Stretch::WHOLE;
    for axis in 0..3 {
        let (o, d, h) = (ray.origin[axis], ray.direction[axis], half[axis]);
        let low = stretch.below(-o - h, -d, 2 * axis as u64);
        if !low || !stretch.below(o - h, d, 2 * axis as u64 + 1) {
            return None;
        }
    }
    Some(stretch)
}

/// Clipped by one face after the other (Cyrus and Beck, "Generalized two- and three-dimensional clipping", Computers & Graphics 3, 1978).
fn polyhedron(hull: &Hull, ray: &Ray) -> Option<Stretch> {
    let mut stretch = Stretch::WHOLE;
    for (face, (normal, &offset)) in hull.normals.iter().zip(&hull.offsets).enumerate() {
        let normal = normal.as_dvec3();
        let height = normal.dot(ray.origin) - f64::from(offset);
        if !stretch.below(height, normal.dot(ray.direction), face as u64) {
            return None;
        }
    }
    Some(stretch)
}

/// The hull of what lies in the two balls and in the cylinder between: convex sets that overlap along any line that meets them.
fn capsule(half_length: f64, radius: f64, ray: &Ray) -> Option<Stretch> {
    let end = DVec3::Z * half_length;
    let mut whole: Option<Stretch> = None;
    for part in [ball(-end, radius, ray), ball(end, radius, ray), pipe(half_length, radius, ray)] {
        let Some(part) = part else { continue };
        let all = whole.get_or_insert(Stretch { parts: [0; 2], ..part });
        (all.enter, all.exit) = (all.enter.min(part.enter), all.exit.max(part.exit));
    }
    let mut whole = whole?;
    let along = |t: f64| if half_length > 0.0 { 0.5 + 0.5 * ray.at(t).z / half_length } else { ray.at(t).z };
    whole.parts = [whole.enter, whole.exit].map(|t| round::end_or_side(along(t) as f32) as u64);
    Some(whole)
}

fn pipe(half_length: f64, radius: f64, ray: &Ray) -> Option<Stretch> {
    let (o, d) = (ray.origin.truncate(), ray.direction.truncate());
    let squared = d.length_squared();
    let mut stretch = if squared > 0.0 {
        let middle = -o.dot(d) / squared;
        let half = half_chord(radius * radius - (o + middle * d).length_squared(), squared)?;
        Stretch { enter: middle - half, exit: middle + half, parts: [0; 2] }
    } else if o.length_squared() <= radius * radius {
        Stretch::WHOLE
    } else {
        return None;
    };
    let (z, slope) = (ray.origin.z, ray.direction.z);
    let met = stretch.below(z - half_length, slope, 0) && stretch.below(-z - half_length, -slope, 0);
    met.then_some(stretch)
}

/// Between two planes, the part of a line that is within the radius r(z) = m + s z: where |p|² − r² ≤ 0, a quadratic in t that is taken about
/// the point nearest to the middle, so that far away costs no digits.
fn frustum(f: &Frustum, ray: &Ray) -> Option<Stretch> {
    let (half, lower, upper) = (f64::from(f.half_length), f64::from(f.lower), f64::from(f.upper));
    let (mean, slope) = (0.5 * (lower + upper), 0.5 * (upper - lower) / half);
    let shift = -ray.origin.dot(ray.direction) / ray.direction.length_squared();
    let (o, d) = (ray.at(shift), ray.direction);
    let mut stretch = Stretch::WHOLE;
    if !stretch.below(-o.z - half, -d.z, 0) || !stretch.below(o.z - half, d.z, 1) {
        return None;
    }
    // a t² + 2 b t + c
    let (radius, widens) = (mean + slope * o.z, slope * d.z);
    let a = d.x * d.x + d.y * d.y - widens * widens;
    let b = o.x * d.x + o.y * d.y - radius * widens;
    let c = o.x * o.x + o.y * o.y - radius * radius;
    let root = b * b - a * c;
    // Between the roots where the line crosses the side steeply; where it runs up the cone, beyond one of them: between the planes
    // only one of the two parts is of this cone and not of its mirror image.
    let sides = if a.abs() <= 1e-14 * d.length_squared() {
        if b == 0.0 {
            if c > 0.0 {
                return None;
            }
            [(f64::NEG_INFINITY, f64::INFINITY); 2]
        } else {
            let t = -0.5 * c / b;
            [if b > 0.0 { (f64::NEG_INFINITY, t) } else { (t, f64::INFINITY) }; 2]
        }
    } else if root < 0.0 {
        if a > 0.0 {
            return None;
        }
        [(f64::NEG_INFINITY, f64::INFINITY); 2]
    } else {
        // Without the difference of two numbers that are nearly equal.
        let q = -(b + if b < 0.0 { -root.sqrt() } else { root.sqrt() });
        let (t, u) = (q / a, if q == 0.0 { q / a } else { c / q });
        let (first, last) = if t < u { (t, u) } else { (u, t) };
        if a > 0.0 { [(first, last); 2] } else { [(f64::NEG_INFINITY, first), (last, f64::INFINITY)] }
    };
    let within = |(enter, exit): (f64, f64)| {
        let mut part = Stretch { ..stretch };
        if enter > part.enter {
            (part.enter, part.parts[0]) = (enter, 2);
        }
        if exit < part.exit {
            (part.exit, part.parts[1]) = (exit, 2);
        }
        (part.enter <= part.exit).then_some(part)
    };
    let met = sides.map(within).into_iter().flatten();
    let longest = met.max_by(|p, q| (p.exit - p.enter).total_cmp(&(q.exit - q.enter)))?;
    Some(Stretch { enter: longest.enter + shift, exit: longest.exit + shift, ..longest })
}
