//! Bodies as they come from a lathe or a potter's wheel: rings, bowls, cups.

use super::{Mesh, MeshError};
use rockfall_math::{Vec2, Vec3, trig};
use std::f32::consts::TAU;

impl Mesh {
    /// The surface that a closed line makes when it turns around the z axis, in `parts` flat strips (at least 3). The line is given by its corners, distance from the axis (not negative) and z, counter-clockwise
    /// where the distance goes to the right and z up, so that the surface looks outwards; the last one is joined to the first. Where both ends of a side lie on the axis it makes no surface.
    ///
    /// # Errors
    /// As [`Mesh::from_triangles`].
    ///
    /// # Examples
    /// ```
    /// use rockfall_math::Vec2;
    /// use rockfall_shape::Mesh;
    ///
    /// let ring = [[3.0, 0.0], [4.0, 0.0], [4.0, 1.0], [3.0, 1.0]].map(Vec2::from);
    /// let mesh = Mesh::turned(&ring, 24)?;
    /// assert!(mesh.closed);
    /// assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (4 * 24, 8 * 24));
    /// # Ok::<(), rockfall_shape::MeshError>(())
    /// ```
    pub fn turned(line: &[Vec2], parts: u32) -> Result<Mesh, MeshError> {
        let parts = parts.max(3);
        let n = line.len() as u32;
        let mut vertices = Vec::new();
        for part in 0..parts {
            let (sin, cos) = trig::sin_cos(TAU * part as f32 / parts as f32);
            vertices.extend(line.iter().map(|p| Vec3::new(p.x * cos, p.x * sin, p.y)));
        }
        let corner = |part: u32, k: u32| part % parts * n + k % n;
        let on_axis = |k: u32| line[(k % n) as usize].x == 0.0;
        let mut triangles = Vec::new();
        for part in 0..parts {
            for k in 0..n {
                let [a, b] = [corner(part, k), corner(part + 1, k)];
                let [d, c] = [corner(part, k + 1), corner(part + 1, k + 1)];
                // On the axis all parts share a corner.
                if !on_axis(k) {
                    triangles.push([a, b, if on_axis(k + 1) { d } else { c }]);
                }
                if !on_axis(k + 1) {
                    triangles.push([a, c, d]);
                }
            }
        }
        Mesh::from_triangles(&vertices, &triangles)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Shape;
    use std::sync::Arc;

    /// Pappus: the volume is the area of the line times the way of its centroid.
    #[test]
    fn volumes_come_near_those_of_round_bodies() {
        let volume = |line: &[[f32; 2]]| {
            let line: Vec<Vec2> = line.iter().map(|p| Vec2::from(*p)).collect();
            let mesh = Mesh::turned(&line, 256).unwrap();
            assert!(mesh.closed, "{:?}", mesh.report);
            Shape::Mesh(Arc::new(mesh)).mass_properties(1.0).unwrap().mass
        };
        let ring = volume(&[[3.0, 0.0], [4.0, 0.0], [4.0, 1.0], [3.0, 1.0]]);
        assert!((ring / (TAU * 3.5) - 1.0).abs() < 3e-4, "{ring}");
        // A cone whose axis is part of the line, and a bowl whose ends lie on it.
        let cone = volume(&[[0.0, 0.0], [1.0, 0.0], [0.0, 3.0]]);
        assert!((cone / (0.5 * TAU) - 1.0).abs() < 3e-4, "{cone}");
        let bowl = volume(&[[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 0.5], [0.0, 0.5]]);
        assert!((bowl / (0.5 * TAU * (4.0 - 0.5)) - 1.0).abs() < 3e-4, "{bowl}");
    }
}
