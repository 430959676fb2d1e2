//! Colliders as files describe them, and what becomes of them under a map that turns, stretches, mirrors and shears.

use crate::affine::{Affine, Frame, settle};
use crate::content::Geometry;
use crate::mesh_file::TriangleSoup;
use rockfall_math::{DMat3, DQuat, DVec3, Vec3};
use std::sync::Arc;

/// A collider in its own frame, in the units of the file; round ones have their axis along z.
#[derive(Clone, Debug)]
pub(crate) enum Form {
    Ball {
        radius: f64,
    },
    Cuboid {
        half: DVec3,
    },
    Capsule {
        half_length: f64,
        radius: f64,
    },
    /// A cylinder, a cone or a truncated cone.
    Cone {
        half_length: f64,
        lower: f64,
        upper: f64,
    },
    /// Everything below z = 0.
    Plane,
    Mesh {
        soup: Arc<TriangleSoup>,
        as_what: Approximation,
    },
}

/// What stands for a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Approximation {
    Triangles,
    Hull,
    Decomposition { max_hulls: Option<u32> },
    Field { resolution: u32 },
    Cube,
    Sphere,
}

/// Geometry in meters, its place in the body's frame, and what of it is not exact.
#[derive(Debug)]
pub(crate) struct Baked {
    pub(crate) geometry: Geometry,
    pub(crate) place: Frame,
    pub(crate) inexact: Option<&'static str>,
}

/// Axes are at right angles where their cosine is below this.
const SQUARE: f64 = 1e-6;
/// Lengths are the same where they differ by less than this part.
const EVEN: f64 = 1e-6;
/// Corners around a round form that is stretched out of round.
const AROUND: usize = 32;
/// Rings of corners from pole to equator of a half ball that is stretched.
const RINGS: usize = 4;

/// A map taken apart: how long the images of the axes are, and a rotation, where they are at right angles.
struct Stretch {
    lengths: DVec3,
    rotation: DQuat,
}

impl Stretch {
    fn of(linear: &DMat3) -> Option<Stretch> {
        let [x, y, z] = [linear.x_axis, linear.y_axis, linear.z_axis];
        let lengths = DVec3::new(x.length(), y.length(), z.length());
        let square = |a: DVec3, b: DVec3| a.dot(b).abs() <= SQUARE * a.length() * b.length();
        if !(square(x, y) && square(y, z) && square(z, x)) {
            return None;
        }
        // What is mirrored is mirrored along x, which changes none of the forms that have a stretch.
        let side = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
        let axes = DMat3::from_cols(x * side / lengths.x, y / lengths.y, z / lengths.z);
        Some(Stretch { lengths, rotation: settle(DQuat::from_mat3(&axes)) })
    }

    fn is_even(&self) -> bool {
        self.is_round() && even(self.lengths.x, self.lengths.z)
    }

    /// Whether x and y are stretched alike.
    fn is_round(&self) -> bool {
        even(self.lengths.x, self.lengths.y)
    }
}

fn even(a: f64, b: f64) -> bool {
    (a - b).abs() <= EVEN * a.max(b)
}

impl Form {
    /// What the form is where `map` takes it.
    ///
    /// # Errors
    /// Why there is nothing to collide with.
    pub(crate) fn bake(&self, map: &Affine) -> Result<Baked, &'static str> {
        if !map.is_finite() {
            return Err("its place is not finite");
        }
        if map.frame().is_none() {
            return Err("it is scaled to nothing");
        }
        let stretch = Stretch::of(&map.linear);
        let rotation = stretch.as_ref().map_or(DQuat::IDENTITY, |s| s.rotation);
        let place = Frame { position: map.translation, rotation };
        let exact = |geometry| Ok(Baked { geometry, place, inexact: None });
        let hull = |points: &mut dyn Iterator<Item = DVec3>, inexact| {
            let points = points.map(|p| map.point(p).as_vec3()).collect();
            Ok(Baked { geometry: Geometry::Hull(points), place: Frame::IDENTITY, inexact })
        };
        let round = Some("stretched out of round: taken as a hull");
        match (self, stretch) {
            (Form::Ball { radius }, Some(s)) if s.is_even() => {
                exact(Geometry::Sphere { radius: (radius * s.lengths.x) as f32 })
            }
            (Form::Ball { radius }, Some(s)) => {
                exact(Geometry::Ellipsoid { half: (*radius * s.lengths).as_vec3() })
            }
            (Form::Ball { radius }, None) => hull(&mut capsule(0.0, *radius), round),
            (Form::Cuboid { half }, Some(s)) => exact(Geometry::Box { half: (*half * s.lengths).as_vec3() }),
            (Form::Cuboid { half }, None) => hull(&mut corners(-*half, *half).into_iter(), None),
            (Form::Capsule { half_length, radius }, Some(s)) if s.is_even() => exact(Geometry::Capsule {
                half_length: (half_length * s.lengths.z) as f32,
                radius: (radius * s.lengths.x) as f32,
            }),
            (Form::Capsule { half_length, radius }, _) => hull(&mut capsule(*half_length, *radius), round),
            (Form::Cone { half_length, lower, upper }, Some(s)) if s.is_round() => exact(Geometry::Cone {
                half_length: (half_length * s.lengths.z) as f32,
                lower: (lower * s.lengths.x) as f32,
                upper: (upper * s.lengths.x) as f32,
            }),
            (Form::Cone { half_length, lower, upper }, _) => {
                let rings = [(-half_length, *lower), (*half_length, *upper)];
                hull(&mut rings.into_iter().flat_map(|(z, r)| ring(z, r)), round)
            }
            (Form::Plane, _) => {
                // The images of x and y span the plane; z tells the side.
                let normal = map.linear.x_axis.cross(map.linear.y_axis);
                let side = if normal.dot(map.linear.z_axis) < 0.0 { -normal } else { normal };
                let (place, geometry) = (half_space(map.translation, side.normalize()), Geometry::HalfSpace);
                Ok(Baked { geometry, place, inexact: None })
            }
            (Form::Mesh { soup, as_what }, _) => mesh(soup, *as_what, map),
        }
    }
}

/// The frame whose z axis is `normal`.
fn half_space(position: DVec3, normal: DVec3) -> Frame {
    let side = if normal.x.abs() < 0.9 { DVec3::X } else { DVec3::Y };
    let x = if normal == DVec3::Z { DVec3::X } else { normal.cross(side).normalize() };
    let rotation = settle(DQuat::from_mat3(&DMat3::from_cols(x, normal.cross(x), normal)));
    Frame { position, rotation }
}

fn corners(low: DVec3, high: DVec3) -> [DVec3; 8] {
    std::array::from_fn(|i| {
        let pick = |bit: usize, low: f64, high: f64| if i >> bit & 1 == 0 { low } else { high };
        DVec3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z))
    })
}

/// Points on a circle about z; one point where it has no width.
fn ring(z: f64, radius: f64) -> impl Iterator<Item = DVec3> {
    let count = if radius == 0.0 { 1 } else { AROUND };
    (0..count).map(move |k| {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * k as f64 / AROUND as f64);
        DVec3::new(radius * cos, radius * sin, z)
    })
}

/// Points on a capsule.
fn capsule(half_length: f64, radius: f64) -> impl Iterator<Item = DVec3> {
    [-1.0, 1.0].into_iter().flat_map(move |side| {
        (0..=RINGS).flat_map(move |k| {
            let (sin, cos) = libm::sincos(std::f64::consts::FRAC_PI_2 * k as f64 / RINGS as f64);
            let width = if k == RINGS { 0.0 } else { radius * cos };
            ring(side * (half_length + radius * sin), width)
        })
    })
}

fn mesh(soup: &TriangleSoup, as_what: Approximation, map: &Affine) -> Result<Baked, &'static str> {
    let low = soup.vertices.iter().fold(Vec3::INFINITY, |a, b| a.min(*b)).as_dvec3();
    let high = soup.vertices.iter().fold(Vec3::NEG_INFINITY, |a, b| a.max(*b)).as_dvec3();
    let middle = 0.5 * (low + high);
    if as_what == Approximation::Cube {
        let moved = map.after(&Affine::translation(middle));
        return Form::Cuboid { half: 0.5 * (high - low) }.bake(&moved);
    }
    let moved = |p: &Vec3| map.point(p.as_dvec3());
    if as_what == Approximation::Sphere {
        let center = map.point(middle);
        let radius = soup.vertices.iter().map(|p| (moved(p) - center).length()).fold(0.0, f64::max) as f32;
        let place = Frame { position: center, ..Frame::IDENTITY };
        return Ok(Baked { geometry: Geometry::Sphere { radius }, place, inexact: None });
    }
    let vertices = soup.vertices.iter().map(|p| moved(p).as_vec3()).collect();
    let mut soup = TriangleSoup { vertices, triangles: soup.triangles.clone() };
    if map.linear.determinant() < 0.0 {
        soup.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    let geometry = match as_what {
        Approximation::Hull => Geometry::Hull(soup.vertices),
        Approximation::Decomposition { max_hulls } => Geometry::Decomposition { soup, max_hulls },
        Approximation::Field { resolution } => Geometry::Field { soup, resolution },
        _ => Geometry::Mesh(soup),
    };
    Ok(Baked { geometry, place: Frame::IDENTITY, inexact: None })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scale(x: f64, y: f64, z: f64) -> Affine {
        Affine::linear(DMat3::from_diagonal(DVec3::new(x, y, z)))
    }

    fn turned(map: &Affine) -> Affine {
        Affine::translation(DVec3::new(1.0, -2.0, 3.0))
            .after(&Affine::rotation(DQuat::from_xyzw(0.1, 0.7, -0.3, 0.5)))
            .after(map)
    }

    #[test]
    fn a_ball_stretched_is_an_ellipsoid_and_sheared_a_hull() {
        let ball = Form::Ball { radius: 0.5 };
        let baked = ball.bake(&turned(&scale(2.0, 2.0, 2.0))).unwrap();
        assert_eq!(baked.geometry, Geometry::Sphere { radius: 1.0 });
        assert_eq!(baked.place.position, DVec3::new(1.0, -2.0, 3.0));
        let baked = ball.bake(&turned(&scale(2.0, -4.0, 6.0))).unwrap();
        let Geometry::Ellipsoid { half } = baked.geometry else { panic!("{:?}", baked.geometry) };
        assert!((half - Vec3::new(1.0, 2.0, 3.0)).length() < 1e-6);
        let shear = Affine::linear(DMat3::from_cols(DVec3::X, DVec3::new(0.5, 1.0, 0.0), DVec3::Z));
        let baked = ball.bake(&shear).unwrap();
        assert!(baked.inexact.is_some());
        // Points of the sheared ball, mapped back, are on the ball.
        let Geometry::Hull(points) = baked.geometry else { panic!("{:?}", baked.geometry) };
        let back = shear.inverse().unwrap();
        assert!(points.iter().all(|p| (back.point(p.as_dvec3()).length() - 0.5).abs() < 1e-6));
    }

    #[test]
    fn a_cone_keeps_its_tip_in_a_mirror() {
        let cone = Form::Cone { half_length: 1.0, lower: 1.0, upper: 0.0 };
        let baked = cone.bake(&scale(1.0, 1.0, -2.0)).unwrap();
        assert_eq!(baked.geometry, Geometry::Cone { half_length: 2.0, lower: 1.0, upper: 0.0 });
        assert!((baked.place.turn(DVec3::Z) + DVec3::Z).length() < 1e-12, "the tip is down");
        let baked = cone.bake(&turned(&scale(1.0, 1.5, 1.0))).unwrap();
        assert!(matches!(&baked.geometry, Geometry::Hull(points) if points.len() == AROUND + 1));
    }

    #[test]
    fn a_sheared_box_is_its_corners() {
        let shear = Affine::linear(DMat3::from_cols(DVec3::X, DVec3::new(0.5, 1.0, 0.0), DVec3::Z));
        let baked = Form::Cuboid { half: DVec3::ONE }.bake(&shear).unwrap();
        let Geometry::Hull(points) = baked.geometry else { panic!("{:?}", baked.geometry) };
        assert_eq!((points.len(), points[3], baked.inexact), (8, Vec3::new(1.5, 1.0, -1.0), None));
    }

    #[test]
    fn a_plane_stays_the_plane_that_it_spans() {
        for map in [scale(3.0, 2.0, 1.0), turned(&scale(1.0, -1.0, 1.0)), turned(&scale(1.0, 1.0, 5.0))] {
            let place = Form::Plane.bake(&map).unwrap().place;
            let up = place.turn(DVec3::Z);
            for p in [DVec3::new(5.0, 0.0, 0.0), DVec3::new(-1.0, 7.0, 0.0)] {
                assert!(up.dot(map.point(p) - place.position).abs() < 1e-9);
            }
            assert!(up.dot(map.point(DVec3::Z) - place.position) > 0.0);
        }
    }

    #[test]
    fn a_mesh_in_a_mirror_keeps_its_outside() {
        let soup = Arc::new(TriangleSoup {
            vertices: vec![Vec3::ZERO, Vec3::X, Vec3::Y],
            triangles: vec![[0, 1, 2]],
        });
        let form = |as_what| Form::Mesh { soup: soup.clone(), as_what };
        let baked = form(Approximation::Triangles).bake(&scale(-1.0, 1.0, 1.0)).unwrap();
        let Geometry::Mesh(mirrored) = baked.geometry else { panic!("{:?}", baked.geometry) };
        assert_eq!((mirrored.vertices[1], mirrored.triangles[0]), (-Vec3::X, [0, 2, 1]));
        let baked = form(Approximation::Sphere).bake(&scale(2.0, 2.0, 2.0)).unwrap();
        assert_eq!(baked.place.position, DVec3::new(1.0, 1.0, 0.0));
        assert_eq!(baked.geometry, Geometry::Sphere { radius: 2.0_f32.sqrt() });
    }

    #[test]
    fn nothing_is_made_of_what_is_flat() {
        assert!(Form::Ball { radius: 1.0 }.bake(&scale(1.0, 0.0, 1.0)).is_err());
        assert!(Form::Ball { radius: 1.0 }.bake(&scale(1.0, f64::INFINITY, 1.0)).is_err());
    }
}
