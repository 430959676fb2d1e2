//! Whether two shapes overlap, and how deeply.

use crate::surface::Surface;
use crate::time_of_impact::{Core, Course, Other, Set};
use crate::{Cache, Distance, Manifold, Motion, Sweep, Toi, collide, compound, distance};
use rockfall_math::{Aabb, Isometry};
use rockfall_shape::Shape;

/// Whether the bounded convex shape `a`, or a compound of such, and `b`, which may be of any kind, share a point. `b_in_a` places B in A's frame. A mesh is its triangles, from
/// either side; a field is solid, and a height field all the way down.
///
/// False where A is neither, or a number is not finite.
pub fn overlaps(a: &Shape, b: &Shape, b_in_a: &Isometry) -> bool {
    if !crate::is_finite(b_in_a) || matches!(a, Shape::HalfSpace { .. }) {
        return false;
    }
    if compound::takes_part(a, b) {
        return compound::overlaps(a, b, b_in_a);
    }
    if !a.is_convex() {
        return false;
    }
    let sweep = still(&b_in_a.inverse());
    match b {
        Shape::Mesh(_) | Shape::Field(_) | Shape::HeightField(_) => {
            Core::new(a, &sweep.a, 0.0).is_some_and(|core| touched(a, b, &core, &sweep).is_some())
        }
        _ => distance(a, b, b_in_a).is_some_and(|d| d.distance <= 0.0),
    }
}

/// How the bounded convex shape `a`, or a compound of such, and `b` overlap, in A's frame: the shortest translation of B out of A is `-distance` along `normal`. Out of meshes, fields
/// and height fields it is the deepest of the contacts that [`collide`] finds: A is pushed to the front of triangles.
///
/// Of compounds it is that of the two parts that overlap most.
///
/// Nothing where they do not overlap, or A is not as said, or a number is not finite.
///
/// # Examples
/// ```
/// use rockfall_collide::penetration;
/// use rockfall_math::{Isometry, Vec3};
/// use rockfall_shape::Shape;
///
/// let (ball, ground) = (Shape::Sphere { radius: 0.5 }, Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 });
/// let below = Isometry { translation: -0.25 * Vec3::Z, ..Isometry::IDENTITY };
/// let deep = penetration(&ball, &ground, &below).expect("the ground is a quarter below the middle");
/// assert_eq!((deep.distance, deep.normal), (-0.25, -Vec3::Z));
/// ```
pub fn penetration(a: &Shape, b: &Shape, b_in_a: &Isometry) -> Option<Distance> {
    if compound::takes_part(a, b) {
        return if crate::is_finite(b_in_a) { compound::penetration(a, b, b_in_a) } else { None };
    }
    if !overlaps(a, b, b_in_a) {
        return None;
    }
    match b {
        Shape::Mesh(_) | Shape::Field(_) | Shape::HeightField(_) => {
            deepest(a, b, b_in_a).or_else(|| behind(a, b, &b_in_a.inverse()))
        }
        _ => distance(a, b, b_in_a),
    }
}

/// The touch of shapes that overlap from the start, seen from B.
pub(crate) fn from_the_start(a: &Shape, b: &Shape, core: &Core, sweep: &Sweep) -> Option<Toi> {
    let a_in_b = sweep.a.start;
    let overlap = match b {
        Shape::Mesh(_) | Shape::Field(_) | Shape::HeightField(_) => {
            touched(a, b, core, sweep)?;
            deepest(a, b, &a_in_b.inverse()).or_else(|| behind(a, b, &a_in_b))
        }
        _ => Some(distance(a, b, &a_in_b.inverse())?).filter(|d| d.distance < 0.0),
    }?;
    Some(Toi {
        time: 0.0,
        normal: a_in_b.vector(overlap.normal),
        point: a_in_b.point(overlap.on_a),
        distance: overlap.distance,
    })
}

fn still(a_in_b: &Isometry) -> Sweep {
    Sweep { a: Motion::at_rest(*a_in_b), b: Motion::at_rest(Isometry::IDENTITY) }
}

/// The first triangle of a surface that A touches, or the one above where A is all inside.
fn touched(a: &Shape, b: &Shape, core: &Core, sweep: &Sweep) -> Option<u64> {
    match b {
        Shape::Mesh(mesh) => first_triangle(a, &**mesh, core, sweep),
        Shape::Field(field) => first_triangle(a, &**field.mesh(), core, sweep).or_else(|| {
            // What touches no triangle is inside as a whole or not at all.
            let middle = sweep.a.start.point(a.bounds().center());
            let near = field.mesh().nearest(middle.as_dvec3(), f64::INFINITY)?;
            (near.distance < 0.0).then_some(u64::from(near.triangle))
        }),
        Shape::HeightField(field) => first_triangle(a, &**field, core, sweep),
        _ => None,
    }
}

fn first_triangle<S: Surface>(a: &Shape, surface: &S, core: &Core, sweep: &Sweep) -> Option<u64> {
    let place = sweep.a.start;
    let course = Course { sweep, inner: 0.0, target: 0.0 };
    let corners = core.set.corners();
    let area = Aabb::from_points(corners.iter().map(|&p| place.point(p))).grown(core.radius);
    let mut triangles = Vec::new();
    surface.near(&area.grown(1e-5 * core.reach), |triangle| triangles.push(triangle));
    triangles.sort_unstable();
    let touch = |&triangle: &u64| {
        let set = Set::Points(surface.corners(triangle).into_iter().collect());
        let other = Other::Convex { set: &set, radius: 0.0, arm: 0.0, front: None };
        course.gap(core, &other, 0.0).is_none()
    };
    triangles.into_iter().find(touch).or_else(|| {
        // A that touches no triangle is inside as a whole or not at all.
        let middle = place.point(a.bounds().center());
        let above = surface.cover(middle)?;
        (surface.normal(above).dot(middle - surface.corners(above)[0]) < 0.0).then_some(above)
    })
}

/// The deepest contact with a surface.
fn deepest(a: &Shape, b: &Shape, b_in_a: &Isometry) -> Option<Distance> {
    let mut manifolds: Vec<Manifold> = Vec::new();
    collide(a, b, b_in_a, 0.0, &mut Cache::default(), &mut manifolds);
    let mut best: Option<Distance> = None;
    for manifold in &manifolds {
        for point in &manifold.points[..manifold.count as usize] {
            if best.is_none_or(|known| point.distance < known.distance) {
                let half = 0.5 * point.distance * manifold.normal;
                let (on_a, on_b) = (point.position - half, point.position + half);
                best = Some(Distance { distance: point.distance, normal: manifold.normal, on_a, on_b });
            }
        }
    }
    best.filter(|d| d.distance <= 0.0)
}

/// The overlap with a triangle that contacts leave alone, as A comes from behind: out along the normal of the first one that it touches.
fn behind(a: &Shape, b: &Shape, a_in_b: &Isometry) -> Option<Distance> {
    let sweep = still(a_in_b);
    let core = Core::new(a, &sweep.a, 0.0)?;
    let triangle = touched(a, b, &core, &sweep)?;
    let (corners, front) = match b {
        Shape::Mesh(mesh) => (mesh.corners(triangle), Surface::normal(&**mesh, triangle)),
        Shape::Field(field) => (field.mesh().corners(triangle), Surface::normal(&**field.mesh(), triangle)),
        Shape::HeightField(field) => (field.corners(triangle), field.normal(triangle)),
        _ => return None,
    };
    let up = a_in_b.inverse_vector(front);
    let (lowest, normal) = (core.set.lowest(up)?, -up);
    let height = front.dot(a_in_b.point(lowest) - corners[0]);
    let distance = (height - core.radius).min(0.0);
    let on_a = lowest + core.radius * normal;
    Some(Distance { distance, normal, on_a, on_b: on_a + distance * normal })
}
