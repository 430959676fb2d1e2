//! What bodies there are, and what they look like.

use super::{Kind, begin, put, put_f32};
use rockfall_export::Surface;
use rockfall_math::Vec3;

/// How a mesh is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshKind {
    /// Each triangle has the normal of its own.
    Flat = 0,
    /// The unit ball: the page has one of its own, coarser where there are many.
    Ball = 1,
    /// A square of a plane, with a grid on it.
    Plane = 2,
    /// Corners have normals.
    Smooth = 3,
}

/// Triangles that bodies share.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// How it is drawn.
    pub kind: MeshKind,
    /// Distance of the farthest corner from the origin, metres.
    pub radius: f32,
    /// The triangles.
    pub surface: Surface,
}

/// How a row of the table is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body {
    /// Number of its mesh.
    pub mesh: u32,
    /// The mesh is scaled by this along its axes.
    pub scale: Vec3,
    /// Whether it can move.
    pub moves: bool,
    /// Whether it is nothing to look at.
    pub hidden: bool,
    /// Whether its mesh has holes through which one sees it from inside.
    pub open: bool,
}

/// The message of meshes from number `first` on.
pub fn meshes<'a>(first: usize, meshes: impl ExactSizeIterator<Item = &'a Mesh>) -> Vec<u8> {
    let mut out = begin(Kind::Meshes, 0, 0);
    put(&mut out, first as u32);
    put(&mut out, meshes.len() as u32);
    for Mesh { kind, radius, surface } in meshes {
        put(&mut out, *kind as u32);
        put(&mut out, surface.positions.len() as u32);
        put(&mut out, surface.triangles.len() as u32);
        put_f32(&mut out, &[*radius]);
        surface.positions.iter().for_each(|p| put_f32(&mut out, &p.to_array()));
        if *kind == MeshKind::Smooth {
            surface.normals.iter().for_each(|n| put_f32(&mut out, &n.to_array()));
        }
        surface.triangles.iter().flatten().for_each(|corner| put(&mut out, *corner));
    }
    out
}

/// The message of rows from `first` on; `anew` where all former ones are to be forgotten.
pub fn bodies(first: usize, rows: &[Body], anew: bool) -> Vec<u8> {
    let mut out = begin(Kind::Bodies, 0, 16 + 20 * rows.len());
    put(&mut out, first as u32);
    put(&mut out, rows.len() as u32);
    put(&mut out, u32::from(anew));
    for Body { mesh, scale, moves, hidden, open } in rows {
        put(&mut out, *mesh);
        put_f32(&mut out, &scale.to_array());
        put(&mut out, u32::from(*moves) | u32::from(*hidden) << 1 | u32::from(*open) << 2);
    }
    out
}
