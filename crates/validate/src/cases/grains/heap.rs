//! Balls in a box, and what their places say.

use crate::Error;
use crate::engine::{Surface, Terms, Thing};
use crate::stage::{Numbers, Rig, Stage, ball};
use rockfall::math::{DVec3, Pose, Vec3};
use std::collections::BTreeMap;

/// Radius, m.
pub(super) const R: f64 = 0.5;

/// 60 Hz in four sub-steps.
pub(super) const TERMS: Terms = Terms::FRAMES;

/// A box without floor, `width` metres across around the z axis.
pub(super) fn walls(
    rig: &Rig,
    terms: Terms,
    width: f64,
    surface: Surface,
) -> Result<(Stage, [usize; 4]), Error> {
    let mut stage = rig.stage(terms)?;
    let half = (0.5 * width) as f32;
    let [a, b, c, d] = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y];
    let walls = [
        stage.wall(a, -half, surface)?,
        stage.wall(b, -half, surface)?,
        stage.wall(c, -half, surface)?,
        stage.wall(d, -half, surface)?,
    ];
    Ok((stage, walls))
}

/// Pours `count` things, `size` metres large, into a box from `base` up: a loose lattice, each moved at random, in which they fall together.
pub(super) fn pour(
    stage: &mut Stage,
    width: f64,
    base: f64,
    count: usize,
    thing: &Thing,
    size: f64,
    seed: u64,
) -> Result<Vec<usize>, Error> {
    let low = DVec3::new(-0.5 * width, -0.5 * width, base);
    pour_over(stage, low, [width; 2], count, thing, size, seed)
}

/// The same over a rectangle, by its lower corner and its sides along x and y, metres.
pub(super) fn pour_over(
    stage: &mut Stage,
    low: DVec3,
    sides: [f64; 2],
    count: usize,
    thing: &Thing,
    size: f64,
    seed: u64,
) -> Result<Vec<usize>, Error> {
    let mut random = Numbers(seed);
    let across = sides.map(|side| layer(side, size));
    let pitch = [sides[0] / across[0] as f64, sides[1] / across[1] as f64];
    // Layers are as far apart as balls along x.
    let pitch = DVec3::new(pitch[0], pitch[1], pitch[0]);
    let mut ids = Vec::with_capacity(count);
    for i in 0..count {
        let [nx, ny] = across;
        let cell = DVec3::new((i % nx) as f64, (i / nx % ny) as f64, (i / nx / ny) as f64);
        let position = low + (cell + 0.5) * pitch + (random.vector() - 0.5) * (0.9 * (pitch - size));
        let velocity = (random.vector() * 2.0 - 1.0).as_vec3() * 0.5;
        ids.push(stage.put(&thing.clone().pose(Pose::at(position)).moving(velocity, Vec3::ZERO))?);
    }
    Ok(ids)
}

/// How many things of a size the loose lattice has along a side.
pub(super) fn layer(side: f64, size: f64) -> usize {
    (side / (1.12 * size)).floor() as usize
}

/// A ball of 1 m.
pub(super) fn grain(surface: Surface) -> Thing {
    Thing::new(ball(R as f32), surface, DVec3::ZERO)
}

/// Steps until all of the balls are slow, for `most` seconds at the longest. Returns the mean kinetic energy of a ball over m g R, which says
/// how much it still moves.
pub(super) fn settle(stage: &mut Stage, ids: &[usize], most: f64) -> Result<f64, Error> {
    let mut energy = f64::INFINITY;
    let start = stage.time();
    while stage.time() - start < most && energy > 1e-6 {
        stage.seconds(0.5)?;
        let sum = ids.iter().try_fold(0.0, |sum, &id| Ok::<f64, Error>(sum + stage.kinetic(id)?))?;
        let weight = ids.first().map_or(1.0, |&id| stage.mass(id)) * stage.terms.g() * R;
        energy = sum / ids.len() as f64 / weight;
    }
    Ok(energy)
}

/// Centres of all of the balls.
pub(super) fn places(stage: &Stage, ids: &[usize]) -> Result<Vec<DVec3>, Error> {
    ids.iter().map(|&id| stage.position(id)).collect()
}

/// Part of a box's volume that is in balls, by their centres.
pub(super) fn fraction(places: &[DVec3], [low, high]: [DVec3; 2]) -> f64 {
    let inside = |p: DVec3, margin: f64| p.cmpgt(low + margin).all() && p.cmplt(high - margin).all();
    // A ball that the border cuts counts by the share of its points, of a lattice in it, that are inside.
    let lattice: Vec<DVec3> = (0..12 * 12 * 12)
        .map(|i| DVec3::new((i % 12) as f64, (i / 12 % 12) as f64, (i / 144) as f64))
        .map(|p| (p - 5.5) / 6.0 * R)
        .filter(|p| p.length() <= R)
        .collect();
    let share = |p: &DVec3| {
        if inside(*p, R) {
            1.0
        } else if inside(*p, -R) {
            lattice.iter().filter(|q| inside(*p + **q, 0.0)).count() as f64 / lattice.len() as f64
        } else {
            0.0
        }
    };
    let balls: f64 = places.iter().map(share).sum();
    let size = high - low;
    balls * 4.0 / 3.0 * core::f64::consts::PI * R.powi(3) / (size.x * size.y * size.z)
}

/// How many balls touch each ball, nearer than `gap` metres.
pub(super) fn contacts(places: &[DVec3], gap: f64) -> Vec<u32> {
    let reach = 2.0 * R + gap;
    let cell = |p: &DVec3| (*p / reach).floor().as_i64vec3().to_array();
    let mut cells: BTreeMap<[i64; 3], Vec<usize>> = BTreeMap::new();
    for (i, place) in places.iter().enumerate() {
        cells.entry(cell(place)).or_default().push(i);
    }
    let near = |p: &DVec3| {
        let [x, y, z] = cell(p);
        let around = (0..27).filter_map(|i| cells.get(&[x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1]));
        around.flatten().filter(|&&j| (places[j] - *p).length() < reach).count() as u32 - 1
    };
    places.iter().map(near).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cubic lattice of pitch 1.
    fn lattice(n: usize) -> Vec<DVec3> {
        (0..n * n * n).map(|i| DVec3::new((i % n) as f64, (i / n % n) as f64, (i / n / n) as f64)).collect()
    }

    #[test]
    fn a_cubic_lattice_is_as_full_as_the_books_say() {
        let places = lattice(8);
        for shift in [0.0, 0.25, 0.5] {
            let got = fraction(&places, [DVec3::splat(2.0 + shift), DVec3::splat(5.0 + shift)]);
            assert!((got - core::f64::consts::PI / 6.0).abs() < 5e-3, "{got}");
        }
    }

    #[test]
    fn a_cubic_lattice_has_six_neighbours_inside_and_three_at_corners() {
        let counts = contacts(&lattice(5), 1e-6);
        assert_eq!((counts[0], counts[2 + 5 * 2 + 25 * 2]), (3, 6));
        assert!(contacts(&lattice(3), -1e-6).iter().all(|&n| n == 0));
    }
}
