//! From the triangles of a convex surface to its polygon faces.
//!
//! In: triangles of an exact convex hull. Out: faces, each a plane and a closed loop of corners, or corners
//! that the polyhedron is better off without: those in the middle of a face or of an edge. The caller takes
//! those away, builds the hull of the rest and asks again until none is left.
//!
//! A face grows from its largest triangle over all neighbours within `tolerance` of that triangle's plane.
//! The hull is convex, so that this plane supports it: all corners lie on or below it.

use rockfall_math::DVec3;
use std::collections::VecDeque;

/// Faces or corners to drop.
pub(super) enum Merged {
    /// The loops of the faces, counter-clockwise from outside.
    Faces(Vec<Vec<u32>>),
    /// Corners to take away, in rising order.
    Drop(Vec<u32>),
}

/// The surface of a merged region is no disc, which a smaller tolerance cures.
#[derive(Debug)]
pub(super) struct NoDisc;

/// Merges `triangles` where their corners are within `tolerance` metres of a common plane.
pub(super) fn merge(points: &[DVec3], triangles: &[[u32; 3]], tolerance: f64) -> Result<Merged, NoDisc> {
    if tolerance == 0.0 {
        return Ok(Merged::Faces(triangles.iter().map(|t| t.to_vec()).collect()));
    }
    let neighbours = neighbours(triangles).ok_or(NoDisc)?;
    let (face_of, normals) = grow(points, triangles, &neighbours, tolerance);
    let loops = loops(triangles, &neighbours, &face_of, normals.len())?;

    let mut used = vec![false; points.len()];
    triangles.iter().flatten().for_each(|&c| used[c as usize] = true);
    let mut faces_at = vec![0_u32; points.len()];
    loops.iter().flatten().for_each(|&c| faces_at[c as usize] += 1);
    let mut dropped: Vec<bool> = (0..points.len()).map(|c| used[c] && faces_at[c] < 3).collect();
    for (corners, normal) in loops.iter().zip(&normals) {
        mark_idle(points, corners, *normal, 0.1 * tolerance, &mut dropped);
    }
    let drop: Vec<u32> = (0..points.len() as u32).filter(|&c| dropped[c as usize]).collect();
    Ok(if drop.is_empty() { Merged::Faces(loops) } else { Merged::Drop(drop) })
}

/// The triangle over each edge, `None` if an edge has not exactly two.
fn neighbours(triangles: &[[u32; 3]]) -> Option<Vec<[u32; 3]>> {
    let mut halves: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * triangles.len());
    for (t, c) in triangles.iter().enumerate() {
        halves.extend((0..3).map(|i| (c[i], c[(i + 1) % 3], t as u32)));
    }
    halves.sort_unstable();
    let over = |u: u32, v: u32| {
        let i = halves.partition_point(|h| (h.0, h.1) < (v, u));
        halves.get(i).filter(|h| (h.0, h.1) == (v, u)).map(|h| h.2)
    };
    triangles.iter().map(|&[a, b, c]| Some([over(a, b)?, over(b, c)?, over(c, a)?])).collect()
}

/// The face of each triangle and the unit normal of each face.
fn grow(
    points: &[DVec3],
    triangles: &[[u32; 3]],
    neighbours: &[[u32; 3]],
    tolerance: f64,
) -> (Vec<u32>, Vec<DVec3>) {
    let doubled: Vec<DVec3> = triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|i| points[i as usize]);
            (b - a).cross(c - a)
        })
        .collect();
    let mut order: Vec<usize> = (0..triangles.len()).collect();
    order.sort_by(|&a, &b| {
        doubled[b].length_squared().total_cmp(&doubled[a].length_squared()).then(a.cmp(&b))
    });
    let mut face_of = vec![u32::MAX; triangles.len()];
    let mut normals = Vec::new();
    for seed in order {
        if face_of[seed] != u32::MAX {
            continue;
        }
        let face = normals.len() as u32;
        let normal = doubled[seed].normalize_or_zero();
        let origin = points[triangles[seed][0] as usize];
        face_of[seed] = face;
        let mut queue = VecDeque::from([seed]);
        while let Some(t) = queue.pop_front() {
            for &n in &neighbours[t] {
                let n = n as usize;
                let near = |c: u32| (points[c as usize] - origin).dot(normal).abs() <= tolerance;
                if face_of[n] == u32::MAX
                    && doubled[n].dot(normal) > 0.0
                    && triangles[n].into_iter().all(near)
                {
                    face_of[n] = face;
                    queue.push_back(n);
                }
            }
        }
        normals.push(normal);
    }
    (face_of, normals)
}

/// The border of each face as one closed loop that starts at its lowest corner.
fn loops(
    triangles: &[[u32; 3]],
    neighbours: &[[u32; 3]],
    face_of: &[u32],
    faces: usize,
) -> Result<Vec<Vec<u32>>, NoDisc> {
    let mut borders: Vec<Vec<(u32, u32)>> = vec![Vec::new(); faces];
    for (t, c) in triangles.iter().enumerate() {
        for i in 0..3 {
            if face_of[neighbours[t][i] as usize] != face_of[t] {
                borders[face_of[t] as usize].push((c[i], c[(i + 1) % 3]));
            }
        }
    }
    let close = |mut border: Vec<(u32, u32)>| {
        border.sort_unstable();
        let start = border.first().ok_or(NoDisc)?.0;
        let mut corners = vec![start];
        let mut at = start;
        loop {
            let i = border.partition_point(|h| h.0 < at);
            at = border.get(i).filter(|h| h.0 == at).ok_or(NoDisc)?.1;
            if at == start {
                break;
            }
            if corners.len() == border.len() {
                return Err(NoDisc);
            }
            corners.push(at);
        }
        // A shorter loop than the border has edges: the face has a hole or pinches itself.
        if corners.len() == border.len() { Ok(corners) } else { Err(NoDisc) }
    };
    borders.into_iter().map(close).collect()
}

/// Marks corners of a face that stick out of the line between the two beside them by less than `least`, or
/// inwards. Never two in a row, so that a finely divided circle does not vanish at once.
fn mark_idle(points: &[DVec3], corners: &[u32], normal: DVec3, least: f64, dropped: &mut [bool]) {
    let n = corners.len();
    if n < 4 {
        return;
    }
    for i in 0..n {
        let [u, v, w] = [corners[(i + n - 1) % n], corners[i], corners[(i + 1) % n]];
        if dropped[u as usize] || dropped[w as usize] {
            continue;
        }
        let [a, b, c] = [u, v, w].map(|k| points[k as usize]);
        let line = c - a;
        // Height of b over the line from a to c, to the right of it, which is outside.
        let height = (b - a).cross(line).dot(normal) / line.length();
        // NaN where a and c coincide.
        if height < least || height.is_nan() {
            dropped[v as usize] = true;
        }
    }
}
