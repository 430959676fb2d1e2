//! Stage 8, **prepare**, second half: manifolds to lanes.

use crate::batch::{Bodies, Origin, Piece, Surface};
use crate::block::{Block, Cold, LANES, put3};
use crate::effective::Effective;
use crate::manifold::{Chunk, row_of};
use rockfall_math::lanes::Width;
use rockfall_math::{Mat3, Vec3};

/// Fills blocks from manifolds.
pub(crate) struct Fill<'a, S> {
    pub(crate) chunks: &'a [Chunk],
    pub(crate) bodies: Bodies<'a>,
    pub(crate) width: Width,
    pub(crate) surface: &'a S,
}

impl<S: Fn(usize, usize) -> Surface> Fill<'_, S> {
    pub(crate) fn span<const P: usize, const T: usize>(
        &self,
        (blocks, origins): Piece<'_, P, T>,
        mut colds: Option<&mut [Cold]>,
    ) {
        for (i, block) in blocks.iter_mut().enumerate() {
            *block = Block::IDLE;
            if let Some(colds) = colds.as_deref_mut() {
                colds[i] = Cold::IDLE;
            }
            for (lane, origin) in origins[i * LANES..(i + 1) * LANES].iter().enumerate() {
                if origin.in_use {
                    let cold = colds.as_deref_mut().map(|colds| &mut colds[i]);
                    self.lane(block, cold, lane, *origin);
                }
            }
        }
        self.width.run(Effective { blocks, lines: self.bodies.lines });
    }

    /// Copies what the manifold says. Where [`Effective`] computes a column, the lane holds what it needs for that until
    /// then.
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
