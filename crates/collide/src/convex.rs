//! Which function is for which pair of convex shapes.
//!
//! Each pair is handled in one order: half-space, hull, box, capsule, sphere. The other order is that one, seen from
//! the other side.

use crate::closest::Closest;
use crate::half_space::HalfSpace;
use crate::poly::{BoxPoly, Poly};
use crate::round::{self, Capsule};
use crate::{Cache, Manifold, box_box, core_poly, polyhedra, sphere_box};
use rockfall_math::{Isometry, Vec3};
use rockfall_shape::Shape;

/// A convex shape, ready for its pair function.
#[derive(Clone, Copy)]
enum Convex<'a> {
    HalfSpace(HalfSpace),
    Hull(Poly<'a>),
    Box(Vec3),
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
            Shape::Box { half } => Convex::Box(*half),
            Shape::Capsule { half_length, radius } => {
                Convex::Capsule(Capsule { half_length: *half_length, radius: *radius })
            }
            Shape::Sphere { radius } => Convex::Sphere(*radius),
            Shape::Mesh(_) | Shape::HeightField(_) => return None,
        })
    }

    fn rank(&self) -> u32 {
        match self {
            Convex::HalfSpace(_) => 0,
            Convex::Hull(_) => 1,
            Convex::Box(_) => 2,
            Convex::Capsule(_) => 3,
            Convex::Sphere(_) => 4,
        }
    }
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
    let center = b_in_a.translation;
    let manifold = match (a, b) {
        (Box(a), Box(b)) => return box_box::collide(*a, *b, b_in_a, margin, cache, out),
        (Hull(a), Hull(b)) => return polyhedra::collide(a, b, b_in_a, margin, cache, out),
        (Hull(a), Box(b)) => {
            return polyhedra::collide(a, &BoxPoly::new(*b).poly(), b_in_a, margin, cache, out);
        }
        (Box(a), Sphere(b)) => {
            return single(sphere_box::point(*a, center).with_skins(0.0, *b), margin, out);
        }
        (Capsule(a), Sphere(b)) => return single(round::capsule_sphere(*a, *b, b_in_a), margin, out),
        (Sphere(a), Sphere(b)) => return single(round::spheres(*a, *b, b_in_a), margin, out),
        (HalfSpace(a), Hull(b)) => a.poly_manifold(b, b_in_a, margin),
        (HalfSpace(a), Box(b)) => a.poly_manifold(&BoxPoly::new(*b).poly(), b_in_a, margin),
        (HalfSpace(a), Capsule(b)) => a.manifold(&b.core(), b.radius, b_in_a, margin),
        (HalfSpace(a), Sphere(b)) => a.manifold(&[Vec3::ZERO], *b, b_in_a, margin),
        (Hull(a), Capsule(b)) => core_poly::capsule_manifold(a, b.placed_core(b_in_a), b.radius, margin),
        (Hull(a), Sphere(b)) => core_poly::point(a, center, margin + b)
            .map(|c| c.with_skins(0.0, *b))
            .filter(|c| c.distance <= margin)
            .map(|c| c.manifold()),
        (Box(a), Capsule(b)) => {
            let core = b.placed_core(b_in_a);
            core_poly::capsule_manifold(&BoxPoly::new(*a).poly(), core, b.radius, margin)
        }
        (Capsule(a), Capsule(b)) => round::capsules_manifold(*a, *b, b_in_a, margin),
        // Two half-spaces; no other pair is out of order.
        _ => None,
    };
    out.extend(manifold);
    0.0
}

/// The manifold of two nearest points within `margin`, or their distance.
fn single(closest: Closest, margin: f32, out: &mut Vec<Manifold>) -> f32 {
    if closest.distance > margin {
        return closest.distance;
    }
    out.push(closest.manifold());
    0.0
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
        (Hull(a), Sphere(b)) => core_poly::point(a, center, far).map(|c| c.with_skins(0.0, *b)),
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
