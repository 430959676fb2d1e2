//! Shapes as triangles to be looked at.

mod lathe;
mod rounded;

use lathe::Strip;
use rockfall_math::{Isometry, Vec3, trig};
use rockfall_shape::{Frustum, Hull, Mesh, Shape};
use std::collections::BTreeMap;
use std::f32::consts::TAU;

/// How far triangles may be inside a round surface, as a share of its radius of curvature, the largest half axis of an ellipsoid. What is flat is exact.
pub const CHORDAL_ERROR: f32 = 0.035;

/// Triangles around a full turn: steps of 15 degrees. A cell of that width both ways lies up to 1.7 % of the radius below the surface; on a rounded corner a splinter may be
/// two steps long, and then lies up to 1 - cos 15°, or 3.4 %, below.
const SEGMENTS: i32 = 4 * QUARTER;

/// Of those, from the equator to a pole.
const QUARTER: i32 = 6;

/// A triangle surface for display, metres, in the frame of its shape.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Corners.
    pub positions: Vec<Vec3>,
    /// The outward unit normal at each corner. Empty where all faces are flat, so that each triangle has its own.
    pub normals: Vec<Vec3>,
    /// Corners of each triangle, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}

impl Surface {
    /// Cuts a shape into triangles. A half-space has no end: it becomes a square around the point that is nearest to its frame's origin, and `reach`,
    /// metres, is half the length of its sides. The same shape gives the same bits on every machine.
    pub fn of(shape: &Shape, reach: f32) -> Surface {
        match shape {
            Shape::Sphere { radius } => lathe::turn(&[lathe::arc(*radius, -QUARTER, QUARTER, 0.0)]),
            Shape::Box { half } => flat(&Hull::cuboid(*half)),
            Shape::Capsule { half_length, radius } => {
                let mut strip = lathe::arc(*radius, -QUARTER, 0, -half_length);
                // Where it is as long as a ball, both circles are one.
                let upper =
                    lathe::arc(*radius, if *half_length > 0.0 { 0 } else { 1 }, QUARTER, *half_length);
                strip.extend(upper);
                lathe::turn(&[strip])
            }
            Shape::Cylinder { half_length, radius } => {
                frustum(&Frustum { half_length: *half_length, lower: *radius, upper: *radius })
            }
            Shape::Cone { half_length, lower, upper } => {
                frustum(&Frustum { half_length: *half_length, lower: *lower, upper: *upper })
            }
            Shape::Ellipsoid { half } => {
                let mut surface = lathe::turn(&[lathe::arc(1.0, -QUARTER, QUARTER, 0.0)]);
                for (position, normal) in surface.positions.iter_mut().zip(&mut surface.normals) {
                    *position *= *half;
                    *normal = (*normal / *half).normalize();
                }
                surface
            }
            Shape::RoundedBox { half, radius } => rounded::rounded(&Hull::cuboid(*half), *radius),
            Shape::Hull(hull) => flat(hull),
            Shape::RoundedHull { hull, radius } => rounded::rounded(hull, *radius),
            Shape::HalfSpace { normal, offset } => square(*normal, *normal * *offset, reach),
            Shape::Mesh(mesh) => triangles(mesh),
            Shape::Field(field) => triangles(field.mesh()),
            Shape::Compound(compound) => {
                let mut whole = Surface::default();
                for part in compound.parts() {
                    whole.join(Surface::of(&part.shape, reach).shaded(), &part.place);
                }
                whole
            }
            Shape::HeightField(field) => {
                let at = |i: u32, j: u32| j * field.columns + i;
                let cell = |(i, j)| {
                    let [a, b] = [at(i, j), at(i + 1, j + 1)];
                    [[a, at(i + 1, j), b], [a, b, at(i, j + 1)]]
                };
                let cells = (0..field.rows - 1).flat_map(|j| (0..field.columns - 1).map(move |i| (i, j)));
                Surface {
                    positions: field.samples().collect(),
                    normals: Vec::new(),
                    triangles: cells.flat_map(cell).collect(),
                }
            }
        }
    }

    /// Takes in another surface from where it is.
    fn join(&mut self, other: Surface, place: &Isometry) {
        let first = self.positions.len() as u32;
        self.positions.extend(other.positions.into_iter().map(|p| place.point(p)));
        self.normals.extend(other.normals.into_iter().map(|n| place.vector(n)));
        self.triangles.extend(other.triangles.into_iter().map(|t| t.map(|corner| first + corner)));
    }

    /// The same triangles with a normal at every corner: where faces are flat, corners are there once for each of the normals that meet in them.
    pub fn shaded(&self) -> Surface {
        if !self.normals.is_empty() {
            return self.clone();
        }
        let mut weld = Weld::default();
        for triangle in &self.triangles {
            let corners = triangle.map(|c| self.positions[c as usize]);
            let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or_zero();
            weld.add(corners.map(|corner| (corner, normal)));
        }
        weld.surface
    }
}

fn triangles(mesh: &Mesh) -> Surface {
    Surface { positions: mesh.vertices.clone(), normals: Vec::new(), triangles: mesh.triangles.clone() }
}

/// Puts a surface together from triangles whose corners know their normals; equal corners become one.
#[derive(Default)]
struct Weld {
    surface: Surface,
    known: BTreeMap<[u32; 6], u32>,
}

impl Weld {
    fn add(&mut self, corners: [(Vec3, Vec3); 3]) {
        let indices = corners.map(|(position, normal)| {
            // Adding zero turns -0 into 0.
            let key = [position + Vec3::ZERO, normal + Vec3::ZERO].map(|v| v.to_array().map(f32::to_bits));
            let key = std::array::from_fn(|i| key[i / 3][i % 3]);
            *self.known.entry(key).or_insert_with(|| {
                self.surface.positions.push(position);
                self.surface.normals.push(normal);
                (self.surface.positions.len() - 1) as u32
            })
        });
        let [a, b, c] = indices;
        if a != b && b != c && c != a {
            self.surface.triangles.push(indices);
        }
    }
}

/// Sine and cosine of `k` of the [`SEGMENTS`] of a full turn.
fn turned(k: i32) -> (f32, f32) {
    trig::sin_cos(k as f32 * (TAU / SEGMENTS as f32))
}

/// A polyhedron, each face as a fan around its first corner.
fn flat(hull: &Hull) -> Surface {
    let faces = (0..hull.normals.len()).map(|f| hull.face(f));
    let fan = |face: &[u32]| face[1..].windows(2).map(|w| [face[0], w[0], w[1]]).collect::<Vec<_>>();
    Surface {
        positions: hull.vertices.clone(),
        normals: Vec::new(),
        triangles: faces.flat_map(fan).collect(),
    }
}

fn frustum(frustum: &Frustum) -> Surface {
    let (h, (across, along)) = (frustum.half_length, frustum.side());
    let side = (across as f32, along as f32);
    let end = |radius: f32, z: f32, up: f32| -> Strip {
        let strip = vec![(0.0, z, (0.0, up)), (radius, z, (0.0, up))];
        if up < 0.0 { strip } else { strip.into_iter().rev().collect() }
    };
    let mut strips = Vec::new();
    if frustum.lower > 0.0 {
        strips.push(end(frustum.lower, -h, -1.0));
    }
    strips.push(vec![(frustum.lower, -h, side), (frustum.upper, h, side)]);
    if frustum.upper > 0.0 {
        strips.push(end(frustum.upper, h, 1.0));
    }
    lathe::turn(&strips)
}

/// A square with this normal around a point.
fn square(normal: Vec3, middle: Vec3, reach: f32) -> Surface {
    let (x, y) = normal.any_orthonormal_pair();
    let corner = |(s, t): (f32, f32)| middle + reach * (s * x + t * y);
    Surface {
        positions: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(corner).to_vec(),
        normals: Vec::new(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
    }
}

#[cfg(test)]
mod tests;
