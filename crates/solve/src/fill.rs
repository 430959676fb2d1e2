//! Stage 8, **prepare**, second half: manifolds to lanes.
//!
//! Each run of chunks is read once, in order, and its contacts go where [`crate::shelve`] has a place for them; the blocks that are
//! being filled, one for each bucket, stay in the cache. A block belongs to the run of its first lane. Contacts that
//! fall into a block of another run come later, block by block.

use crate::batch::{Batches, Bodies, Class, Origin, Shelf, Surface};
use crate::block::{Block, Cold, LANES, put3};
use crate::manifold::{Chunk, row_of};
use crate::shelve::{NOWHERE, Places, RUN, kind_of};
use rayon::prelude::*;
use rockfall_math::disjoint::DisjointRows;
use rockfall_math::{Mat3, Vec3};

/// Fills blocks from manifolds.
pub(crate) struct Fill<'a, S> {
    pub(crate) chunks: &'a [Chunk],
    pub(crate) bodies: Bodies<'a>,
    pub(crate) surface: &'a S,
}

/// A contact and its lane.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    class: Class,
    lane: u32,
    bucket: u16,
    chunk: u32,
    row: u32,
}

impl Place {
    fn block(&self) -> usize {
        self.lane as usize / LANES
    }
}

/// The blocks of all classes.
struct Shelves<'a> {
    one: Rows<'a, 1, 0>,
    two: Rows<'a, 2, 1>,
    four: Rows<'a, 4, 1>,
    colds: DisjointRows<'a, Cold>,
    places: &'a Places,
}

/// The blocks of one class with their origins.
struct Rows<'a, const P: usize, const T: usize> {
    blocks: DisjointRows<'a, Block<P, T>>,
    origins: DisjointRows<'a, Origin>,
}

impl<'a, const P: usize, const T: usize> Rows<'a, P, T> {
    fn new(shelf: &'a mut Shelf<P, T>) -> Self {
        Rows { blocks: DisjointRows::new(&mut shelf.blocks), origins: DisjointRows::new(&mut shelf.origins) }
    }
}

impl<S: Fn(usize, usize) -> Surface + Sync> Fill<'_, S> {
    /// Fills all blocks of `batches`.
    pub(crate) fn all(&self, batches: &mut Batches, places: &Places) {
        let Batches { one, two, four, colds, codes, .. } = batches;
        let colds = DisjointRows::new(colds);
        let shelves =
            Shelves { one: Rows::new(one), two: Rows::new(two), four: Rows::new(four), colds, places };
        let mut late: Vec<Place> = codes
            .par_iter()
            .zip(&places.lanes)
            .enumerate()
            .flat_map_iter(|(run, (codes, first))| self.run(run * RUN, codes, first, &shelves))
            .collect();
        late.par_sort_unstable();
        late.par_chunk_by(|a, b| a.class == b.class && a.block() == b.block())
            .for_each(|places| places.iter().for_each(|place| self.put(place, &shelves)));
    }

    /// The contacts of a run that begins at chunk `start`. Returns those that fall into blocks of other runs.
    fn run(&self, start: usize, codes: &[u16], first: &[u32], shelves: &Shelves<'_>) -> Vec<Place> {
        let mut late = Vec::new();
        let mut next = first.to_vec();
        let chunks = &self.chunks[start..self.chunks.len().min(start + RUN)];
        let rows = chunks
            .iter()
            .zip(start..)
            .flat_map(|(c, chunk)| (0..c.manifolds.len()).map(move |row| (chunk, row)));
        for ((chunk, row), &bucket) in rows.zip(codes).filter(|(_, bucket)| **bucket != NOWHERE) {
            let lane = next[usize::from(bucket)];
            next[usize::from(bucket)] += 1;
            let (class, _) = kind_of(usize::from(bucket));
            let place = Place { class, lane, bucket, chunk: chunk as u32, row: row as u32 };
            if place.block() * LANES < first[usize::from(bucket)] as usize {
                late.push(place);
            } else {
                self.put(&place, shelves);
            }
        }
        late
    }

    fn put(&self, place: &Place, shelves: &Shelves<'_>) {
        match place.class {
            Class::One => self.write(place, &shelves.one, shelves),
            Class::Two => self.write(place, &shelves.two, shelves),
            Class::Four => self.write(place, &shelves.four, shelves),
        }
    }

    fn write<const P: usize, const T: usize>(
        &self,
        place: &Place,
        rows: &Rows<'_, P, T>,
        shelves: &Shelves<'_>,
    ) {
        let (block, lane) = (place.block(), place.lane as usize % LANES);
        let cold = kind_of(usize::from(place.bucket))
            .1
            .then(|| block.wrapping_add_signed(shelves.places.colds[usize::from(place.bucket)]));
        let origin = Origin { chunk: place.chunk, row: place.row, in_use: true };
        // SAFETY: a block, its cold half and its origins are written by the run of its first lane and by nobody else; then, when
        // all runs are through, by the one group of late contacts that fall into it.
        let (to, mut cold) = unsafe { (rows.blocks.row(block), cold.map(|i| shelves.colds.row(i))) };
        if lane == 0 {
            *to = Block::IDLE;
            if let Some(cold) = cold.as_deref_mut() {
                *cold = Cold::IDLE;
            }
            for i in 1..LANES {
                // SAFETY: as above.
                unsafe { *rows.origins.row(block * LANES + i) = Origin::default() };
            }
        }
        // SAFETY: as above.
        unsafe { *rows.origins.row(place.lane as usize) = origin };
        self.lane(to, cold, lane, origin);
    }

    /// Copies what the manifold says. Where [`crate::effective`] computes a column, the lane holds what it needs for that
    /// until then.
    fn lane<const P: usize, const T: usize>(
        &self,
        block: &mut Block<P, T>,
        cold: Option<&mut Cold>,
        lane: usize,
        origin: Origin,
    ) {
        let chunk = &self.chunks[origin.chunk as usize];
        let m = &chunk.manifolds[origin.row as usize];
        let memory = &chunk.memories[origin.row as usize];
        let (a, b) = (row_of(m.a), row_of(m.b));
        let surface = (self.surface)(a, b);
        let count = m.count as usize;
        // Bodies that don't touch yet will have come together where an impulse acts: each arm ends on its own surface.
        let gap = (m.distances[..count].iter().sum::<f32>() / count as f32).max(0.0);
        let offset = (self.bodies.positions[b] - self.bodies.positions[a]).as_vec3() - m.normal * gap;
        let arms = m.arms.map(|arm| arm - m.normal * (0.5 * gap));
        let middle = arms[..count].iter().sum::<Vec3>() / count as f32;

        block.a[lane] = a as u32;
        block.b[lane] = b as u32;
        put3(&mut block.normal, lane, m.normal);
        put3(&mut block.offset, lane, offset);
        for (p, &arm) in arms.iter().enumerate().take(P) {
            let used = p < count;
            put3(&mut block.arms[p], lane, if used { arm } else { middle });
            if used {
                block.distances[p][lane] = m.distances[p];
                block.masses[p][lane] = 1.0;
                block.impulses[p][lane] = memory.normals[p];
            }
        }
        put3(&mut block.tangent_mass, lane, memory.friction);
        block.friction[lane] = surface.friction;
        for twist in 0..T {
            block.twist_impulse[twist][lane] = memory.twist;
            block.twist_limit[twist][lane] = surface.twisting;
        }
        if let Some(cold) = cold {
            self.cold_lane(cold, lane, origin, surface, offset);
            if T == 0 && surface.twisting > 0.0 {
                let [line_a, line_b] = [a, b].map(|row| self.bodies.lines[row].inverse_inertia());
                let compliance = m.normal.dot((line_a + line_b) * m.normal);
                cold.twist_mass[lane] = if compliance > 0.0 { 1.0 / compliance } else { 0.0 };
                cold.twist_impulse[lane] = memory.twist;
                cold.twist_limit[lane] = surface.twisting;
            }
        }
    }

    fn cold_lane(&self, cold: &mut Cold, lane: usize, origin: Origin, surface: Surface, offset: Vec3) {
        let chunk = &self.chunks[origin.chunk as usize];
        let m = &chunk.manifolds[origin.row as usize];
        let [a, b] = [m.a, m.b].map(|row| &self.bodies.lines[row_of(row)]);
        cold.restitution[lane] = surface.restitution;
        for (p, arm) in m.arms[..m.count as usize].iter().enumerate() {
            let v_a = a.velocity() + a.angular_velocity().cross(*arm);
            let v_b = b.velocity() + b.angular_velocity().cross(*arm - offset);
            cold.approach[p][lane] = m.normal.dot(v_b - v_a);
        }
        if surface.rolling > 0.0 {
            let compliance = a.inverse_inertia() + b.inverse_inertia();
            let mass = if compliance.determinant() > 0.0 { compliance.inverse() } else { Mat3::ZERO };
            let Mat3 { x_axis: x, y_axis: y, z_axis: z } = mass;
            for (column, value) in cold.rolling_mass.iter_mut().zip([x.x, x.y, x.z, y.y, y.z, z.z]) {
                column[lane] = value;
            }
            cold.rolling_limit[lane] = surface.rolling;
            put3(&mut cold.rolling_impulse, lane, chunk.memories[origin.row as usize].rolling);
        }
    }
}
