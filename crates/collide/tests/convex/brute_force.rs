//! Random poses, and an independent judge of distances: brute force over all features in double precision.

use crate::common::Random;
use rockfall_collide::{Cache, Manifold, collide};
use rockfall_math::{DVec3, Isometry, Mat3, Quat, Vec3, rotation};
use rockfall_shape::{Hull, Shape};
use std::sync::Arc;

impl Random {
    /// Any rotation; one time in two, one that puts edges along axes, turned by 1e-8 to 1e-1 radians or not at all.
    pub(crate) fn rotation(&mut self) -> Mat3 {
        let q = if self.word() & 1 == 0 {
            rotation::from_rotation_vector(self.direction() * self.between(0.0, std::f32::consts::PI))
        } else {
            let quarter = |axis: Vec3, turns: u64| {
                rotation::from_rotation_vector(axis * (turns % 4) as f32 * std::f32::consts::FRAC_PI_2)
            };
            let aligned = rotation::compose(quarter(Vec3::X, self.word()), quarter(Vec3::Z, self.word()));
            let angle = match self.word() % 9 {
                0 => 0.0,
                k => 10.0_f32.powi(-(k as i32)),
            };
            rotation::compose(rotation::from_rotation_vector(self.direction() * angle), aligned)
        };
        Mat3::from_quat(rotation::normalize(Quat::from_xyzw(q.x, q.y, q.z, q.w)))
    }

    pub(crate) fn hull(&mut self, corners: usize) -> Shape {
        loop {
            let radii = Vec3::new(self.between(0.3, 1.0), self.between(0.3, 1.0), self.between(0.3, 1.0));
            let points: Vec<Vec3> = (0..corners).map(|_| self.direction() * radii).collect();
            if let Ok(hull) = Hull::from_points(&points) {
                return Shape::Hull(Arc::new(hull));
            }
        }
    }

    /// A shape of the class: 0 sphere, 1 box, 2 capsule, 3 hull, 4 half-space,
    /// 5 plate or needle down to 0.3 mm, 6 hull of 16 to 32 corners, 7 cylinder, 8 cone, truncated or not, 9 ellipsoid,
    /// 10 rounded box, 11 rounded hull, 12 disc or rod down to 1:1000, 13 flat or long ellipsoid.
    pub(crate) fn shape(&mut self, class: usize) -> Shape {
        match class {
            0 => Shape::Sphere { radius: self.between(0.2, 1.0) },
            1 => Shape::Box {
                half: Vec3::new(self.between(0.1, 1.0), self.between(0.1, 1.0), self.between(0.1, 1.0)),
            },
            2 => Shape::Capsule { half_length: self.between(0.1, 1.0), radius: self.between(0.1, 0.5) },
            3 if self.word().is_multiple_of(4) => {
                let half = Vec3::new(self.between(0.2, 1.0), self.between(0.2, 1.0), self.between(0.2, 1.0));
                Shape::Hull(Arc::new(Hull::cuboid(half)))
            }
            3 => {
                let corners = 5 + (self.word() % 8) as usize;
                self.hull(corners)
            }
            5 => Shape::Box {
                half: Vec3::new(
                    10.0_f32.powf(self.between(-3.8, 0.0)),
                    10.0_f32.powf(self.between(-3.8, 0.0)),
                    self.between(0.3, 1.0),
                ),
            },
            6 => {
                let corners = 16 + (self.word() % 17) as usize;
                self.hull(corners)
            }
            7 => Shape::Cylinder { half_length: self.between(0.1, 1.0), radius: self.between(0.1, 1.0) },
            8 => {
                let (lower, upper) = (self.between(0.0, 1.0), self.between(0.1, 1.0));
                let tip = if self.word().is_multiple_of(2) { 0.0 } else { lower };
                let [lower, upper] = if self.word().is_multiple_of(2) { [upper, tip] } else { [tip, upper] };
                Shape::Cone { half_length: self.between(0.1, 1.0), lower, upper }
            }
            9 => Shape::Ellipsoid {
                half: Vec3::new(self.between(0.2, 1.0), self.between(0.2, 1.0), self.between(0.2, 1.0)),
            },
            10 => Shape::RoundedBox {
                half: Vec3::new(self.between(0.1, 1.0), self.between(0.1, 1.0), self.between(0.1, 1.0)),
                radius: self.between(0.01, 0.5),
            },
            11 => match self.shape(3) {
                Shape::Hull(hull) => Shape::RoundedHull { hull, radius: self.between(0.01, 0.5) },
                other => other,
            },
            12 => {
                let thin = 10.0_f32.powf(self.between(-3.0, -1.0));
                let wide = self.between(0.3, 1.0);
                match self.word() % 3 {
                    0 => Shape::Cylinder { half_length: thin, radius: wide },
                    1 => Shape::Cylinder { half_length: wide, radius: thin },
                    _ => Shape::Cone { half_length: wide, lower: thin, upper: 0.0 },
                }
            }
            13 => Shape::Ellipsoid {
                half: Vec3::new(
                    10.0_f32.powf(self.between(-2.0, 0.0)),
                    10.0_f32.powf(self.between(-2.0, 0.0)),
                    self.between(0.3, 1.0),
                ),
            },
            _ => Shape::HalfSpace { normal: self.direction(), offset: self.between(-1.0, 1.0) },
        }
    }
}

/// A shape as a polyhedron with a skin, in double precision, in the frame of A.
pub(crate) struct Solid {
    pub(crate) corners: Vec<DVec3>,
    pub(crate) triangles: Vec<[usize; 3]>,
    pub(crate) edges: Vec<[usize; 2]>,
    pub(crate) normals: Vec<DVec3>,
    pub(crate) skin: f64,
}

fn place(pose: &Isometry, p: Vec3) -> DVec3 {
    let (r, p) = (&pose.rotation, p.as_dvec3());
    r.x_axis.as_dvec3() * p.x
        + r.y_axis.as_dvec3() * p.y
        + r.z_axis.as_dvec3() * p.z
        + pose.translation.as_dvec3()
}

impl Solid {
    pub(crate) fn new(shape: &Shape, pose: &Isometry) -> Option<Solid> {
        let hull = match shape {
            Shape::Sphere { radius } => {
                return Some(Solid {
                    corners: vec![place(pose, Vec3::ZERO)],
                    triangles: vec![],
                    edges: vec![],
                    normals: vec![],
                    skin: f64::from(*radius),
                });
            }
            Shape::Capsule { half_length, radius } => {
                return Some(Solid {
                    corners: vec![place(pose, -*half_length * Vec3::Z), place(pose, *half_length * Vec3::Z)],
                    triangles: vec![],
                    edges: vec![[0, 1]],
                    normals: vec![],
                    skin: f64::from(*radius),
                });
            }
            Shape::Box { half } => Hull::cuboid(*half),
            Shape::Hull(hull) => (**hull).clone(),
            _ => return None,
        };
        let corners: Vec<DVec3> = hull.vertices.iter().map(|&v| place(pose, v)).collect();
        let mut triangles = vec![];
        let mut normals = vec![];
        for f in 0..hull.normals.len() {
            let face = hull.face(f);
            for k in 1..face.len() - 1 {
                triangles.push([face[0] as usize, face[k] as usize, face[k + 1] as usize]);
            }
            // The largest of the face's triangles has the best normal.
            let best = (1..face.len() - 1)
                .map(|k| {
                    let at = |i: usize| corners[face[i] as usize];
                    (at(k) - at(0)).cross(at(k + 1) - at(0))
                })
                .max_by(|a, b| a.length().total_cmp(&b.length()))
                .unwrap();
            normals.push(best.normalize());
        }
        let edges = hull.edges.iter().map(|e| [e.vertices[0] as usize, e.vertices[1] as usize]).collect();
        Some(Solid { corners, triangles, edges, normals, skin: 0.0 })
    }

    pub(crate) fn furthest(&self, n: DVec3) -> f64 {
        self.corners.iter().map(|c| c.dot(n)).fold(f64::NEG_INFINITY, f64::max) + self.skin
    }

    /// How far a point is out of the solid, at least: exact inside and beyond faces.
    pub(crate) fn height(&self, p: DVec3) -> f64 {
        let beyond =
            self.normals.iter().map(|&n| n.dot(p) - self.furthest(n)).fold(f64::NEG_INFINITY, f64::max);
        match self.corners[..] {
            [c] => p.distance(c) - self.skin,
            [c, d] if self.normals.is_empty() => point_segment(p, c, d) - self.skin,
            _ => beyond,
        }
    }
}

/// Gap along a direction (unit, A to B).
pub(crate) fn gap(a: &Solid, b: &Solid, n: DVec3) -> f64 {
    -b.furthest(-n) - a.furthest(n)
}

fn point_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let ab = b - a;
    let t = ((p - a).dot(ab) / ab.length_squared()).clamp(0.0, 1.0);
    p.distance(a + t * ab)
}

fn point_triangle(p: DVec3, t: [DVec3; 3]) -> f64 {
    let n = (t[1] - t[0]).cross(t[2] - t[0]);
    let inside = (0..3).all(|k| (t[(k + 1) % 3] - t[k]).cross(p - t[k]).dot(n) >= 0.0);
    if inside { (p - t[0]).dot(n).abs() / n.length() } else { f64::INFINITY }
}

/// Distance of the lines if their nearest points lie in both segments: the other cases are points and segments.
fn crossing_segments(p: [DVec3; 2], q: [DVec3; 2]) -> f64 {
    let (d, e, r) = (p[1] - p[0], q[1] - q[0], p[0] - q[0]);
    let n = d.cross(e);
    if n.length_squared() < 1e-24 {
        return f64::INFINITY;
    }
    // r + s d − t e is parallel to n.
    let s = e.cross(r).dot(n) / n.length_squared();
    let t = d.cross(r).dot(n) / n.length_squared();
    let within = (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t);
    if within { r.dot(n).abs() / n.length() } else { f64::INFINITY }
}

/// Signed distance by brute force: all axes while the cores overlap, else all pairs of features.
pub(crate) fn judge(a: &Solid, b: &Solid) -> f64 {
    let skins = a.skin + b.skin;
    let solid = !a.normals.is_empty() || !b.normals.is_empty();
    let mut overlap = f64::NEG_INFINITY;
    if solid {
        for &n in &a.normals {
            overlap = overlap.max(gap(a, b, n) + skins);
        }
        for &n in &b.normals {
            overlap = overlap.max(gap(a, b, -n) + skins);
        }
        for e in &a.edges {
            for f in &b.edges {
                if overlap > 0.0 {
                    break;
                }
                let n = (a.corners[e[1]] - a.corners[e[0]]).cross(b.corners[f[1]] - b.corners[f[0]]);
                if n.length() > 1e-9 {
                    let n = n.normalize();
                    overlap = overlap.max(gap(a, b, n) + skins).max(gap(a, b, -n) + skins);
                }
            }
        }
        if overlap <= 0.0 {
            return overlap - skins;
        }
    }
    let mut least = f64::INFINITY;
    for (s, t) in [(a, b), (b, a)] {
        for &p in &s.corners {
            for &c in &t.corners {
                least = least.min(p.distance(c));
            }
            for &[i, j] in &t.edges {
                least = least.min(point_segment(p, t.corners[i], t.corners[j]));
            }
            for &triangle in &t.triangles {
                least = least.min(point_triangle(p, triangle.map(|i| t.corners[i])));
            }
        }
    }
    for &[i, j] in &a.edges {
        for &[k, l] in &b.edges {
            least = least.min(crossing_segments([a.corners[i], a.corners[j]], [b.corners[k], b.corners[l]]));
        }
    }
    least - skins
}

/// Half of the largest extent, roughly.
pub(crate) fn size(shape: &Shape) -> f32 {
    match shape {
        Shape::Sphere { radius } => *radius,
        Shape::Box { half } => half.length(),
        Shape::Capsule { half_length, radius } => half_length + radius,
        Shape::Hull(hull) => hull.vertices.iter().fold(0.0, |m, v| m.max(v.length())),
        Shape::HalfSpace { .. } => 1.0,
        other => other.radius_about(Vec3::ZERO),
    }
}

/// The manifold of a pair, with a fresh cache.
pub(crate) fn manifold(a: &Shape, b: &Shape, b_in_a: &Isometry, margin: f32) -> Option<Manifold> {
    let mut out = Vec::new();
    collide(a, b, b_in_a, margin, &mut Cache::default(), &mut out);
    assert!(out.len() <= 1);
    out.pop()
}
