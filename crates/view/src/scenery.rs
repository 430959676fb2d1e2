//! Which bodies there are, and what they look like: what a viewer is told once.

use crate::wire::{ABSENT, Body, Grid, Mesh, MeshKind, Record};
use rayon::prelude::*;
use rockfall::{Kind, Shape};
use rockfall_export::Surface;
use rockfall_math::{DVec3, Pose, Quat, Vec3};
use std::collections::BTreeMap;
use std::sync::Arc;

/// A plane is drawn so many times as far as anything else reaches.
const FAR: f32 = 40.0;

/// The grid of positions reaches so many times as far as what is there at first.
const MARGIN: f32 = 1.5;

/// What is known of a body before it is drawn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Row {
    pub(crate) id: u64,
    /// Index of its shape, or of what is seen in its place.
    pub(crate) shown: usize,
    pub(crate) kind: Kind,
    pub(crate) sensor: bool,
}

/// The table of bodies; rows are added at its end.
#[derive(Clone, Debug)]
pub(crate) struct Scenery {
    /// Another one where rows no longer mean the same bodies.
    pub(crate) epoch: u32,
    /// Where positions start from, metres.
    pub(crate) origin: DVec3,
    /// The grid at first.
    pub(crate) grid: Grid,
    pub(crate) meshes: Vec<Arc<Mesh>>,
    pub(crate) bodies: Vec<Body>,
    /// Ascending.
    pub(crate) ids: Vec<u64>,
    mesh_of: BTreeMap<Key, u32>,
    reach: f32,
}

/// Shapes that share a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Key {
    Ball,
    Cube,
    Own(usize),
}

impl Default for Scenery {
    fn default() -> Self {
        Scenery {
            epoch: 0,
            origin: DVec3::ZERO,
            grid: Grid { step: 1.0 },
            meshes: Vec::new(),
            bodies: Vec::new(),
            ids: Vec::new(),
            mesh_of: BTreeMap::new(),
            reach: 1.0,
        }
    }
}

impl Scenery {
    /// A table of `rows`, whose ids ascend, with these `shapes`. `places` says where some of them are, with their shapes.
    pub(crate) fn new(shapes: &[Shape], rows: &[Row], places: &[(usize, Pose)]) -> Self {
        let mut low = DVec3::INFINITY;
        let mut high = DVec3::NEG_INFINITY;
        for (shape, pose) in places {
            let (at, radius) = match shapes.get(*shape) {
                Some(Shape::HalfSpace { .. }) | None => (pose.position, 0.0),
                Some(shape) => {
                    let center = shape.bounds().center();
                    (pose.point(center), f64::from(shape.radius_about(center)))
                }
            };
            if at.is_finite() && radius.is_finite() {
                (low, high) = (low.min(at - radius), high.max(at + radius));
            }
        }
        let empty = !low.is_finite() || !high.is_finite();
        let (origin, half) =
            if empty { (DVec3::ZERO, 1.0) } else { (0.5 * (low + high), 0.5 * (high - low).max_element()) };
        let reach = (half as f32).max(1e-3);
        let mut scenery =
            Scenery { origin, reach, grid: Grid::reaching(MARGIN * reach), ..Scenery::default() };
        // Shapes are cut into triangles by all threads.
        let mut keys = BTreeMap::new();
        for row in rows.iter().filter(|row| !row.sensor) {
            if let Some(shape) = shapes.get(row.shown) {
                keys.entry(key(row.shown, shape)).or_insert(shape);
            }
        }
        let keys: Vec<(Key, &Shape)> = keys.into_iter().collect();
        let reach = FAR * scenery.reach;
        let meshes: Vec<Mesh> = keys.par_iter().map(|(_, shape)| mesh(shape, reach)).collect();
        scenery.mesh_of = keys.iter().map(|(key, _)| *key).zip(0..).collect();
        scenery.meshes = meshes.into_iter().map(Arc::new).collect();
        rows.iter().for_each(|row| scenery.add(shapes, *row));
        scenery
    }

    /// Adds a row. Its id is larger than all others.
    pub(crate) fn add(&mut self, shapes: &[Shape], row: Row) {
        let shape = shapes.get(row.shown).filter(|_| !row.sensor);
        let look = shape.map(|shape| {
            let known = self.mesh_of.len() as u32;
            let mesh_number = *self.mesh_of.entry(key(row.shown, shape)).or_insert(known);
            if mesh_number as usize == self.meshes.len() {
                self.meshes.push(Arc::new(mesh(shape, FAR * self.reach)));
            }
            (mesh_number, scale(shape))
        });
        let (mesh, scale) = look.unwrap_or((0, Vec3::ONE));
        let open = matches!(shape, Some(Shape::Mesh(mesh)) if !mesh.closed);
        self.bodies.push(Body { mesh, scale, moves: row.kind != Kind::Static, hidden: look.is_none(), open });
        self.ids.push(row.id);
    }

    /// The row of a body.
    pub(crate) fn row(&self, id: u64) -> Option<usize> {
        self.ids.binary_search(&id).ok()
    }

    /// The records of all rows on the finest grid, from `grid` on, that reaches all of them, as long as that is not much coarser than the one at first; and how many are beyond it. Positions from the origin, three
    /// numbers for each row; rotations, four; no numbers where a body is not there.
    pub(crate) fn records(
        &self,
        grid: &mut Grid,
        positions: &[f32],
        rotations: &[f32],
        asleep: &[bool],
    ) -> (Vec<Record>, usize) {
        /// Doublings of the step at most: one body that flies off should not make all others tremble.
        const COARSEST: f32 = 64.0;
        loop {
            let poses = positions.as_chunks::<3>().0.par_iter().zip(rotations.as_chunks::<4>().0).enumerate();
            let record = |(row, (p, q)): (usize, (&[f32; 3], &[f32; 4]))| {
                let asleep = asleep.get(row).copied().unwrap_or_default();
                grid.record(Vec3::from_array(*p), Quat::from_array(*q), asleep)
            };
            let records: Vec<Record> = poses.with_min_len(2048).map(record).collect();
            let far = (positions.as_chunks::<3>().0.iter().zip(&records))
                .filter(|(p, record)| **record == ABSENT && p.iter().all(|x| x.is_finite()))
                .count();
            if far == 0 || grid.step >= COARSEST * self.grid.step {
                return (records, far);
            }
            grid.step *= 2.0;
        }
    }
}

fn key(number: usize, shape: &Shape) -> Key {
    match shape {
        Shape::Sphere { .. } | Shape::Ellipsoid { .. } => Key::Ball,
        Shape::Box { .. } => Key::Cube,
        _ => Key::Own(number),
    }
}

/// From the mesh of a shape to the shape.
fn scale(shape: &Shape) -> Vec3 {
    match shape {
        Shape::Sphere { radius } => Vec3::splat(*radius),
        Shape::Ellipsoid { half } | Shape::Box { half } => *half,
        _ => Vec3::ONE,
    }
}

/// `reach`: half the side of the square that stands for a plane, metres.
fn mesh(shape: &Shape, reach: f32) -> Mesh {
    let (kind, surface) = match shape {
        Shape::Sphere { .. } | Shape::Ellipsoid { .. } => (MeshKind::Ball, Surface::default()),
        Shape::Box { .. } => (MeshKind::Flat, Surface::of(&Shape::Box { half: Vec3::ONE }, reach)),
        Shape::HalfSpace { .. } => (MeshKind::Plane, Surface::of(shape, reach)),
        _ => {
            let surface = Surface::of(shape, reach);
            let kind = if surface.normals.is_empty() { MeshKind::Flat } else { MeshKind::Smooth };
            (kind, surface)
        }
    };
    let radius = surface.positions.iter().map(|p| p.length()).fold(0.0, f32::max);
    Mesh { kind, radius: if kind == MeshKind::Ball { 1.0 } else { radius }, surface }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn balls_and_boxes_of_all_sizes_share_a_mesh_and_sensors_have_none() {
        let shapes = [
            Shape::Sphere { radius: 2.0 },
            Shape::Box { half: Vec3::new(1.0, 2.0, 3.0) },
            Shape::Ellipsoid { half: Vec3::new(1.0, 1.0, 0.5) },
            Shape::Box { half: Vec3::ONE },
            Shape::Capsule { half_length: 1.0, radius: 0.5 },
            Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 },
        ];
        let rows: Vec<Row> = (0..6)
            .map(|k| Row {
                id: 10 + k as u64,
                shown: k,
                kind: if k == 5 { Kind::Static } else { Kind::Dynamic },
                sensor: k == 3,
            })
            .collect();
        let places: Vec<_> =
            (0..6).map(|k| (k, Pose::at(DVec3::new(1e6 + 10.0 * k as f64, 0.0, 0.0)))).collect();
        let mut scenery = Scenery::new(&shapes, &rows, &places);
        assert_eq!(scenery.meshes.len(), 4);
        assert_eq!(scenery.bodies[0].mesh, scenery.bodies[2].mesh);
        assert_eq!(scenery.bodies[1].scale, Vec3::new(1.0, 2.0, 3.0));
        assert!(scenery.bodies[3].hidden && !scenery.bodies[5].moves);
        assert_eq!((scenery.row(12), scenery.row(99)), (Some(2), None));
        assert!((scenery.origin.x - 1e6 - 24.0).abs() < 1.0, "{}", scenery.origin);
        scenery.add(&shapes, Row { id: 20, shown: 0, kind: Kind::Dynamic, sensor: false });
        assert_eq!((scenery.meshes.len(), scenery.bodies.len(), scenery.row(20)), (4, 7, Some(6)));
    }

    #[test]
    fn the_grid_grows_with_what_flies_off_and_gives_up_on_what_flies_too_far() {
        let scenery = Scenery { grid: Grid::reaching(10.0), ..Scenery::default() };
        let records = |x: f32, grid: &mut Grid| {
            scenery.records(
                grid,
                &[x, 0.0, 0.0, 1.0, 1.0, 1.0],
                &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
                &[],
            )
        };
        let mut grid = scenery.grid;
        assert_eq!(records(5.0, &mut grid).1, 0);
        assert_eq!(grid, scenery.grid);
        assert_eq!(records(300.0, &mut grid).1, 0);
        assert!(grid.reach() >= 300.0 && grid.reach() < 1300.0);
        let (all, far) = records(1e9, &mut grid);
        assert_eq!((far, all[0]), (1, ABSENT));
        assert!(grid.pose(all[1]).is_some());
        assert_eq!(records(f32::NAN, &mut scenery.grid.clone()).1, 0, "what is not there is not far");
    }
}
