//! Pure functions over pairs of shapes: contact manifolds, signed distance, casts.
//!
//! Every function sees shape B from the frame of shape A; nothing here knows bodies or the world. Normals are unit
//! vectors from A to B. A signed distance is negative where the shapes overlap.
//!
//! Each pair of shapes has the method that is exact for it: closed forms for round shapes, separating axes and
//! clipped faces for boxes and hulls, the simplex walk of Gilbert, Johnson and Keerthi where the nearest features
//! are corners and edges; cylinders, cones and ellipsoids have that walk too, and an expanding polytope where they overlap. Signed distance
//! fields are measured at points of the other surface.
//! Many pairs at once go side by side in the lanes of vectors, see [`collide_all`].
//! The results depend on the arguments alone, to the last bit.

#![forbid(unsafe_code)]

mod box_box;
mod clip;
mod closest;
mod compound;
mod convex;
mod core_poly;
mod direction;
mod ellipsoid;
mod feature;
mod field;
mod form;
mod frustum;
mod gjk;
mod half_space;
mod manifold;
mod many;
mod mesh;
mod overlap;
mod passage;
mod patch;
mod penetration;
mod point;
mod poly;
mod polyhedra;
mod ray;
mod reduce;
mod round;
mod sat;
mod segments;
mod shape_cast;
mod sphere_box;
mod surface;
mod time_of_impact;

pub use closest::Distance;
pub use manifold::{Cache, ContactPoint, Manifold};
pub use many::{Meeting, Met, collide_all};
pub use overlap::{overlaps, penetration};
pub use passage::passage;
pub use point::{Nearest, nearest_point};
pub use ray::{INSIDE, Ray, RayHit, cast_ray, cast_ray_by_distance};
pub use shape_cast::cast_shape;
pub use surface::{convex_height_field, convex_mesh};
pub use time_of_impact::{Motion, Sweep, Toi, time_of_impact};

use rockfall_math::Isometry;
use rockfall_shape::Shape;

/// Appends to `out` the manifolds of two shapes whose points have a signed distance of at most `margin` metres (not
/// negative): none or one for a convex pair, any number for a convex shape and a surface, for a field and anything else, where a compound takes part, and for two meshes or a mesh and a height field; for those nothing where none has an inside.
/// `b_in_a` places B in A's frame, and all of the result is in A's frame.
///
/// `cache` belongs to the pair. It makes the next call faster, and keeps the face and the corners of two boxes while others are no better:
/// by 0.06 % of the smaller box's largest half extent and 0.15 % of the overlap, of corners by a fourth of a thousandth of their span; and, where boxes and hulls
/// overlap deeply, the corners that hold them. Two half-spaces have no
/// manifold, and neither has a shape in a place that is not finite. Of shapes that are further than 1e7 m from each other
/// single precision tells nothing, and the result may be anything.
///
/// Returns a distance by which the shapes are surely apart, metres, to rounding: their distance or less; 0 where that is
/// not known without more work.
///
/// # Examples
/// ```
/// use rockfall_collide::{Cache, collide};
/// use rockfall_math::{Isometry, Vec3};
/// use rockfall_shape::Shape;
///
/// let ground = Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 };
/// let cube = Shape::Box { half: Vec3::splat(0.5) };
/// let pose = Isometry { translation: Vec3::new(0.0, 0.0, 0.49), ..Isometry::IDENTITY };
/// let mut manifolds = Vec::new();
/// collide(&ground, &cube, &pose, 0.01, &mut Cache::default(), &mut manifolds);
/// assert_eq!((manifolds.len(), manifolds[0].count, manifolds[0].normal), (1, 4, Vec3::Z));
/// assert!((manifolds[0].deepest() + 0.01).abs() < 1e-6);
/// ```
pub fn collide(
    a: &Shape,
    b: &Shape,
    b_in_a: &Isometry,
    margin: f32,
    cache: &mut Cache,
    out: &mut Vec<Manifold>,
) -> f32 {
    if !is_finite(b_in_a) {
        return 0.0;
    }
    match (a, b) {
        (Shape::Compound(_), _) | (_, Shape::Compound(_)) => {
            compound::collide(a, b, b_in_a, margin, cache, out)
        }
        _ if mesh::takes(a, b) => mesh::collide(a, b, b_in_a, margin, cache, out),
        (Shape::Field(_), _) | (_, Shape::Field(_)) => field::collide(a, b, b_in_a, margin, cache, out),
        (_, Shape::Mesh(mesh)) => convex_mesh(a, mesh, b_in_a, margin, out),
        (_, Shape::HeightField(field)) => convex_height_field(a, field, b_in_a, margin, out),
        (Shape::Mesh(_) | Shape::HeightField(_), _) => {
            let first = out.len();
            let apart = collide(b, a, &b_in_a.inverse(), margin, cache, out);
            for manifold in &mut out[first..] {
                manifold.swap(b_in_a);
            }
            apart
        }
        _ => convex::collide(a, b, b_in_a, margin, cache, out),
    }
}

/// Signed distance of two convex shapes or of a convex shape and a half-space, exact to rounding: where they
/// overlap, minus the length of the shortest translation that parts them. `b_in_a` places B in A's frame.
///
/// Of compounds it is the distance of the two parts that are nearest or overlap most: the way that parts them all may be longer.
///
/// Nothing for two half-spaces, for meshes, fields and height fields, and for a place that is not finite.
///
/// # Examples
/// ```
/// use rockfall_collide::distance;
/// use rockfall_math::{Isometry, Vec3};
/// use rockfall_shape::Shape;
///
/// let (ball, cube) = (Shape::Sphere { radius: 1.0 }, Shape::Box { half: Vec3::ONE });
/// let pose = Isometry { translation: Vec3::new(4.0, 0.0, 0.0), ..Isometry::IDENTITY };
/// let d = distance(&ball, &cube, &pose).expect("both are convex");
/// assert_eq!((d.distance, d.normal, d.on_a), (2.0, Vec3::X, Vec3::X));
/// ```
pub fn distance(a: &Shape, b: &Shape, b_in_a: &Isometry) -> Option<Distance> {
    match (a, b) {
        _ if !is_finite(b_in_a) => None,
        (Shape::Compound(_), _) | (_, Shape::Compound(_)) => compound::distance(a, b, b_in_a),
        _ => convex::closest(a, b, b_in_a).map(Distance::from),
    }
}

fn is_finite(pose: &Isometry) -> bool {
    let r = &pose.rotation;
    // A sum is finite only if its terms are (and large ones do not come near overflow in a place that makes sense).
    (r.x_axis + r.y_axis + r.z_axis + pose.translation).is_finite()
}
