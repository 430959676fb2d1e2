//! Whether a ball is inside a closed mesh.
//!
//! A ray goes up from the ball's centre; the triangles that it crosses count +1 where it leaves the solid and -1
//! where it enters: the sum is the winding number, 1 inside, 0 outside. Edges are half open and every edge is
//! evaluated the same way from both of its triangles, so that a ray through an edge or a corner counts once. Then no
//! triangle may be nearer to the centre than the radius. Triangles are listed in a grid of cells; a column of cells
//! serves the ray, a block of cells the distance.

use rockfall_math::DVec3;
use rockfall_shape::Mesh;

/// A closed mesh, prepared for questions.
pub(crate) struct Inside {
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    min: DVec3,
    max: DVec3,
    cell: DVec3,
    counts: [usize; 3],
    /// Triangles of cell c are `list[starts[c]..starts[c + 1]]`.
    starts: Vec<u32>,
    list: Vec<u32>,
    /// m³, signed: negative where the triangles are clockwise from outside.
    volume: f64,
}

impl Inside {
    /// # Errors
    /// Says why the mesh has no inside.
    pub(crate) fn new(mesh: &Mesh) -> Result<Self, String> {
        if !mesh.closed {
            return Err("the mesh is not closed, so it has no inside".to_owned());
        }
        let vertices: Vec<DVec3> = mesh.vertices.iter().map(|v| v.as_dvec3()).collect();
        let triangles = mesh.triangles.clone();
        let corners = |t: &[u32; 3]| t.map(|i| vertices[i as usize]);
        let volume = triangles.iter().map(corners).map(|[a, b, c]| a.dot(b.cross(c))).sum::<f64>() / 6.0;
        let (min, max) = (mesh.bounds.min.as_dvec3(), mesh.bounds.max.as_dvec3());
        let extent = (max - min).max(DVec3::splat(1e-9));
        // About one cell per triangle of a surface that fills the box evenly.
        let side = libm::cbrt(extent.x * extent.y * extent.z / triangles.len() as f64);
        let counts = extent.to_array().map(|e| ((e / side).ceil() as usize).clamp(1, 128));
        let cell = extent / DVec3::new(counts[0] as f64, counts[1] as f64, counts[2] as f64);
        let mut inside =
            Inside { vertices, triangles, min, max, cell, counts, starts: vec![], list: vec![], volume };
        inside.sort_triangles();
        Ok(inside)
    }

    /// Fills the cells' lists: first counts, then places.
    fn sort_triangles(&mut self) {
        let cells: usize = self.counts.iter().product();
        let ranges: Vec<[(usize, usize); 3]> = (0..self.triangles.len())
            .map(|t| {
                let [a, b, c] = self.corners(t as u32);
                self.cells_of(a.min(b).min(c), a.max(b).max(c))
            })
            .collect();
        let mut starts = vec![0u32; cells + 1];
        for range in &ranges {
            self.each_cell(*range, |c| starts[c + 1] += 1);
        }
        for c in 0..cells {
            starts[c + 1] += starts[c];
        }
        let mut next = starts.clone();
        let mut list = vec![0; starts[cells] as usize];
        for (t, range) in ranges.iter().enumerate() {
            self.each_cell(*range, |c| {
                list[next[c] as usize] = t as u32;
                next[c] += 1;
            });
        }
        (self.starts, self.list) = (starts, list);
    }

    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|i| self.vertices[i as usize])
    }

    /// Cells that a box meets, first and last along each axis.
    fn cells_of(&self, low: DVec3, high: DVec3) -> [(usize, usize); 3] {
        let at = |p: DVec3, axis: usize| {
            let x = ((p[axis] - self.min[axis]) / self.cell[axis]).floor();
            (x.max(0.0) as usize).min(self.counts[axis] - 1)
        };
        [0, 1, 2].map(|axis| (at(low, axis), at(high, axis)))
    }

    fn each_cell(&self, [x, y, z]: [(usize, usize); 3], mut see: impl FnMut(usize)) {
        for k in z.0..=z.1 {
            for j in y.0..=y.1 {
                for i in x.0..=x.1 {
                    see((k * self.counts[1] + j) * self.counts[0] + i);
                }
            }
        }
    }

    /// Box around the mesh.
    pub(crate) fn bounds(&self) -> (DVec3, DVec3) {
        (self.min, self.max)
    }

    /// m³.
    pub(crate) fn volume(&self) -> f64 {
        self.volume.abs()
    }

    /// Whether the ball is wholly inside.
    pub(crate) fn contains_ball(&self, centre: DVec3, radius: f64) -> bool {
        self.winding(centre) == if self.volume < 0.0 { -1 } else { 1 } && self.is_clear(centre, radius)
    }

    /// How many times the surface goes around a point.
    fn winding(&self, p: DVec3) -> i32 {
        let [x, y, (k, _)] = self.cells_of(p, p);
        let mut sum = 0;
        // A triangle is in every cell that its box meets; it counts in the first of the column's only.
        self.each_cell([x, y, (k, self.counts[2] - 1)], |c| {
            let level = c / (self.counts[0] * self.counts[1]);
            for &t in self.listed(c) {
                let [a, b, d] = self.corners(t);
                let [_, _, (lowest, _)] = self.cells_of(a.min(b).min(d), a.max(b).max(d));
                if lowest.max(k) == level {
                    sum += self.crossing(t, p);
                }
            }
        });
        sum
    }

    fn listed(&self, cell: usize) -> &[u32] {
        &self.list[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    /// +1 where the upward ray from `p` leaves through the triangle, -1 where it enters, 0 where it misses.
    fn crossing(&self, triangle: u32, p: DVec3) -> i32 {
        let indices = self.triangles[triangle as usize];
        let mut around = 0;
        for e in 0..3 {
            let (i, j) = (indices[e], indices[(e + 1) % 3]);
            let (a, b) = (self.vertices[i as usize], self.vertices[j as usize]);
            if (a.y <= p.y) != (b.y <= p.y) {
                // From the lower index to the higher, so that both triangles of the edge see the same number.
                let (first, second) = if i < j { (a, b) } else { (b, a) };
                let side = (second.x - first.x) * (p.y - first.y) - (second.y - first.y) * (p.x - first.x);
                let upwards = a.y <= p.y;
                let left = if (second.y > first.y) == (side > 0.0) { side != 0.0 } else { false };
                if left {
                    around += if upwards { 1 } else { -1 };
                }
            }
        }
        if around == 0 {
            return 0;
        }
        let [a, b, c] = self.corners(triangle);
        let normal = (b - a).cross(c - a);
        // Height of the plane above p, times the normal's z.
        let above = normal.dot(a - p);
        if (above > 0.0) == (normal.z > 0.0) && above != 0.0 { around } else { 0 }
    }

    /// Whether every triangle is at least `radius` away.
    fn is_clear(&self, centre: DVec3, radius: f64) -> bool {
        let r = DVec3::splat(radius);
        let mut clear = true;
        self.each_cell(self.cells_of(centre - r, centre + r), |c| {
            clear = clear
                && self.listed(c).iter().all(|&t| {
                    let [a, b, d] = self.corners(t);
                    (nearest(centre, a, b, d) - centre).length_squared() >= radius * radius
                });
        });
        clear
    }
}

/// The point of a triangle that is nearest to `p`: the foot on the plane where it is within the triangle, or the
/// nearest point of the three edges.
fn nearest(p: DVec3, a: DVec3, b: DVec3, c: DVec3) -> DVec3 {
    let normal = (b - a).cross(c - a);
    let area = normal.length_squared();
    let within = |u: DVec3, v: DVec3| (v - u).cross(p - u).dot(normal) >= 0.0;
    if area > 0.0 && within(a, b) && within(b, c) && within(c, a) {
        return p - normal * ((p - a).dot(normal) / area);
    }
    let on_edge = |u: DVec3, v: DVec3| {
        let along = v - u;
        let length = along.length_squared();
        let t = if length > 0.0 { ((p - u).dot(along) / length).clamp(0.0, 1.0) } else { 0.0 };
        u + along * t
    };
    let mut best = on_edge(a, b);
    for other in [on_edge(b, c), on_edge(c, a)] {
        if (other - p).length_squared() < (best - p).length_squared() {
            best = other;
        }
    }
    best
}
