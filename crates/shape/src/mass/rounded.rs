//! Polyhedra that have grown to all sides by a radius r.
//!
//! What is added (the pieces of Steiner's formula for the volume of parallel bodies, here with their moments): over each
//! face a prism of height r; along each edge a sector of a cylinder, between the normals of its two faces; and at each
//! corner a sector of a ball, whose solid angle Ω is 2π less the angles of the faces there. With unit vectors u over a
//! sector, the integrals that are needed are:
//!
//! - over the arc of angle θ between the normals at an edge along d, with m half-way and k = d × m:
//!   ∫ u = 2 sin(θ/2) m and ∫ u uᵀ = (θ + sin θ)/2 m mᵀ + (θ − sin θ)/2 k kᵀ;
//! - over the solid angle at a corner: ∫ u = −½ Σ θ d over its edges, d leaving the corner, because the surface of the
//!   sector is closed; and ∫ u uᵀ adds up to 4π/3 over all corners, because the sectors make a whole ball.

use super::MassProperties;
use crate::Hull;
use rockfall_math::{DVec3, trig};
use std::f64::consts::{PI, TAU};

/// Integrals of 1, x and x xᵀ about some origin.
#[derive(Default)]
struct Sums {
    volume: f64,
    first: DVec3,
    /// xx, yy, zz.
    squares: DVec3,
    /// yz, zx, xy.
    products: DVec3,
}

impl Sums {
    /// Adds `by` times x yᵀ + y xᵀ, halved.
    fn add(&mut self, by: f64, x: DVec3, y: DVec3) {
        self.squares += by * x * y;
        let turned = |a: DVec3, b: DVec3| DVec3::new(a.y * b.z, a.z * b.x, a.x * b.y);
        self.products += 0.5 * by * (turned(x, y) + turned(y, x));
    }

    /// Shifts the origin to the centroid.
    fn finish(self, density: f64) -> Option<MassProperties> {
        if self.volume.is_nan() || self.volume <= 0.0 {
            return None;
        }
        let c = self.first / self.volume;
        let s = self.squares - self.volume * c * c;
        let products = self.products - self.volume * DVec3::new(c.y * c.z, c.z * c.x, c.x * c.y);
        let diagonal = DVec3::new(s.y + s.z, s.z + s.x, s.x + s.y);
        Some(MassProperties::new(density * self.volume, c, density * diagonal, -density * products))
    }
}

/// A box with half extents `half` that has grown by `r`.
pub(super) fn cuboid(density: f64, half: DVec3, r: f64) -> MassProperties {
    let [a, b, c] = half.to_array();
    let disc = PI * r * r;
    let volume =
        8.0 * a * b * c + 8.0 * r * (a * b + b * c + c * a) + 2.0 * disc * (a + b + c) + 4.0 / 3.0 * disc * r;
    // ∫ x²: the box with what is over its faces along x, the prisms over the others, then what lies along edges: those along
    // x make a cylinder, of the others the quarters are apart by 2 a; and the eighths of a ball at the corners.
    let second = |a: f64, b: f64, c: f64| {
        let grown = a + r;
        let prisms = 8.0 / 3.0 * b * c * grown * grown * grown + 8.0 / 3.0 * a * a * a * r * (b + c);
        let along = 2.0 / 3.0 * disc * a * a * a;
        let across = 2.0 * (b + c) * (disc * a * a + 8.0 / 3.0 * a * r * r * r + 0.25 * disc * r * r);
        let corners = disc * r * (4.0 / 3.0 * a * a + a * r + 4.0 / 15.0 * r * r);
        prisms + along + across + corners
    };
    let [x, y, z] = [second(a, b, c), second(b, c, a), second(c, a, b)];
    let diagonal = density * DVec3::new(y + z, z + x, x + y);
    MassProperties::new(density * volume, DVec3::ZERO, diagonal, DVec3::ZERO)
}

/// A hull that has grown by `r`.
pub(super) fn hull(density: f64, hull: &Hull, r: f64) -> Option<MassProperties> {
    // About a point inside, so that nothing is lost where the hull is far from its origin.
    let inside = hull.center.as_dvec3();
    let at = |c: u32| hull.vertices[c as usize].as_dvec3() - inside;
    let mut sums = Sums::default();
    core(&mut sums, hull.triangles().map(|t| t.map(|p| p - inside)));
    let mut defects = vec![TAU; hull.vertices.len()];
    for (f, normal) in hull.normals.iter().enumerate() {
        let corners = hull.face(f);
        prism(&mut sums, corners.iter().map(|&c| at(c)), normal.as_dvec3(), r);
        let n = corners.len();
        for i in 0..n {
            let [u, v, w] = [corners[(i + n - 1) % n], corners[i], corners[(i + 1) % n]].map(at);
            defects[corners[i] as usize] -= angle(u - v, w - v);
        }
    }
    let mut means = vec![DVec3::ZERO; hull.vertices.len()];
    for edge in &hull.edges {
        let [a, b] = edge.vertices.map(at);
        let normals = edge.faces.map(|f| hull.normals[f as usize].as_dvec3());
        let theta = sector(&mut sums, [a, b], normals, r);
        let along = 0.5 * theta * (b - a).normalize_or_zero();
        means[edge.vertices[0] as usize] -= along;
        means[edge.vertices[1] as usize] += along;
    }
    let (cubed, fourth) = (r * r * r / 3.0, 0.25 * r * r * r * r);
    for (c, (omega, mean)) in defects.into_iter().zip(means).enumerate() {
        let v = at(c as u32);
        sums.volume += cubed * omega;
        sums.first += cubed * omega * v + fourth * mean;
        sums.add(cubed * omega, v, v);
        sums.add(2.0 * fourth, v, mean);
    }
    sums.squares += DVec3::splat(4.0 / 15.0 * PI * r * r * r * r * r);
    let mut mass = sums.finish(density)?;
    mass.center += hull.center;
    Some(mass)
}

/// The angle between two vectors, radians: exact also where they are nearly parallel.
fn angle(a: DVec3, b: DVec3) -> f64 {
    trig::atan2_double(a.cross(b).length(), a.dot(b))
}

/// The polyhedron itself, see `polyhedron.rs`.
fn core(sums: &mut Sums, triangles: impl Iterator<Item = [DVec3; 3]>) {
    for [a, b, c] in triangles {
        let d = a.dot(b.cross(c));
        let s = a + b + c;
        sums.volume += d / 6.0;
        sums.first += d / 24.0 * s;
        for p in [a, b, c, s] {
            sums.add(d / 120.0, p, p);
        }
    }
}

/// What is over a face: points p + t n with t from 0 to r.
fn prism(sums: &mut Sums, corners: impl Iterator<Item = DVec3> + Clone, normal: DVec3, r: f64) {
    let Some(first) = corners.clone().next() else { return };
    for (b, c) in corners.clone().skip(1).zip(corners.skip(2)) {
        let area = 0.5 * (b - first).cross(c - first).dot(normal);
        let s = first + b + c;
        sums.volume += area * r;
        sums.first += area * r * (s / 3.0 + 0.5 * r * normal);
        for p in [first, b, c, s] {
            sums.add(area * r / 12.0, p, p);
        }
        sums.add(area * r * r / 3.0, s, normal);
        sums.add(area * r * r * r / 3.0, normal, normal);
    }
}

/// What is around an edge: points p + ρ u with ρ from 0 to r and u from one normal to the other. Returns the angle
/// between the two.
fn sector(sums: &mut Sums, [a, b]: [DVec3; 2], [left, right]: [DVec3; 2], r: f64) -> f64 {
    let length = (b - a).length();
    let [left, right] = [left.normalize_or_zero(), right.normalize_or_zero()];
    let theta = angle(left, right);
    let (m, k) = ((left + right).normalize_or_zero(), (right - left).normalize_or_zero());
    // Of half the angle.
    let (sine, cosine) = (0.5 * (right - left).length(), 0.5 * (right + left).length());
    let (squared, cubed, fourth) = (0.5 * r * r, r * r * r / 3.0, 0.25 * r * r * r * r);
    let mean = 2.0 * sine * m;
    sums.volume += squared * theta * length;
    sums.first += squared * theta * length * 0.5 * (a + b) + cubed * length * mean;
    for p in [a, b, a + b] {
        sums.add(squared * theta * length / 6.0, p, p);
    }
    sums.add(cubed * length, a + b, mean);
    let sin_theta = 2.0 * sine * cosine;
    sums.add(0.5 * fourth * length * (theta + sin_theta), m, m);
    sums.add(0.5 * fourth * length * (theta - sin_theta), k, k);
    theta
}
