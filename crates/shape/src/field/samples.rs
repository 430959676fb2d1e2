//! Points of a surface, with balls around groups of them.
//!
//! Corners of the mesh, sharp ones first, then points on its edges, then such within its triangles, where none is near yet. They lie along a Hilbert curve, and each eight
//! have a ball around them, each eight balls another one, and so on: distances change by no more than the way, so the distance of a ball's middle tells whether anything in
//! it can be near.

use super::{FieldError, MOST_SAMPLES};
use crate::Mesh;
use crate::mesh::TrianglePart;
use rockfall_math::{Aabb, DVec3, Vec3};
use rockfall_tree::Tree;
use std::collections::HashMap;
use std::ops::Range;

/// Points, or balls, in a ball; points of one of the smallest balls have numbers with the same quotient by it.
pub const SAMPLES_IN_A_BALL: usize = 8;
const GROUP: usize = SAMPLES_IN_A_BALL;

/// Two points that are nearer to each other than this share of the spacing do the work of one, if they look the same way.
const NEAR: f32 = 0.4;

/// Rows of points within a triangle, as a share of the spacing: the height of a triangle of equal sides.
const ROW: f32 = 0.866;

/// A point of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// In the body's frame, metres.
    pub position: Vec3,
    /// Unit vector out of the body; at an edge or a corner between those of the triangles around it.
    pub normal: Vec3,
    /// Cosine of the largest angle between that and the normals of the triangles around it: 1 on a flat side.
    pub cone: f32,
}

/// x, y and z of the middles of eight balls side by side, and their radii, metres. Where there are fewer the last one is repeated.
pub type Balls = [[f32; SAMPLES_IN_A_BALL]; 4];

/// The samples of a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    points: Vec<Sample>,
    /// The points, eight at a time; then the balls around each eight, and so on, up to one around all.
    balls: Vec<Balls>,
    /// Where each level of balls starts, and how many it has.
    levels: Vec<(usize, usize)>,
}

impl Samples {
    /// The points, neighbours near each other.
    pub fn points(&self) -> &[Sample] {
        &self.points
    }

    /// Bytes.
    pub fn memory(&self) -> usize {
        size_of::<Sample>() * self.points.capacity() + size_of::<Balls>() * self.balls.capacity()
    }

    pub(super) fn scaled(&self, by: f32) -> Self {
        Self::in_order(self.points.iter().map(|p| Sample { position: by * p.position, ..*p }).collect())
    }

    /// Goes down from the ball around all. `bounds` says of eight balls how near each may be, `worth` then of one with this bound whether to look into it, nearer its turn; `meet` gets the numbers of the points in one of the smallest
    /// balls, ascending, and the points side by side.
    pub fn search(
        &self,
        mut bounds: impl FnMut(&Balls) -> [f32; SAMPLES_IN_A_BALL],
        mut worth: impl FnMut(f32) -> bool,
        mut meet: impl FnMut(Range<usize>, &Balls),
    ) {
        let Some(top) = self.levels.len().checked_sub(1) else { return };
        // Seven wait on each level while the eighth is looked at; eight levels hold more than there may be.
        let mut stack = [(0.0_f32, 0_u32, 0_u32); 8 * GROUP];
        stack[0] = (f32::NEG_INFINITY, top as u32, 0);
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let (bound, level, index) = (stack[height].0, stack[height].1 as usize, stack[height].2 as usize);
            if level < top && !worth(bound) {
                continue;
            }
            let (start, count) = self.levels[level];
            let (balls, first) = (&self.balls[start + index], GROUP * index);
            let count = (count - first).min(GROUP);
            if level == 0 {
                meet(first..first + count, balls);
                continue;
            }
            let bounds = bounds(balls);
            for lane in (0..count).rev() {
                stack[height] = (bounds[lane], level as u32 - 1, (first + lane) as u32);
                height += 1;
            }
        }
    }

    pub(super) fn of(mesh: &Mesh, spacing: f32) -> Result<Self, FieldError> {
        let count = about(mesh, spacing);
        if count > MOST_SAMPLES {
            return Err(FieldError::TooMany { spacing, count, most: MOST_SAMPLES });
        }
        let mut sieve = Sieve { cell: NEAR * spacing, kept: Vec::new(), grid: HashMap::new() };
        let mut corners = corners(mesh);
        // Equally sharp ones in the order of the mesh, whatever rounding says.
        corners.sort_by_key(|sample| (64.0 * sample.cone).round() as i32);
        corners.iter().for_each(|sample| sieve.put(*sample));
        for t in 0..mesh.triangles.len() {
            for edge in 0..3 {
                if mesh.neighbours[t][edge] as usize > t {
                    let normal = normal(mesh, t, TrianglePart::Edge(edge));
                    let cone = normal.dot(mesh.normals[t]);
                    let [a, b] = [0, 1].map(|k| mesh.triangle(t)[(edge + k) % 3]);
                    between(a, b, spacing).for_each(|position| sieve.put(Sample { position, normal, cone }));
                }
            }
        }
        for t in 0..mesh.triangles.len() {
            let normal = mesh.normals[t];
            let cone = 1.0;
            rows(mesh.triangle(t), spacing).for_each(|position| sieve.put(Sample { position, normal, cone }));
        }
        Ok(Self::with_balls(sieve.kept))
    }

    /// Along the curve, with balls.
    fn with_balls(points: Vec<Sample>) -> Self {
        let boxes: Vec<Aabb> = points.iter().map(|p| Aabb::from_points([p.position])).collect();
        let order = Tree::build(&boxes);
        Self::in_order(order.order().iter().map(|&i| points[i as usize]).collect())
    }

    /// Puts balls around points that lie along the curve already.
    pub(super) fn in_order(points: Vec<Sample>) -> Self {
        let mut samples = Samples::default();
        let mut level: Vec<(Vec3, f32)> = points.iter().map(|p| (p.position, 0.0)).collect();
        while !level.is_empty() {
            samples.levels.push((samples.balls.len(), level.len()));
            samples.balls.extend(level.chunks(GROUP).map(side_by_side));
            if level.len() == 1 {
                break;
            }
            level = level.chunks(GROUP).map(around).collect();
        }
        samples.balls.shrink_to_fit();
        Samples { points, ..samples }
    }
}

fn side_by_side(balls: &[(Vec3, f32)]) -> Balls {
    let number = |k: usize, (center, radius): (Vec3, f32)| if k < 3 { center[k] } else { radius };
    std::array::from_fn(|k| std::array::from_fn(|i| number(k, balls[i.min(balls.len() - 1)])))
}

/// A ball around balls.
fn around(balls: &[(Vec3, f32)]) -> (Vec3, f32) {
    let center = Aabb::from_points(balls.iter().map(|(center, _)| *center)).center();
    let radius = balls.iter().fold(0.0_f32, |far, (c, r)| far.max(center.distance(*c) + r));
    (center, radius * (1.0 + 1e-6))
}

/// Drops points that are near others, which came before them.
struct Sieve {
    cell: f32,
    kept: Vec<Sample>,
    /// Numbers of the points in each cell of a grid.
    grid: HashMap<[i64; 3], Vec<u32>>,
}

impl Sieve {
    fn put(&mut self, sample: Sample) {
        let home = (sample.position / self.cell).floor().to_array().map(|x| x as i64);
        let near = |&i: &u32| {
            let other = &self.kept[i as usize];
            other.position.distance_squared(sample.position) < self.cell * self.cell
                && other.normal.dot(sample.normal) > 0.3
        };
        let around = (0..27).map(|n| [home[0] + n % 3 - 1, home[1] + n / 3 % 3 - 1, home[2] + n / 9 - 1]);
        if !around.filter_map(|cell| self.grid.get(&cell)).flatten().any(near) {
            self.grid.entry(home).or_default().push(self.kept.len() as u32);
            self.kept.push(sample);
        }
    }
}

/// About how many points a spacing takes, corners left out.
fn about(mesh: &Mesh, spacing: f32) -> usize {
    let area = |[a, b, c]: [DVec3; 3]| 0.5 * (b - a).cross(c - a).length();
    let all: f64 = mesh.corners().map(area).sum();
    (all / f64::from(ROW * spacing * spacing)) as usize
}

/// The corners of a mesh in their order.
pub(super) fn corners(mesh: &Mesh) -> Vec<Sample> {
    let mut first = vec![None; mesh.vertices.len()];
    for (t, corners) in mesh.triangles.iter().enumerate() {
        for (k, &c) in corners.iter().enumerate() {
            first[c as usize].get_or_insert((t, k));
        }
    }
    let mut samples: Vec<Sample> = mesh
        .vertices
        .iter()
        .zip(&first)
        .map(|(&position, first)| {
            let normal = first.map_or(Vec3::Z, |(t, k)| normal(mesh, t, TrianglePart::Corner(k)));
            Sample { position, normal, cone: 1.0 }
        })
        .collect();
    for (corners, n) in mesh.triangles.iter().zip(&mesh.normals) {
        for &c in corners {
            let sample = &mut samples[c as usize];
            sample.cone = sample.cone.min(sample.normal.dot(*n));
        }
    }
    samples
}

pub(super) fn normal(mesh: &Mesh, triangle: usize, part: TrianglePart) -> Vec3 {
    let own = mesh.normals[triangle].as_dvec3();
    mesh.pseudonormal(triangle, part).normalize_or(own).as_vec3()
}

/// Points between two, evenly, no further apart than `spacing`.
fn between(a: Vec3, b: Vec3, spacing: f32) -> impl Iterator<Item = Vec3> {
    let parts = (a.distance(b) / spacing).ceil().max(1.0) as u32;
    (1..parts).map(move |i| a + (b - a) * (i as f32 / parts as f32))
}

/// Points within a triangle, in rows along its longest side.
fn rows(corners: [Vec3; 3], spacing: f32) -> impl Iterator<Item = Vec3> {
    let length = |k: usize| corners[k].distance(corners[(k + 1) % 3]);
    let longest = (1..3).fold(0, |best, k| if length(k) > length(best) { k } else { best });
    let [a, b, c] = [0, 1, 2].map(|k| corners[(longest + k) % 3]);
    let height = (b - a).cross(c - a).length() / length(longest);
    let count = (height / (ROW * spacing)).ceil().max(1.0) as u32;
    (1..count).flat_map(move |row| {
        let t = row as f32 / count as f32;
        between(a + (c - a) * t, b + (c - b) * t, spacing)
    })
}
