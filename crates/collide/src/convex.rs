//! Which function is for which pair of convex shapes.
//!
//! Each pair is handled in one order: half-space, hull, box, cylinder or cone, ellipsoid, capsule, sphere. The other
//! order is that one, seen from the other side. Rounded hulls and boxes are hulls and boxes with a skin.

use crate::closest::Closest;
use crate::form::{Form, Solid};
use crate::half_space::HalfSpace;
use crate::poly::{BoxPoly, Poly};
use crate::round::{self, Capsule};
use crate::{Cache, Manifold, box_box, core_poly, ellipsoid, frustum, patch, polyhedra, sphere_box};
use rockfall_math::{Isometry, Vec3};
use rockfall_shape::{Frustum, Shape};

/// A convex shape, ready for its pair function.
#[derive(Clone, Copy)]
enum Convex<'a> {
    HalfSpace(HalfSpace),
    Hull(Poly<'a>),
    RoundedHull(Poly<'a>, f32),
    Box(Vec3),
    RoundedBox(Vec3, f32),
    Frustum(Frustum),
    /// Half axes.
    Ellipsoid(Vec3),
    Capsule(Capsule),
    Sphere(f32),
}

impl<'a> Convex<'a> {
    fn of(shape: &'a Shape) -> Option<Self> {
        Some(match shape {
            Shape::HalfSpace { normal, offset } => {
                Convex::HalfSpace(HalfSpace { normal: *normal, offset: *offset })
            }
            Shape::Hull(hull) => Convex::Hull(Poly::from(&**hull)),
            Shape::RoundedHull { hull, radius } => Convex::RoundedHull(Poly::from(&**hull), *radius),
            Shape::Box { half } => Convex::Box(*half),
            Shape::RoundedBox { half, radius } => Convex::RoundedBox(*half, *radius),
            Shape::Cylinder { .. } | Shape::Cone { .. } => Convex::Frustum(Frustum::of(shape)?),
            Shape::Ellipsoid { half } => Convex::Ellipsoid(*half),
            Shape::Capsule { half_length, radius } => {
                Convex::Capsule(Capsule { half_length: *half_length, radius: *radius })
            }
            Shape::Sphere { radius } => Convex::Sphere(*radius),
            Shape::Mesh(_) | Shape::Field(_) | Shape::HeightField(_) | Shape::Compound(_) => return None,
        })
    }

    fn rank(&self) -> u32 {
        match self {
            Convex::HalfSpace(_) => 0,
            Convex::Hull(_) => 1,
            Convex::RoundedHull(..) => 2,
            Convex::Box(_) => 3,
            Convex::RoundedBox(..) => 4,
            Convex::Frustum(_) => 5,
            Convex::Ellipsoid(_) => 6,
            Convex::Capsule(_) => 7,
            Convex::Sphere(_) => 8,
        }
    }

    /// For the general functions; nothing for half-spaces.
    fn solid(&self) -> Option<Solid<'a>> {
        Some(match *self {
            Convex::HalfSpace(_) => return None,
            Convex::Hull(poly) => Solid::new(Form::Hull(poly), 0.0),
            Convex::RoundedHull(poly, radius) => Solid::new(Form::Hull(poly), radius),
            Convex::Box(half) => Solid::new(Form::Box(BoxPoly::new(half)), 0.0),
            Convex::RoundedBox(half, radius) => Solid::new(Form::Box(BoxPoly::new(half)), radius),
            Convex::Frustum(frustum) => Solid::new(Form::Frustum(frustum), 0.0),
            Convex::Ellipsoid(half) => Solid::new(Form::Ellipsoid(half), 0.0),
            Convex::Capsule(Capsule { half_length, radius }) => {
                Solid::new(Form::Segment(half_length), radius)
            }
            Convex::Sphere(radius) => Solid::new(Form::Segment(0.0), radius),
        })
    }

    /// What a rounded shape was before it has grown, and by how much.
    fn without_skin(&self) -> (Convex<'a>, f32) {
        match *self {
            Convex::RoundedHull(poly, radius) => (Convex::Hull(poly), radius),
            Convex::RoundedBox(half, radius) => (Convex::Box(half), radius),
            other => (other, 0.0),
        }
    }

    /// Whether it is round with a flat end, or round with three half axes.
    fn is_smooth(&self) -> bool {
        matches!(self, Convex::Frustum(_) | Convex::Ellipsoid(_))
    }
}

/// A bounded convex shape for the general functions.
pub(crate) fn solid(shape: &Shape) -> Option<Solid<'_>> {
    Convex::of(shape)?.solid()
}

/// Appends the manifold of two convex shapes if they come within `margin`. Returns how far apart they are at least, as far
/// as that is known.
#[inline]
pub(crate) fn collide(
    a: &Shape,
    b: &Shape,
    b_in_a: &Isometry,
    margin: f32,
    cache: &mut Cache,
    out: &mut Vec<Manifold>,
) -> f32 {
    if let (Shape::Box { half: a }, Shape::Box { half: b }) = (a, b) {
        return box_box::collide(*a, *b, b_in_a, margin, cache, out);
    }
    let (Some(a), Some(b)) = (Convex::of(a), Convex::of(b)) else { return 0.0 };
    if a.rank() <= b.rank() {
        in_order(&a, &b, b_in_a, margin, cache, out)
    } else {
        let start = out.len();
        let apart = in_order(&b, &a, &b_in_a.inverse(), margin, cache, out);
        for manifold in &mut out[start..] {
            manifold.swap(b_in_a);
        }
        apart
    }
}

fn in_order(
    a: &Convex,
    b: &Convex,
    b_in_a: &Isometry,
    margin: f32,
    cache: &mut Cache,
    out: &mut Vec<Manifold>,
) -> f32 {
    use Convex::{Box, Capsule, HalfSpace, Hull, Sphere};
    if a.is_smooth() || b.is_smooth() {
        return match (a, a.solid(), b.solid()) {
            (HalfSpace(a), _, Some(b)) => put(patch::on_half_space(a, &b, b_in_a, margin), out),
            (_, Some(a), Some(b)) => smooth(&a, &b, b_in_a, margin, cache, out),
            _ => 0.0,
        };
    }
    let ((core_a, skin_a), (core_b, skin_b)) = (a.without_skin(), b.without_skin());
    if skin_a + skin_b > 0.0 {
        let start = out.len();
        let apart = in_order(&core_a, &core_b, b_in_a, margin + skin_a + skin_b, cache, out);
        for manifold in &mut out[start..] {
            manifold.grow(skin_a, skin_b);
        }
        return (apart - (skin_a + skin_b)).max(0.0);
    }
    let center = b_in_a.translation;
    let found = match (a, b) {
        (Box(a), Box(b)) => return box_box::collide(*a, *b, b_in_a, margin, cache, out),
        (Hull(a), Hull(b)) => return polyhedra::collide(a, b, b_in_a, margin, cache, out),
        (Hull(a), Box(b)) => {
            return polyhedra::collide(a, &BoxPoly::new(*b).poly(), b_in_a, margin, cache, out);
        }
        (Box(a), Sphere(b)) => within(sphere_box::point(*a, center).with_skins(0.0, *b), margin),
        (Capsule(a), Sphere(b)) => within(round::capsule_sphere(*a, *b, b_in_a), margin),
        (Sphere(a), Sphere(b)) => within(round::spheres(*a, *b, b_in_a), margin),
        (HalfSpace(a), Hull(b)) => a.poly_manifold(b, b_in_a, margin),
        (HalfSpace(a), Box(b)) => a.poly_manifold(&BoxPoly::new(*b).poly(), b_in_a, margin),
        (HalfSpace(a), Capsule(b)) => a.manifold(&b.core(), b.radius, b_in_a, margin),
        (HalfSpace(a), Sphere(b)) => a.manifold(&[Vec3::ZERO], *b, b_in_a, margin),
        (Hull(a), Capsule(b)) => {
            core_poly::capsule_manifold(a, b.placed_core(b_in_a), b.radius, margin, cache)
        }
        (Hull(a), Sphere(b)) => core_poly::point(a, center, margin + b)
            .map_err(|apart| apart - b)
            .and_then(|c| within(c.with_skins(0.0, *b), margin)),
        (Box(a), Capsule(b)) => {
            let core = b.placed_core(b_in_a);
            core_poly::capsule_manifold(&BoxPoly::new(*a).poly(), core, b.radius, margin, cache)
        }
        (Capsule(a), Capsule(b)) => round::capsules_manifold(*a, *b, b_in_a, margin),
        // Two half-spaces; no other pair is out of order.
        _ => Err(0.0),
    };
    put(found, out)
}

/// A cylinder, a cone or an ellipsoid, and any bounded shape.
fn smooth(
    a: &Solid,
    b: &Solid,
    b_in_a: &Isometry,
    margin: f32,
    cache: &mut Cache,
    out: &mut Vec<Manifold>,
) -> f32 {
    match smooth_and_ball(a, b, b_in_a) {
        Some(closest) => put(within(closest, margin), out),
        None => patch::collide(a, b, b_in_a, margin, cache, out),
    }
}

/// The closed forms.
fn smooth_and_ball(a: &Solid, b: &Solid, b_in_a: &Isometry) -> Option<Closest> {
    let center = b_in_a.translation;
    match (&a.form, &b.form) {
        (Form::Frustum(a), Form::Segment(0.0)) => Some(frustum::point(a, center)),
        (Form::Ellipsoid(a), Form::Segment(0.0)) => Some(ellipsoid::point(*a, center)),
        _ => None,
    }
    .map(|c| c.with_skins(a.skin, b.skin))
}

/// Appends a manifold, or says how far apart the shapes are at least.
pub(crate) fn put(found: Result<Manifold, f32>, out: &mut Vec<Manifold>) -> f32 {
    match found {
        Ok(manifold) => {
            out.push(manifold);
            0.0
        }
        Err(apart) => apart.max(0.0),
    }
}

/// The manifold of two nearest points within `margin`, or their distance.
pub(crate) fn within(closest: Closest, margin: f32) -> Result<Manifold, f32> {
    if closest.distance > margin { Err(closest.distance) } else { Ok(closest.manifold()) }
}

/// Signed distance of two convex shapes.
pub(crate) fn closest(a: &Shape, b: &Shape, b_in_a: &Isometry) -> Option<Closest> {
    let (a, b) = (Convex::of(a)?, Convex::of(b)?);
    if a.rank() <= b.rank() {
        closest_in_order(&a, &b, b_in_a)
    } else {
        closest_in_order(&b, &a, &b_in_a.inverse()).map(|c| c.swapped(b_in_a))
    }
}

fn closest_in_order(a: &Convex, b: &Convex, b_in_a: &Isometry) -> Option<Closest> {
    use Convex::{Box, Capsule, HalfSpace, Hull, Sphere};
    if a.is_smooth() || b.is_smooth() {
        return match (a, a.solid(), b.solid()) {
            (HalfSpace(a), _, Some(b)) => Some(patch::half_space_closest(a, &b, b_in_a)),
            (_, Some(a), Some(b)) => {
                smooth_and_ball(&a, &b, b_in_a).or_else(|| patch::closest(&a, &b, b_in_a))
            }
            _ => None,
        };
    }
    let ((core_a, skin_a), (core_b, skin_b)) = (a.without_skin(), b.without_skin());
    if skin_a + skin_b > 0.0 {
        return closest_in_order(&core_a, &core_b, b_in_a).map(|c| c.with_skins(skin_a, skin_b));
    }
    let far = f32::INFINITY;
    let center = b_in_a.translation;
    match (a, b) {
        (HalfSpace(a), Hull(b)) => Some(a.closest(b.vertices, 0.0, b_in_a)),
        (HalfSpace(a), Box(b)) => Some(a.closest(BoxPoly::new(*b).poly().vertices, 0.0, b_in_a)),
        (HalfSpace(a), Capsule(b)) => Some(a.closest(&b.core(), b.radius, b_in_a)),
        (HalfSpace(a), Sphere(b)) => Some(a.closest(&[Vec3::ZERO], *b, b_in_a)),
        (Hull(a), Hull(b)) => Some(polyhedra::closest(a, b, b_in_a)),
        (Hull(a), Box(b)) => Some(polyhedra::closest(a, &BoxPoly::new(*b).poly(), b_in_a)),
        (Hull(a), Capsule(b)) => {
            core_poly::segment(a, b.placed_core(b_in_a), far).map(|c| c.with_skins(0.0, b.radius))
        }
        (Hull(a), Sphere(b)) => core_poly::point(a, center, far).ok().map(|c| c.with_skins(0.0, *b)),
        (Box(a), Box(b)) => {
            Some(polyhedra::closest(&BoxPoly::new(*a).poly(), &BoxPoly::new(*b).poly(), b_in_a))
        }
        (Box(a), Capsule(b)) => {
            let core = b.placed_core(b_in_a);
            core_poly::segment(&BoxPoly::new(*a).poly(), core, far).map(|c| c.with_skins(0.0, b.radius))
        }
        (Box(a), Sphere(b)) => Some(sphere_box::point(*a, center).with_skins(0.0, *b)),
        (Capsule(a), Capsule(b)) => Some(round::capsules(*a, *b, b_in_a)),
        (Capsule(a), Sphere(b)) => Some(round::capsule_sphere(*a, *b, b_in_a)),
        (Sphere(a), Sphere(b)) => Some(round::spheres(*a, *b, b_in_a)),
        // Two half-spaces; no other pair is out of order.
        _ => None,
    }
}
