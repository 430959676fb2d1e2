//! Samples the signed distance of a mesh into an octree.
//!
//! A cell is cut until the interpolant is near enough to the exact distance at 27 places: the middles of its edges and faces, its own
//! middle, and the middles of its eight parts. Half of what is allowed is left for the seams (`seams.rs`). Both functions change by no more than about the way, so that small
//! cells always pass. Large cells are built beside each other; each has its own list of leaves, joined in order.

use super::octree::{LEAF, MOST_CUTS, Octree, interpolate};
use super::{FAR, FieldError, MOST_CELLS};
use crate::Mesh;
use rayon::prelude::*;
use rockfall_math::{DVec3, Vec3};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// Large cells along the longest side of the body.
const LARGE: f32 = 6.0;

/// Where a leaf lies: its lowest corner, in the smallest cells that there may be, and how often its large cell was cut.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    pub(super) low: [u32; 3],
    pub(super) cuts: u32,
}

/// Builds the octree, and tells where each leaf lies.
pub(super) fn build(mesh: &Mesh, error: f32) -> Result<(Octree, Vec<Place>), FieldError> {
    let extent = mesh.bounds.max - mesh.bounds.min;
    let cell = extent.max_element() / LARGE;
    // At least half a cell around the body.
    let size = extent.to_array().map(|length| (length / cell + 1.0).ceil().max(1.0) as u32);
    let origin = mesh.bounds.center() - 0.5 * cell * Vec3::from(size.map(|n| n as f32));
    let maker = Maker { mesh, origin, cell, error: f64::from(error), cells: AtomicUsize::new(0) };
    let roots: Vec<[u32; 3]> = (0..size[2])
        .flat_map(|z| (0..size[1]).flat_map(move |y| (0..size[0]).map(move |x| [x, y, z])))
        .collect();
    let parts: Option<Vec<Part>> = roots.par_iter().with_max_len(1).map(|root| maker.part(root)).collect();
    let parts = parts.ok_or(FieldError::TooFine { error, most: MOST_CELLS })?;
    let mut octree = Octree { origin, cell, size, ..Octree::default() };
    let mut places = Vec::new();
    for part in parts {
        let (nodes, leaves) = (octree.nodes.len() as u32, octree.leaves.len() as u32);
        let moved = |link: u32| if link & LEAF == 0 { link + nodes } else { link + leaves };
        octree.roots.push(moved(part.root));
        octree.nodes.extend(part.nodes.iter().map(|links| links.map(moved)));
        octree.leaves.extend_from_slice(&part.leaves);
        places.extend_from_slice(&part.places);
    }
    Ok((octree, places))
}

/// A large cell.
#[derive(Default)]
struct Part {
    root: u32,
    nodes: Vec<[u32; 8]>,
    leaves: Vec<[f32; 8]>,
    places: Vec<Place>,
}

struct Maker<'a> {
    mesh: &'a Mesh,
    origin: Vec3,
    cell: f32,
    error: f64,
    /// Leaves so far.
    cells: AtomicUsize,
}

/// The 27 points of a cell that is cut, x running fastest, with their distances.
type Lattice = [f64; 27];

impl Maker<'_> {
    fn part(&self, root: &[u32; 3]) -> Option<Part> {
        let place = Place { low: root.map(|n| n << MOST_CUTS), cuts: 0 };
        let corners = std::array::from_fn(|k| self.distance(&place, corner(k).map(|b| 4 * b), f64::INFINITY));
        let mut part = Part::default();
        part.root = self.grow(&mut part, place, corners)?;
        Some(part)
    }

    /// Makes a cell, by its exact distances at its corners. Nothing where there are too many.
    fn grow(&self, part: &mut Part, place: Place, corners: [f64; 8]) -> Option<u32> {
        let edge = f64::from(self.cell) / f64::from(1_u32 << place.cuts);
        // No point of the cell is further than that from the nearest corner's foot.
        let far = corners.iter().fold(f64::INFINITY, |far, d| far.min(d.abs())) + 1.75 * edge;
        let mut lattice: Lattice = [f64::NAN; 27];
        let values = corners.map(|d| d as f32);
        let mut fits = true;
        for (n, value) in lattice.iter_mut().enumerate() {
            let quarters = [n % 3, n / 3 % 3, n / 9].map(|i| 2 * i as u32);
            if quarters.iter().all(|q| q % 4 == 0) {
                *value = corners[quarters.iter().rev().fold(0, |k, q| 2 * k + *q as usize / 4)];
            } else {
                *value = self.distance(&place, quarters, far);
                fits &= self.fits(&values, quarters, *value);
            }
        }
        fits = fits
            && (0..8).all(|k| {
                let quarters = corner(k).map(|b| 1 + 2 * b);
                self.fits(&values, quarters, self.distance(&place, quarters, far))
            });
        if fits {
            if self.cells.fetch_add(1, Relaxed) >= MOST_CELLS {
                return None;
            }
            part.leaves.push(values);
            part.places.push(place);
            return Some(LEAF | (part.leaves.len() - 1) as u32);
        }
        if place.cuts == MOST_CUTS {
            return None;
        }
        let node = part.nodes.len();
        part.nodes.push([0; 8]);
        for child in 0..8 {
            let [x, y, z] = corner(child);
            let half = 1 << (MOST_CUTS - place.cuts - 1);
            let low = [place.low[0] + x * half, place.low[1] + y * half, place.low[2] + z * half];
            let corners = std::array::from_fn(|k| {
                let [i, j, l] = corner(k);
                lattice[(x + i + 3 * (y + j) + 9 * (z + l)) as usize]
            });
            part.nodes[node][child] = self.grow(part, Place { low, cuts: place.cuts + 1 }, corners)?;
        }
        Some(node as u32)
    }

    /// Exact signed distance at a place of a cell, in quarters of its edges, that is no further than `far` from the surface.
    fn distance(&self, place: &Place, quarters: [u32; 3], far: f64) -> f64 {
        // In quarters of the smallest cells, so that cells of any depth mean the same point by the same number.
        let step = 1 << (MOST_CUTS - place.cuts);
        let units: [u32; 3] = std::array::from_fn(|i| 4 * place.low[i] + quarters[i] * step);
        let unit = f64::from(self.cell) / f64::from(4_u32 << MOST_CUTS);
        let p = self.origin.as_dvec3() + unit * DVec3::from(units.map(f64::from));
        // Rounding may hide what lies at the limit.
        let near = self.mesh.nearest(p, far).or_else(|| self.mesh.nearest(p, f64::INFINITY));
        near.map_or(f64::NAN, |near| near.distance)
    }

    fn fits(&self, corners: &[f32; 8], quarters: [u32; 3], exact: f64) -> bool {
        let found = interpolate(corners, 0.25 * Vec3::from(quarters.map(|q| q as f32)));
        (f64::from(found) - exact).abs() <= 0.5 * (self.error + FAR * exact.abs())
    }
}

/// Which of the three coordinates of corner `k` are high.
pub(super) fn corner(k: usize) -> [u32; 3] {
    [k & 1, k >> 1 & 1, k >> 2].map(|bit| bit as u32)
}
