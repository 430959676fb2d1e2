//! The point of a mesh nearest to a given one, and on which side of the surface that is.

use super::Mesh;
use rockfall_math::{Aabb, DVec3, Vec3, trig};

/// What [`Mesh::nearest`] finds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestOnMesh {
    /// The triangle that has the point; the first of several.
    pub triangle: u32,
    /// The point of the surface.
    pub point: DVec3,
    /// Metres, negative behind the surface.
    pub distance: f64,
    /// Unit vector out of the surface there: the triangle's own at its inside, between those of all triangles around it at an edge or a corner.
    pub normal: DVec3,
}

/// The part of a triangle that is nearest to a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrianglePart {
    /// A corner.
    Corner(usize),
    /// The edge from a corner to the next.
    Edge(usize),
    /// The inside.
    Face,
}

impl Mesh {
    /// The point of the surface nearest to `p`, if it is not further than `limit` metres, and the signed distance. A point lies behind the surface if it lies behind
    /// what it is nearest to; of a closed mesh that is the inside (Bærentzen and Aanæs, "Signed distance computation using the angle weighted pseudonormal", IEEE
    /// Transactions on Visualization and Computer Graphics 11(3), 2005).
    pub fn nearest(&self, p: DVec3, limit: f64) -> Option<NearestOnMesh> {
        let mut best = (u32::MAX, limit * limit, DVec3::ZERO, TrianglePart::Face);
        let up = |x: f64| (x as f32).next_up();
        self.tree.nearest(&Aabb::around(p, p), up(limit), |t, _| {
            let corners = self.triangle(t as usize).map(|c| c.as_dvec3() - p);
            let (to, part) = nearest_on_triangle(corners);
            let squared = to.length_squared();
            if squared < best.1 || (squared == best.1 && t < best.0) {
                best = (t, squared, to, part);
            }
            up(best.1.sqrt())
        });
        let (triangle, squared, to, part) = best;
        if triangle == u32::MAX {
            return None;
        }
        let normal = self.pseudonormal(triangle as usize, part).normalize_or_zero();
        let sign = if to.dot(normal) > 0.0 { -1.0 } else { 1.0 };
        Some(NearestOnMesh { triangle, point: p + to, distance: sign * squared.sqrt(), normal })
    }

    /// The outward direction, not of unit length, of a part of a triangle: its own normal, the sum of two at an edge, at a corner the sum over all triangles around it,
    /// weighted by their angles there.
    pub(crate) fn pseudonormal(&self, triangle: usize, part: TrianglePart) -> DVec3 {
        let own = self.normals[triangle].as_dvec3();
        match part {
            TrianglePart::Face => own,
            TrianglePart::Edge(edge) => {
                let other = self.neighbours[triangle][edge];
                own + self.normals.get(other as usize).map_or(own, |n| n.as_dvec3())
            }
            TrianglePart::Corner(corner) => self.around_corner(triangle, corner),
        }
    }

    fn around_corner(&self, triangle: usize, corner: usize) -> DVec3 {
        let id = self.triangles[triangle][corner];
        let weighted = |t: usize, corner: usize| {
            let corners = self.triangle(t);
            let [a, b]: [Vec3; 2] = [1, 2].map(|k| corners[(corner + k) % 3] - corners[corner]);
            self.normals[t].as_dvec3() * f64::from(trig::atan2(a.cross(b).length(), a.dot(b)))
        };
        let mut sum = weighted(triangle, corner);
        // Around the corner over the edge that ends in it; where there is an end, from the start the other way round.
        for back in [2, 0] {
            let (mut here, mut at) = (triangle, corner);
            loop {
                let next = self.neighbours[here][(at + back) % 3] as usize;
                if next == triangle {
                    return sum;
                }
                let Some(corners) = self.triangles.get(next) else { break };
                let Some(k) = corners.iter().position(|&other| other == id) else { break };
                (here, at) = (next, k);
                sum += weighted(here, at);
            }
        }
        sum
    }
}

/// The point of a triangle nearest to the origin, and the part of the triangle that it is in (Ericson, *Real-Time Collision Detection*, 2005, section 5.1.5).
pub fn nearest_on_triangle([a, b, c]: [DVec3; 3]) -> (DVec3, TrianglePart) {
    let (ab, ac, bc) = (b - a, c - a, c - b);
    let (d1, d2) = (-ab.dot(a), -ac.dot(a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (a, TrianglePart::Corner(0));
    }
    let (d3, d4) = (-ab.dot(b), -ac.dot(b));
    if d3 >= 0.0 && d4 <= d3 {
        return (b, TrianglePart::Corner(1));
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (a + ab * (d1 / (d1 - d3)), TrianglePart::Edge(0));
    }
    let (d5, d6) = (-ab.dot(c), -ac.dot(c));
    if d6 >= 0.0 && d5 <= d6 {
        return (c, TrianglePart::Corner(2));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (a + ac * (d2 / (d2 - d6)), TrianglePart::Edge(2));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return (b + bc * ((d4 - d3) / ((d4 - d3) + (d5 - d6))), TrianglePart::Edge(1));
    }
    let sum = va + vb + vc;
    (a + ab * (vb / sum) + ac * (vc / sum), TrianglePart::Face)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_of_a_triangle_can_be_the_nearest() {
        let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let from = |x: f64, y: f64| {
            let p = DVec3::new(x, y, 0.5);
            let (to, part) = nearest_on_triangle(triangle.map(|c| c - p));
            (p + to, part)
        };
        assert_eq!(from(0.25, 0.25), (DVec3::new(0.25, 0.25, 0.0), TrianglePart::Face));
        assert_eq!(from(0.5, -1.0), (DVec3::new(0.5, 0.0, 0.0), TrianglePart::Edge(0)));
        assert_eq!(from(1.0, 1.0), (DVec3::new(0.5, 0.5, 0.0), TrianglePart::Edge(1)));
        assert_eq!(from(-1.0, 0.25), (DVec3::new(0.0, 0.25, 0.0), TrianglePart::Edge(2)));
        assert_eq!(from(-1.0, -1.0), (DVec3::ZERO, TrianglePart::Corner(0)));
        assert_eq!(from(2.0, 0.0), (DVec3::X, TrianglePart::Corner(1)));
        assert_eq!(from(0.0, 2.0), (DVec3::Y, TrianglePart::Corner(2)));
    }
}
