//! One contact by itself, on its way into a block or out of it.

use crate::block::{Block, Column, Column3, tangents_of};
use crate::manifold::{FIXED, Manifold, Memory, row_of};
use rockfall_math::Vec3;

/// What a [`Block`] has sixteen of, field by field in the same order.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Single<const P: usize, const T: usize> {
    pub(crate) a: u32,
    pub(crate) b: u32,
    pub(crate) normal: [f32; 3],
    pub(crate) offset: [f32; 3],
    pub(crate) arms: [[f32; 3]; P],
    pub(crate) distances: [f32; P],
    pub(crate) masses: [f32; P],
    pub(crate) impulses: [f32; P],
    pub(crate) tangent_mass: [f32; 3],
    pub(crate) tangent_impulse: [f32; 2],
    pub(crate) friction: f32,
    pub(crate) twist_mass: [f32; T],
    pub(crate) twist_impulse: [f32; T],
    pub(crate) twist_limit: [f32; T],
}

/// What a [`crate::block::Cold`] has sixteen of, field by field in the same order.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ColdSingle {
    pub(crate) restitution: f32,
    pub(crate) approach: [f32; 4],
    pub(crate) peak: [f32; 4],
    pub(crate) rolling_limit: f32,
    pub(crate) rolling_mass: [f32; 6],
    pub(crate) rolling_impulse: [f32; 3],
    pub(crate) twist_mass: f32,
    pub(crate) twist_impulse: f32,
    pub(crate) twist_limit: f32,
}

/// How two surfaces rub and bounce.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Surface {
    /// Coulomb's coefficient.
    pub friction: f32,
    /// Coefficient of restitution.
    pub restitution: f32,
    /// Coefficient of rolling friction, m.
    pub rolling: f32,
    /// Coefficient of twisting friction, m.
    pub twisting: f32,
}

impl Surface {
    /// Whether a contact of so many points needs the cold half of a block.
    pub(crate) fn is_cold(&self, points: u32) -> bool {
        self.restitution > 0.0 || self.rolling > 0.0 || (self.twisting > 0.0 && points == 1)
    }
}

/// The mean gap of bodies that don't touch yet, 0 for others. They will have come together where an impulse acts: in a
/// block each arm ends on its own surface.
fn gap(distances: &[f32]) -> f32 {
    (distances.iter().sum::<f32>() / distances.len().max(1) as f32).max(0.0)
}

impl<const P: usize, const T: usize> Single<P, T> {
    /// Nothing.
    pub(crate) const IDLE: Self = Single {
        a: 0,
        b: 0,
        normal: [0.0, 0.0, 1.0],
        offset: [0.0; 3],
        arms: [[0.0; 3]; P],
        distances: [0.0; P],
        masses: [0.0; P],
        impulses: [0.0; P],
        tangent_mass: [0.0; 3],
        tangent_impulse: [0.0; 2],
        friction: 0.0,
        twist_mass: [0.0; T],
        twist_impulse: [0.0; T],
        twist_limit: [0.0; T],
    };

    /// What a lane of a block holds.
    pub(crate) fn of(block: &Block<P, T>, lane: usize) -> Self {
        let vector = |columns: &Column3| columns.map(|column| column[lane]);
        let number = |column: &Column| column[lane];
        Single {
            a: block.a[lane],
            b: block.b[lane],
            normal: vector(&block.normal),
            offset: vector(&block.offset),
            arms: block.arms.each_ref().map(vector),
            distances: block.distances.each_ref().map(number),
            masses: block.masses.each_ref().map(number),
            impulses: block.impulses.each_ref().map(number),
            tangent_mass: vector(&block.tangent_mass),
            tangent_impulse: block.tangent_impulse.each_ref().map(number),
            friction: block.friction[lane],
            twist_mass: block.twist_mass.each_ref().map(number),
            twist_impulse: block.twist_impulse.each_ref().map(number),
            twist_limit: block.twist_limit.each_ref().map(number),
        }
    }

    /// All but effective masses, which follow from the bodies' inertia. `offset` leads from the centre of mass of a to that of b.
    pub(crate) fn new(m: &Manifold, memory: &Memory, surface: &Surface, offset: Vec3) -> Self {
        let count = m.count as usize;
        let gap = gap(&m.distances[..count]);
        let arms = m.arms.map(|arm| arm - m.normal * (0.5 * gap));
        let middle = arms[..count].iter().sum::<Vec3>() / count as f32;
        let lever = arms[..count].iter().map(|&arm| (arm - middle).length()).sum::<f32>() / count as f32;
        let (s, t) = tangents_of(m.normal);
        let mut single = Single {
            a: m.a,
            b: row_of(m.b) as u32,
            normal: m.normal.to_array(),
            offset: (offset - m.normal * gap).to_array(),
            arms: [middle.to_array(); P],
            tangent_impulse: [s.dot(memory.friction), t.dot(memory.friction)],
            friction: surface.friction,
            twist_impulse: [memory.twist; T],
            twist_limit: [surface.friction * lever + surface.twisting; T],
            ..Self::IDLE
        };
        for (p, arm) in arms[..count].iter().enumerate() {
            single.arms[p] = arm.to_array();
            single.distances[p] = m.distances[p];
            single.masses[p] = 1.0;
            single.impulses[p] = memory.normals[p];
        }
        single
    }

    /// The manifold of the first `count` points, and what is remembered of it, names and colour aside.
    pub(crate) fn manifold(&self, count: usize, one_sided: bool) -> (Manifold, Memory) {
        let normal = Vec3::from_array(self.normal);
        let half = normal * (0.5 * gap(&self.distances[..count]));
        let b = self.b | if one_sided { FIXED } else { 0 };
        let mut manifold = Manifold { a: self.a, b, count: count as u32, normal, ..Manifold::default() };
        let (s, t) = tangents_of(normal);
        let friction = s * self.tangent_impulse[0] + t * self.tangent_impulse[1];
        let twist = self.twist_impulse.first().copied().unwrap_or_default();
        let mut memory = Memory { friction, twist, ..Memory::default() };
        for p in 0..count {
            manifold.arms[p] = Vec3::from_array(self.arms[p]) + half;
            manifold.distances[p] = self.distances[p];
            memory.normals[p] = self.impulses[p];
        }
        (manifold, memory)
    }

    /// Visits all fields but the first two, in order.
    #[inline(always)]
    pub(crate) fn each(&mut self, mut visit: impl FnMut(&mut f32)) {
        self.normal.iter_mut().chain(&mut self.offset).for_each(&mut visit);
        self.arms.iter_mut().for_each(|arm| arm.iter_mut().for_each(&mut visit));
        for points in [&mut self.distances, &mut self.masses, &mut self.impulses] {
            points.iter_mut().for_each(&mut visit);
        }
        self.tangent_mass.iter_mut().chain(&mut self.tangent_impulse).for_each(&mut visit);
        visit(&mut self.friction);
        for twist in [&mut self.twist_mass, &mut self.twist_impulse, &mut self.twist_limit] {
            twist.iter_mut().for_each(&mut visit);
        }
    }
}

impl ColdSingle {
    /// What does not change from step to step, and what is remembered.
    pub(crate) fn new(memory: &Memory, surface: &Surface, points: u32) -> Self {
        let single = points == 1;
        ColdSingle {
            restitution: surface.restitution,
            rolling_limit: surface.rolling,
            rolling_impulse: if surface.rolling > 0.0 { memory.rolling.to_array() } else { [0.0; 3] },
            twist_impulse: if single { memory.twist } else { 0.0 },
            twist_limit: if single { surface.twisting } else { 0.0 },
            ..ColdSingle::default()
        }
    }

    /// Visits all fields, in order.
    pub(crate) fn each(&mut self, mut visit: impl FnMut(&mut f32)) {
        visit(&mut self.restitution);
        self.approach.iter_mut().chain(&mut self.peak).for_each(&mut visit);
        visit(&mut self.rolling_limit);
        self.rolling_mass.iter_mut().chain(&mut self.rolling_impulse).for_each(&mut visit);
        [&mut self.twist_mass, &mut self.twist_impulse, &mut self.twist_limit].into_iter().for_each(visit);
    }
}
