//! Stage 11, **store**: impulses from the batches to memory, for the next step's warm start.

use crate::batch::{Batches, Shelf};
use crate::block::{LANES, get3, tangents_of};
use crate::manifold::Chunk;
use rayon::prelude::*;
use rockfall_math::Vec3;
use rockfall_math::disjoint::DisjointRows;

/// Writes the impulses of every contact back to the memory that it came from.
pub fn store(batches: &Batches, chunks: &mut [Chunk]) {
    // Each span knows its blocks; each lane its row in a chunk.
    let mut tables: Vec<&mut [crate::Memory]> = chunks.iter_mut().map(|c| &mut c.memories[..]).collect();
    let tables: Vec<DisjointRows<'_, crate::Memory>> =
        tables.iter_mut().map(|table| DisjointRows::new(table)).collect();
    save(&batches.one, &tables);
    save(&batches.two, &tables);
    save(&batches.four, &tables);
    for span in &batches.spans {
        let Some(cold) = span.cold else { continue };
        for i in span.from..span.to {
            let origins = match span.class {
                crate::batch::Class::One => &batches.one.origins,
                crate::batch::Class::Two => &batches.two.origins,
                crate::batch::Class::Four => &batches.four.origins,
            };
            let cold = &batches.colds[cold + i - span.from];
            for (lane, origin) in origins[i * LANES..(i + 1) * LANES].iter().enumerate() {
                if origin.in_use {
                    // SAFETY: this loop is the only one at work here, and each lane has a row of its own.
                    let memory = unsafe { tables[origin.chunk as usize].row(origin.row as usize) };
                    memory.rolling = get3(&cold.rolling_impulse, lane);
                    memory.twist += cold.twist_impulse[lane];
                }
            }
        }
    }
}

fn save<const P: usize, const T: usize>(shelf: &Shelf<P, T>, tables: &[DisjointRows<'_, crate::Memory>]) {
    let origins = shelf.origins.par_chunks(LANES).with_min_len(16);
    shelf.blocks.par_iter().with_min_len(16).zip(origins).for_each(|(block, origins)| {
        for (lane, origin) in origins.iter().enumerate().filter(|(_, origin)| origin.in_use) {
            let (s, t) = tangents_of(get3(&block.normal, lane));
            // SAFETY: every manifold stands in one lane of one block.
            let memory = unsafe { tables[origin.chunk as usize].row(origin.row as usize) };
            for p in 0..P {
                memory.normals[p] = block.impulses[p][lane];
            }
            memory.friction = s * block.tangent_impulse[0][lane] + t * block.tangent_impulse[1][lane];
            memory.twist = block.twist_impulse.first().map_or(0.0, |column| column[lane]);
            memory.rolling = Vec3::ZERO;
        }
    });
}
