//! Stage 5, **touch**: collision detection: position, normal and signed distance of every contact.
//!
//! Reads pairs, poses and the last step's touches; writes manifolds, each point with the impulse of the point of the same
//! name in the last step. Pairs of which neither body moves are carried over. A run of [`RUN`] pairs is one chunk, so
//! that threads share nothing and the order of the manifolds is that of the keys.

use crate::Shape;
use crate::bodies::Bodies;
use crate::pair::{NEW, Pairs, rows};
use rayon::prelude::*;
use rockfall_collide::{Cache, Manifold as Local, collide};
use rockfall_math::Mat3;
use rockfall_math::room::make_room;
use rockfall_solve::line::Role;
use rockfall_solve::{Chunk, Manifold, Memory, NO_COLOR, row_of};

/// Pairs in a chunk.
pub(crate) const RUN: usize = 256;

/// The manifolds of all pairs of a step.
#[derive(Debug, Default)]
pub(crate) struct Touches {
    /// One for every [`RUN`] pairs.
    pub(crate) chunks: Vec<Chunk>,
    /// First manifold of each pair in its chunk; one more than there are pairs in each chunk.
    firsts: Vec<Vec<u32>>,
    /// What the pair functions remember of each pair.
    caches: Vec<Vec<Cache>>,
}

impl Touches {
    /// Bytes held.
    pub(crate) fn memory(&self) -> usize {
        let chunk = |c: &Chunk| {
            c.manifolds.capacity() * size_of::<Manifold>() + c.memories.capacity() * size_of::<Memory>()
        };
        self.chunks.iter().map(chunk).sum::<usize>()
            + self.firsts.iter().map(|f| f.capacity() * size_of::<u32>()).sum::<usize>()
            + self.caches.iter().map(|c| c.capacity() * size_of::<Cache>()).sum::<usize>()
    }

    /// Whether pair `number` is in contact, or about to be.
    pub(crate) fn has_manifold(&self, number: usize) -> bool {
        let (chunk, pair) = (number / RUN, number % RUN);
        self.firsts[chunk][pair] < self.firsts[chunk][pair + 1]
    }

    /// Manifolds, memories and cache of pair `number`; nothing for a pair that is new.
    fn of(&self, number: u32) -> (&[Manifold], &[Memory], Cache) {
        if number == NEW {
            return (&[], &[], Cache::default());
        }
        let (chunk, pair) = (number as usize / RUN, number as usize % RUN);
        let range = self.firsts[chunk][pair] as usize..self.firsts[chunk][pair + 1] as usize;
        let content = &self.chunks[chunk];
        (&content.manifolds[range.clone()], &content.memories[range], self.caches[chunk][pair])
    }
}

/// Finds all contacts. `before` holds the last step's touches; `now` is overwritten. Returns the rows of bodies whose
/// contact was not finite.
pub(crate) fn touch(
    pairs: &mut Pairs,
    bodies: &Bodies,
    shapes: &[Shape],
    before: &Touches,
    now: &mut Touches,
) -> Vec<usize> {
    let chunks = pairs.keys.len().div_ceil(RUN);
    now.chunks.resize_with(chunks, Chunk::default);
    now.firsts.resize_with(chunks, Vec::new);
    now.caches.resize_with(chunks, Vec::new);
    let broken: Vec<usize> = (&mut now.chunks, &mut now.firsts, &mut now.caches)
        .into_par_iter()
        .zip(pairs.keys.par_chunks(RUN).zip(pairs.befores.par_chunks(RUN)))
        .enumerate()
        .flat_map_iter(|(i, ((chunk, firsts, caches), (keys, befores)))| {
            let mut scratch = Vec::new();
            let mut broken = Vec::new();
            chunk.manifolds.clear();
            chunk.memories.clear();
            // About as many as in the last step.
            let expected = before.chunks.get(i).map_or(0, |c| c.manifolds.len());
            make_room(&mut chunk.manifolds, expected);
            make_room(&mut chunk.memories, expected);
            firsts.clear();
            caches.clear();
            for (&key, &number) in keys.iter().zip(befores) {
                firsts.push(chunk.manifolds.len() as u32);
                let (a, b) = rows(key);
                let (manifolds, memories, mut cache) = before.of(number);
                if rests(bodies, a as usize) && rests(bodies, row_of(b)) && number != NEW {
                    carry(chunk, a, b, manifolds, memories);
                } else {
                    scratch.clear();
                    meet(bodies, shapes, a as usize, row_of(b), &mut cache, &mut scratch);
                    for local in &scratch {
                        if is_finite(local) {
                            enter(chunk, bodies, a, b, local, (manifolds, memories));
                        } else {
                            broken.push(a as usize);
                        }
                    }
                }
                caches.push(cache);
            }
            firsts.push(chunk.manifolds.len() as u32);
            let len = chunk.manifolds.len();
            make_room(&mut chunk.manifolds, len);
            make_room(&mut chunk.memories, len);
            make_room(firsts, RUN + 1);
            make_room(caches, RUN);
            broken
        })
        .collect();
    pairs.befores.clear();
    pairs.befores.extend(0..pairs.keys.len() as u32);
    broken
}

/// Whether nothing moves the body of a row in this step.
fn rests(bodies: &Bodies, row: usize) -> bool {
    match bodies.roles[row] {
        Role::Still => true,
        Role::Free => false,
        Role::Driven => bodies.lines[row].motion[..6].iter().all(|&x| x == 0.0),
    }
}

/// Takes the manifolds of a pair over as they were; rows may have new numbers.
fn carry(chunk: &mut Chunk, a: u32, b: u32, manifolds: &[Manifold], memories: &[Memory]) {
    chunk.manifolds.extend(manifolds.iter().map(|&m| Manifold { a, b, ..m }));
    chunk.memories.extend_from_slice(memories);
}

/// Runs the pair function.
fn meet(bodies: &Bodies, shapes: &[Shape], a: usize, b: usize, cache: &mut Cache, out: &mut Vec<Local>) {
    let (Some(shape_a), Some(shape_b)) =
        (shapes.get(bodies.shapes[a] as usize), shapes.get(bodies.shapes[b] as usize))
    else {
        return;
    };
    let b_in_a = bodies.shape_pose(a).see(&bodies.shape_pose(b));
    collide(shape_a, shape_b, &b_in_a, bodies.reaches[a] + bodies.reaches[b], cache, out);
}

fn is_finite(local: &Local) -> bool {
    local.normal.is_finite()
        && local.points().iter().all(|p| p.position.is_finite() && p.distance.is_finite())
}

/// How far a point may have gone in a step to be taken for the same under a new name, as a share of its arm.
const SAME: f32 = 0.05;

/// Turns a manifold into the world's axes and gives it the impulses of its points' namesakes.
///
/// Where two faces cover each other, as in a tower of equal boxes, rounding decides which corner or crossing of edges names
/// a point, and names change from step to step. So a point without a namesake takes the impulse of the nearest point that
/// has none either.
fn enter(
    chunk: &mut Chunk,
    bodies: &Bodies,
    a: u32,
    b: u32,
    local: &Local,
    (manifolds, memories): (&[Manifold], &[Memory]),
) {
    let turn = Mat3::from_quat(bodies.rotations[a as usize]);
    let mut manifold =
        Manifold { a, b, count: local.count, normal: turn * local.normal, ..Manifold::default() };
    let mut memory = Memory { color: NO_COLOR, ..Memory::default() };
    for (p, point) in local.points().iter().enumerate() {
        manifold.arms[p] = turn * (point.position - bodies.centers[a as usize]);
        manifold.distances[p] = point.distance;
        memory.features[p] = point.feature;
    }
    let namesake = |feature: u32, old: usize| {
        memories[old].features[..manifolds[old].count as usize].iter().position(|&f| f == feature)
    };
    let knows = |old: &usize| local.points().iter().any(|p| namesake(p.feature, *old).is_some());
    // A convex pair has one manifold, which goes on even where all of its points have new names.
    let source = (0..memories.len()).find(knows).or((memories.len() == 1).then_some(0));
    if let Some(i) = source {
        let (before, old) = (&manifolds[i], &memories[i]);
        let (mut free_old, mut free_new) = ([true; 4], [true; 4]);
        for (p, point) in local.points().iter().enumerate() {
            if let Some(q) = namesake(point.feature, i) {
                memory.normals[p] = old.normals[q];
                (free_old[q], free_new[p]) = (false, false);
            }
        }
        for p in (0..local.count as usize).filter(|&p| free_new[p]) {
            let arm = manifold.arms[p];
            let mut nearest = (SAME * SAME * arm.length_squared(), None);
            for q in (0..before.count as usize).filter(|&q| free_old[q]) {
                let way = (before.arms[q] - arm).length_squared();
                if way < nearest.0 {
                    nearest = (way, Some(q));
                }
            }
            if let Some(q) = nearest.1 {
                memory.normals[p] = old.normals[q];
                free_old[q] = false;
            }
        }
        (memory.friction, memory.twist, memory.rolling) = (old.friction, old.twist, old.rolling);
        memory.color = old.color;
    }
    chunk.manifolds.push(manifold);
    chunk.memories.push(memory);
}
