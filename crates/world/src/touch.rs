//! Stage 5, **touch**: collision detection: position, normal and signed distance of every contact.
//!
//! Reads pairs, poses and the last step's manifolds; writes manifolds in their place, each point with the impulse of the
//! point of the same name in the last step. Pairs of which neither body moves are carried over. Threads share nothing: each
//! takes whole runs of pairs.

use crate::Shape;
use crate::bodies::Bodies;
use crate::recall::{Recall, follow, looseness};
use crate::touches::{NEW, Run, Touches, rows};
use rayon::prelude::*;
use rockfall_collide::{Manifold as Local, collide};
use rockfall_math::Mat3;
use rockfall_math::room::make_room;
use rockfall_solve::line::Role;
use rockfall_solve::{Chunk, Manifold, Memory, NO_COLOR, row_of};

/// Finds all contacts. Returns the rows of bodies whose contact was not finite.
pub(crate) fn touch(touches: &mut Touches, bodies: &Bodies, shapes: &[Shape]) -> Vec<usize> {
    (&mut touches.runs, &mut touches.chunks)
        .into_par_iter()
        .map_init(Fresh::default, |fresh, (run, chunk)| {
            if run.befores.is_empty() && run.keys.iter().all(|&key| at_rest(bodies, key)) {
                return Vec::new();
            }
            let broken = fresh.find(run, chunk, bodies, shapes);
            fresh.replace(run, chunk);
            broken
        })
        .flatten_iter()
        .collect()
}

/// A run's contacts of this step, before they take the place of the last step's.
#[derive(Default)]
struct Fresh {
    chunk: Chunk,
    firsts: Vec<u32>,
    recalls: Vec<Recall>,
    locals: Vec<Local>,
}

impl Fresh {
    /// Finds the contacts of a run.
    fn find(&mut self, run: &Run, before: &Chunk, bodies: &Bodies, shapes: &[Shape]) -> Vec<usize> {
        let Fresh { chunk, firsts, recalls, locals } = self;
        let mut broken = Vec::new();
        for (i, &key) in run.keys.iter().enumerate() {
            firsts.push(chunk.manifolds.len() as u32);
            let (a, b) = rows(key);
            let place = run.before(i);
            let (mut manifolds, mut memories, mut recall): (&[_], &[_], _) = (&[], &[], Recall::default());
            if place != NEW {
                let range = run.manifolds(place);
                (manifolds, memories) = (&before.manifolds[range.clone()], &before.memories[range]);
                recall = run.recalls[place as usize];
            }
            if place != NEW && at_rest(bodies, key) {
                chunk.manifolds.extend_from_slice(manifolds);
                chunk.memories.extend_from_slice(memories);
            } else if place != NEW && still_serves(&recall, bodies, key, manifolds) {
                let (drift_a, drift_b) = (&bodies.drifts[a as usize], &bodies.drifts[row_of(b)]);
                let moved = drift_b.translation() - drift_a.translation();
                let offset = (bodies.positions[row_of(b)] - bodies.positions[a as usize]).as_vec3() - moved;
                chunk.manifolds.extend(manifolds.iter().map(|&before| {
                    let mut manifold = before;
                    follow(&mut manifold, offset, drift_a, drift_b);
                    manifold
                }));
                chunk.memories.extend_from_slice(memories);
            } else {
                locals.clear();
                meet(bodies, shapes, a as usize, row_of(b), &mut recall, locals);
                for local in locals.iter() {
                    if is_finite(local) {
                        enter(chunk, bodies, a, b, local, (manifolds, memories));
                    } else {
                        broken.push(a as usize);
                    }
                }
            }
            recalls.push(recall);
        }
        firsts.push(chunk.manifolds.len() as u32);
        broken
    }

    /// Puts what was found into the run and is empty again.
    fn replace(&mut self, run: &mut Run, chunk: &mut Chunk) {
        run.befores = Vec::new();
        take(&mut self.firsts, &mut run.firsts);
        take(&mut self.recalls, &mut run.recalls);
        take(&mut self.chunk.manifolds, &mut chunk.manifolds);
        take(&mut self.chunk.memories, &mut chunk.memories);
    }
}

/// Moves the content of `from`, which keeps its room, to `to`.
fn take<T: Copy>(from: &mut Vec<T>, to: &mut Vec<T>) {
    to.clear();
    make_room(to, from.len());
    to.extend_from_slice(from);
    from.clear();
}

/// Whether neither body of a pair moves.
fn at_rest(bodies: &Bodies, key: u64) -> bool {
    let (a, b) = rows(key);
    rests(bodies, a as usize) && rests(bodies, row_of(b))
}

/// Whether the body of a row has not moved in the last step and nothing moves it in this one.
fn rests(bodies: &Bodies, row: usize) -> bool {
    let still = match bodies.roles[row] {
        Role::Still => true,
        Role::Free => false,
        Role::Driven => bodies.lines[row].motion[..6].iter().all(|&x| x == 0.0),
    };
    still && bodies.drifts[row].0.iter().all(|&x| x == 0.0)
}

/// Whether what a pair knows is still true enough.
fn still_serves(recall: &Recall, bodies: &Bodies, key: u64, manifolds: &[Manifold]) -> bool {
    let (a, b) = (rows(key).0 as usize, row_of(rows(key).1));
    let margin = if manifolds.is_empty() { bodies.reaches[a] + bodies.reaches[b] } else { 0.0 };
    recall.left(bodies.ways[a].wrapping_add(bodies.ways[b])) > margin
}

/// Runs the pair function.
fn meet(bodies: &Bodies, shapes: &[Shape], a: usize, b: usize, recall: &mut Recall, out: &mut Vec<Local>) {
    let (Some(shape_a), Some(shape_b)) =
        (shapes.get(bodies.shapes[a] as usize), shapes.get(bodies.shapes[b] as usize))
    else {
        return;
    };
    let b_in_a = bodies.shape_pose(a).see(&bodies.shape_pose(b));
    let margin = bodies.reaches[a] + bodies.reaches[b];
    let apart = collide(shape_a, shape_b, &b_in_a, margin, &mut recall.cache, out);
    let serves = if out.is_empty() { apart } else { looseness(shape_a, shape_b) };
    recall.set(bodies.ways[a].wrapping_add(bodies.ways[b]), serves);
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
