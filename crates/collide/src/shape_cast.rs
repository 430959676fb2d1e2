//! Where a shape on a straight way first touches another.
//!
//! The same conservative advancement as [`time_of_impact`](crate::time_of_impact), asked another question. That function stops bodies at what they
//! would pass *through*, and leaves what only touches to contacts; a cast tells of the first touch, from either side of a triangle.

use crate::surface::Surface;
use crate::time_of_impact::{Core, Course, MAX_PIECES, Other, Set};
use crate::{Motion, Sweep, Toi, compound, overlap};
use rockfall_math::{Isometry, Vec3};
use rockfall_shape::Shape;

/// Where the bounded convex shape `a`, or a compound of such, which `a_in_b` places in the frame of `b`, first touches `b` when it moves by `translation` (metres)
/// without turning. All of the result is in the frame of `b`. Shapes that overlap from the start touch at time 0, with the overlap as a negative distance if
/// that is known; shapes that only touch there do if A moves towards B.
///
/// The answer is never late; it may be early by some millionths of the way and of the sizes.
///
/// Nothing where A is neither, or a number is not finite.
///
/// # Examples
/// ```
/// use rockfall_collide::cast_shape;
/// use rockfall_math::{Isometry, Vec3};
/// use rockfall_shape::Shape;
///
/// let (ball, cube) = (Shape::Sphere { radius: 0.5 }, Shape::Box { half: Vec3::ONE });
/// let start = Isometry { translation: Vec3::new(-4.0, 0.0, 0.0), ..Isometry::IDENTITY };
/// let hit = cast_shape(&ball, &cube, &start, 5.0 * Vec3::X).expect("it is aimed at the cube");
/// assert!((hit.time - 0.5).abs() < 1e-5);
/// assert_eq!(cast_shape(&ball, &cube, &start, 2.0 * Vec3::X), None);
/// ```
pub fn cast_shape(a: &Shape, b: &Shape, a_in_b: &Isometry, translation: Vec3) -> Option<Toi> {
    if !crate::is_finite(a_in_b) || !translation.is_finite() {
        return None;
    }
    if compound::takes_part(a, b) {
        return compound::cast_shape(a, b, a_in_b, translation);
    }
    if !a.is_convex() {
        return None;
    }
    let center = a.bounds().center();
    let sweep = Sweep {
        a: Motion { start: *a_in_b, center, translation, rotation: Vec3::ZERO },
        b: Motion::at_rest(Isometry::IDENTITY),
    };
    let core = Core::new(a, &sweep.a, 0.0)?;
    if let Some(toi) = overlap::from_the_start(a, b, &core, &sweep) {
        return Some(toi);
    }
    // Without an inner radius whatever closes is an impact.
    let course = Course { sweep: &sweep, inner: 0.0, target: 0.0 };
    match b {
        Shape::Mesh(mesh) => surface(&course, &core, &**mesh),
        Shape::Field(field) => surface(&course, &core, &**field.mesh()),
        Shape::HeightField(field) => surface(&course, &core, &**field),
        Shape::HalfSpace { normal, offset } => {
            course.advance(&core, &Other::HalfSpace { normal: *normal, offset: *offset }, 0.0, 1.0)
        }
        _ => course.advance(&core, &Core::new(b, &sweep.b, 0.0)?.as_other(), 0.0, 1.0),
    }
}

/// The first touch of a triangle, piece by piece of the way.
fn surface<S: Surface>(course: &Course, core: &Core, surface: &S) -> Option<Toi> {
    let length = course.sweep.a.translation.length();
    let pieces = ((length / (2.0 * core.reach)).ceil() as usize).clamp(1, MAX_PIECES);
    let mut triangles = Vec::new();
    for piece in 0..pieces {
        let [from, until] = [piece, piece + 1].map(|k| k as f32 / pieces as f32);
        triangles.clear();
        surface.near(&course.passed(core, from, until), |triangle| triangles.push(triangle));
        triangles.sort_unstable();
        let mut best: Option<Toi> = None;
        for &triangle in &triangles {
            let set = Set::Points(surface.corners(triangle).into_iter().collect());
            let other = Other::Convex { set: &set, radius: 0.0, arm: 0.0, front: None };
            let limit = best.map_or(until, |toi| toi.time);
            if let Some(toi) = course.advance(core, &other, from, limit)
                && best.is_none_or(|first| toi.time < first.time)
            {
                best = Some(toi);
            }
        }
        if best.is_some() {
            return best;
        }
    }
    None
}
