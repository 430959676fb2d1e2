//! Stage 8, **prepare**: manifolds to batches.
//!
//! Reads manifolds, memories, colours, masses and velocities; writes blocks of sixteen, sorted into buckets by side, colour,
//! number of points, and whether they need the cold half. Contacts between two bodies that move come first, those with
//! immovable bodies last, so that the ground has the last word.

use crate::block::{Block, Cold, LANES, put3, tangents_of};
use crate::line::Line;
use crate::manifold::{Chunk, Manifold, Memory, row_of};
use crate::paint::{COLORS, OVERFLOW};
use rayon::prelude::*;
use rockfall_math::{DVec3, Mat3, Vec3};

/// Blocks that one thread takes at a time. Results don't depend on it.
const SPAN: usize = 8;

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
    fn is_cold(&self, points: u32) -> bool {
        self.restitution > 0.0 || self.rolling > 0.0 || (self.twisting > 0.0 && points == 1)
    }
}

/// Where a lane of a block comes from and its impulses go to.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Origin {
    pub(crate) chunk: u32,
    pub(crate) row: u32,
    pub(crate) in_use: bool,
}

/// How many points the blocks of a class have room for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Class {
    One,
    Two,
    Four,
}

const CLASSES: [Class; 3] = [Class::One, Class::Two, Class::Four];

impl Class {
    fn of(points: u32) -> Self {
        match points {
            0 | 1 => Class::One,
            2 => Class::Two,
            _ => Class::Four,
        }
    }
}

/// Blocks `from..to` of one class, of one colour.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    pub(crate) class: Class,
    pub(crate) one_sided: bool,
    pub(crate) from: usize,
    pub(crate) to: usize,
    /// The cold half of block `from`.
    pub(crate) cold: Option<usize>,
}

/// The blocks of one class with their origins.
#[derive(Clone, Debug)]
pub(crate) struct Shelf<const P: usize, const T: usize> {
    pub(crate) blocks: Vec<Block<P, T>>,
    /// [`LANES`] a block.
    pub(crate) origins: Vec<Origin>,
}

impl<const P: usize, const T: usize> Default for Shelf<P, T> {
    fn default() -> Self {
        Shelf { blocks: Vec::new(), origins: Vec::new() }
    }
}

impl<const P: usize, const T: usize> Shelf<P, T> {
    fn resize(&mut self, blocks: usize) {
        self.blocks.resize(blocks, Block::IDLE);
        self.origins.clear();
        self.origins.resize(blocks * LANES, Origin::default());
    }

    fn memory(&self) -> usize {
        self.blocks.capacity() * size_of::<Block<P, T>>() + self.origins.capacity() * size_of::<Origin>()
    }
}

/// Spans whose contacts don't share a body that moves, or that are solved one after the other.
#[derive(Clone, Debug)]
pub(crate) struct Layer {
    pub(crate) spans: std::ops::Range<usize>,
    /// The overflow: contact after contact, in order.
    pub(crate) serial: bool,
    /// Blocks in all spans.
    pub(crate) blocks: usize,
}

/// All contacts of a step, ready to be swept.
#[derive(Clone, Debug, Default)]
pub struct Batches {
    pub(crate) one: Shelf<1, 0>,
    pub(crate) two: Shelf<2, 1>,
    pub(crate) four: Shelf<4, 1>,
    pub(crate) colds: Vec<Cold>,
    pub(crate) spans: Vec<Span>,
    pub(crate) layers: Vec<Layer>,
    counts: Vec<u32>,
}

/// What [`Batches::prepare`] reads of the bodies.
#[derive(Clone, Copy, Debug)]
pub struct Bodies<'a> {
    /// Masses and velocities.
    pub lines: &'a [Line],
    /// Centres of mass, metres.
    pub positions: &'a [DVec3],
}

/// Side, colour, class, cold: the order in which contacts are solved.
fn bucket(side: usize, color: u32, class: Class, cold: bool) -> usize {
    (((side * (OVERFLOW as usize + 1)) + color as usize) * CLASSES.len() + class as usize) * 2
        + usize::from(cold)
}

const BUCKETS: usize = 2 * (OVERFLOW as usize + 1) * CLASSES.len() * 2;

impl Batches {
    /// Number of layers that hold contacts: colours of both sides.
    pub fn colors(&self) -> usize {
        self.layers.len()
    }

    /// Bytes held.
    pub fn memory(&self) -> usize {
        self.one.memory()
            + self.two.memory()
            + self.four.memory()
            + self.colds.capacity() * size_of::<Cold>()
            + self.spans.capacity() * size_of::<Span>()
    }

    /// Bytes that one sweep over all blocks reads.
    pub fn swept_bytes(&self) -> usize {
        size_of_val(&self.one.blocks[..])
            + size_of_val(&self.two.blocks[..])
            + size_of_val(&self.four.blocks[..])
    }

    /// Fills the batches with the contacts of `chunks`, painted before. `active` tells by row whether a body moves in this
    /// step; contacts without one are left out. `surface` mixes the materials of two rows.
    pub fn prepare(
        &mut self,
        chunks: &[Chunk],
        bodies: Bodies<'_>,
        active: impl Fn(usize) -> bool + Sync,
        surface: impl Fn(usize, usize) -> Surface + Sync,
    ) {
        self.shelve(chunks, &active, &surface);
        let Batches { one, two, four, colds, spans, .. } = self;
        let cold_of = colds_by_span(colds, spans);
        let (mut ones, mut twos, mut fours) = (pieces(one), pieces(two), pieces(four));
        let jobs: Vec<_> = spans
            .iter()
            .zip(cold_of)
            .map(|(span, cold)| {
                let blocks = span.to - span.from;
                let work = match span.class {
                    Class::One => Work::One(take(&mut ones, blocks)),
                    Class::Two => Work::Two(take(&mut twos, blocks)),
                    Class::Four => Work::Four(take(&mut fours, blocks)),
                };
                (work, cold)
            })
            .collect();
        let fill = Fill { chunks, bodies, surface: &surface };
        jobs.into_par_iter().for_each(|(work, cold)| match work {
            Work::One(piece) => fill.span(piece, cold),
            Work::Two(piece) => fill.span(piece, cold),
            Work::Four(piece) => fill.span(piece, cold),
        });
    }

    /// Sorts the manifolds into buckets and cuts these into blocks and spans.
    fn shelve(
        &mut self,
        chunks: &[Chunk],
        active: &impl Fn(usize) -> bool,
        surface: &impl Fn(usize, usize) -> Surface,
    ) {
        let counts = &mut self.counts;
        counts.clear();
        counts.resize(BUCKETS, 0);
        let place = |m: &Manifold, memory: &Memory, ordinal: &mut Ordinal| {
            let (a, b) = (row_of(m.a), row_of(m.b));
            if !active(a) && (m.is_one_sided() || !active(b)) {
                return None;
            }
            let color = if m.is_one_sided() { ordinal.next(m.a) } else { memory.color };
            let cold = surface(a, b).is_cold(m.count);
            Some(bucket(usize::from(m.is_one_sided()), color, Class::of(m.count), cold))
        };
        let mut ordinal = Ordinal::default();
        let manifolds = || chunks.iter().flat_map(|c| c.manifolds.iter().zip(&c.memories));
        for (m, memory) in manifolds() {
            if let Some(bucket) = place(m, memory, &mut ordinal) {
                counts[bucket] += 1;
            }
        }

        // Buckets to blocks. From here on `counts` holds the next free lane of each bucket.
        self.spans.clear();
        self.layers.clear();
        let mut next = [0_usize; CLASSES.len()];
        let mut colds = 0;
        for side in 0..2 {
            for color in 0..=OVERFLOW {
                let first = self.spans.len();
                let mut total = 0;
                for class in CLASSES {
                    for cold in [false, true] {
                        let count = &mut counts[bucket(side, color, class, cold)];
                        let blocks = (*count as usize).div_ceil(LANES);
                        let from = next[class as usize];
                        *count = (from * LANES) as u32;
                        next[class as usize] = from + blocks;
                        total += blocks;
                        for start in (from..from + blocks).step_by(SPAN) {
                            let to = (start + SPAN).min(from + blocks);
                            self.spans.push(Span {
                                class,
                                one_sided: side == 1,
                                from: start,
                                to,
                                cold: cold.then_some(colds),
                            });
                            colds += if cold { to - start } else { 0 };
                        }
                    }
                }
                if self.spans.len() > first {
                    self.layers.push(Layer {
                        spans: first..self.spans.len(),
                        serial: color == COLORS,
                        blocks: total,
                    });
                }
            }
        }
        self.one.resize(next[Class::One as usize]);
        self.two.resize(next[Class::Two as usize]);
        self.four.resize(next[Class::Four as usize]);
        self.colds.clear();
        self.colds.resize(colds, Cold::IDLE);

        let mut ordinal = Ordinal::default();
        for (chunk, content) in chunks.iter().enumerate() {
            for (row, (m, memory)) in content.manifolds.iter().zip(&content.memories).enumerate() {
                let Some(bucket) = place(m, memory, &mut ordinal) else { continue };
                let lane = counts[bucket] as usize;
                counts[bucket] += 1;
                let origin = Origin { chunk: chunk as u32, row: row as u32, in_use: true };
                match Class::of(m.count) {
                    Class::One => self.one.origins[lane] = origin,
                    Class::Two => self.two.origins[lane] = origin,
                    Class::Four => self.four.origins[lane] = origin,
                }
            }
        }
    }
}

/// Numbers the one-sided manifolds of each body from 0: their colours, since they stand together in the order of keys.
#[derive(Default)]
struct Ordinal {
    body: u32,
    next: u32,
}

impl Ordinal {
    fn next(&mut self, body: u32) -> u32 {
        if self.body != body {
            *self = Ordinal { body, next: 0 };
        }
        self.next += 1;
        (self.next - 1).min(OVERFLOW)
    }
}

/// The cold halves of each span, cut out of the whole.
fn colds_by_span<'a>(mut colds: &'a mut [Cold], spans: &[Span]) -> Vec<Option<&'a mut [Cold]>> {
    spans
        .iter()
        .map(|span| {
            span.cold?;
            let (head, tail) = std::mem::take(&mut colds).split_at_mut(span.to - span.from);
            colds = tail;
            Some(head)
        })
        .collect()
}

/// Blocks still to be handed out, with their origins.
type Piece<'a, const P: usize, const T: usize> = (&'a mut [Block<P, T>], &'a [Origin]);

enum Work<'a> {
    One(Piece<'a, 1, 0>),
    Two(Piece<'a, 2, 1>),
    Four(Piece<'a, 4, 1>),
}

fn pieces<const P: usize, const T: usize>(shelf: &mut Shelf<P, T>) -> Piece<'_, P, T> {
    (&mut shelf.blocks, &shelf.origins)
}

fn take<'a, const P: usize, const T: usize>(rest: &mut Piece<'a, P, T>, blocks: usize) -> Piece<'a, P, T> {
    let (head, tail) = std::mem::take(&mut rest.0).split_at_mut(blocks);
    let (origins, others) = rest.1.split_at(blocks * LANES);
    *rest = (tail, others);
    (head, origins)
}

/// Fills blocks from manifolds.
struct Fill<'a, S> {
    chunks: &'a [Chunk],
    bodies: Bodies<'a>,
    surface: &'a S,
}

impl<S: Fn(usize, usize) -> Surface> Fill<'_, S> {
    fn span<const P: usize, const T: usize>(
        &self,
        (blocks, origins): Piece<'_, P, T>,
        mut colds: Option<&mut [Cold]>,
    ) {
        for (i, block) in blocks.iter_mut().enumerate() {
            *block = Block::IDLE;
            for (lane, origin) in origins[i * LANES..(i + 1) * LANES].iter().enumerate() {
                if origin.in_use {
                    let cold = colds.as_deref_mut().map(|colds| &mut colds[i]);
                    self.lane(block, cold, lane, *origin);
                }
            }
        }
    }

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
        let (line_a, line_b) = (&self.bodies.lines[a], &self.bodies.lines[b]);
        let surface = (self.surface)(a, b);
        let count = m.count as usize;
        let n = m.normal;
        let offset = (self.bodies.positions[b] - self.bodies.positions[a]).as_vec3();
        let middle = m.arms[..count].iter().sum::<Vec3>() / count as f32;
        let effective = |arm: Vec3, d: Vec3| effective_inverse_mass(line_a, line_b, arm, arm - offset, d);

        block.a[lane] = a as u32;
        block.b[lane] = b as u32;
        put3(&mut block.normal, lane, n);
        put3(&mut block.offset, lane, offset);
        for p in 0..P {
            let used = p < count;
            let arm = if used { m.arms[p] } else { middle };
            put3(&mut block.arms[p], lane, arm);
            block.distances[p][lane] = if used { m.distances[p] } else { 0.0 };
            block.masses[p][lane] = if used { invert(effective(arm, n)) } else { 0.0 };
            block.impulses[p][lane] = if used { memory.normals[p] } else { 0.0 };
        }

        let (s, t) = tangents_of(n);
        let k11 = effective(middle, s);
        let k22 = effective(middle, t);
        let k12 = coupling(line_a, line_b, middle, middle - offset, s, t);
        let inverse = invert(k11 * k22 - k12 * k12);
        for (column, x) in block.tangent_mass.iter_mut().zip([k22, -k12, k11]) {
            column[lane] = x * inverse;
        }
        block.tangent_impulse[0][lane] = memory.friction.dot(s);
        block.tangent_impulse[1][lane] = memory.friction.dot(t);
        block.friction[lane] = surface.friction;

        let twist_mass = invert(n.dot(line_a.inverse_inertia() * n) + n.dot(line_b.inverse_inertia() * n));
        for twist in 0..T {
            let lever =
                m.arms[..count].iter().map(|arm| (*arm - middle).length()).sum::<f32>() / count as f32;
            block.twist_mass[twist][lane] = twist_mass;
            block.twist_impulse[twist][lane] = memory.twist;
            block.twist_limit[twist][lane] = surface.friction * lever + surface.twisting;
        }

        let Some(cold) = cold else { return };
        cold.restitution[lane] = surface.restitution;
        for (p, arm) in m.arms[..count].iter().enumerate() {
            let v_a = line_a.velocity() + line_a.angular_velocity().cross(*arm);
            let v_b = line_b.velocity() + line_b.angular_velocity().cross(*arm - offset);
            cold.approach[p][lane] = n.dot(v_b - v_a);
        }
        cold.rolling_limit[lane] = surface.rolling;
        let compliance = line_a.inverse_inertia() + line_b.inverse_inertia();
        let determinant = compliance.determinant();
        let mass = if determinant > 0.0 { compliance.inverse() } else { Mat3::ZERO };
        let Mat3 { x_axis: x, y_axis: y, z_axis: z } = mass;
        for (column, value) in cold.rolling_mass.iter_mut().zip([x.x, x.y, x.z, y.y, y.z, z.z]) {
            column[lane] = value;
        }
        put3(
            &mut cold.rolling_impulse,
            lane,
            if surface.rolling > 0.0 { memory.rolling } else { Vec3::ZERO },
        );
        if T == 0 && surface.twisting > 0.0 {
            cold.twist_mass[lane] = twist_mass;
            cold.twist_impulse[lane] = memory.twist;
            cold.twist_limit[lane] = surface.twisting;
        }
    }
}

/// 1 / x, or 0 where nothing can give way.
fn invert(x: f32) -> f32 {
    if x > 0.0 { 1.0 / x } else { 0.0 }
}

/// Velocity along `d` that a unit impulse along `d` makes between two points with arms `ra` and `rb`, 1/kg.
fn effective_inverse_mass(a: &Line, b: &Line, ra: Vec3, rb: Vec3, d: Vec3) -> f32 {
    coupling(a, b, ra, rb, d, d)
}

/// Velocity along `d` that a unit impulse along `e` makes: d · K e with the report's K = K_a + K_b.
fn coupling(a: &Line, b: &Line, ra: Vec3, rb: Vec3, d: Vec3, e: Vec3) -> f32 {
    (a.inverse_mass() + b.inverse_mass()) * d.dot(e)
        + ra.cross(d).dot(a.inverse_inertia() * ra.cross(e))
        + rb.cross(d).dot(b.inverse_inertia() * rb.cross(e))
}
