//! What beams from the eye through a few neighbouring pixels can meet: found once for all of them.

use super::hierarchy::{Beam, Visit, WIDTH};
use super::solid::{self, Balls};
use super::{Hit, Nearest, View};
use rockfall_math::Vec3;
use rockfall_math::lanes::Lanes;

/// Items before the eye within some pixels, the nearest first.
pub(crate) struct Tile {
    /// Distance of each one's box from the eye, and its number.
    items: Vec<(f32, u32)>,
    /// Balls around them, eight by eight; those that fill up the last eight are nowhere.
    balls: Vec<Balls>,
}

impl View<'_> {
    /// What is within the cone that these four directions are the edges of, one after the other around it.
    #[inline(always)]
    pub(crate) fn tile<L: Lanes>(&self, token: L::Token, edges: [Vec3; 4]) -> Tile {
        let middle = edges[0] + edges[1] + edges[2] + edges[3];
        let mut sides = [Vec3::ZERO; 4];
        for k in 0..4 {
            let normal = edges[k].cross(edges[(k + 1) % 4]).normalize_or_zero();
            sides[k] = if normal.dot(middle) < 0.0 { -normal } else { normal };
        }
        let mut items = Vec::new();
        self.hierarchy.gather::<L>(token, &sides, &mut items);
        items.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let ball = |place: usize| match items.get(place) {
            Some(&(_, item)) => {
                let item = &self.items[item as usize];
                [item.center.x, item.center.y, item.center.z, item.radius]
            }
            None => [f32::NAN; 4],
        };
        let eight = |first: usize| std::array::from_fn(|k| std::array::from_fn(|lane| ball(first + lane)[k]));
        let balls = (0..items.len()).step_by(WIDTH).map(eight).collect();
        Tile { items, balls }
    }

    /// What a beam from the eye meets first; it is one of those of the tile.
    #[inline(always)]
    pub(crate) fn first_of<L: Lanes>(&self, token: L::Token, beam: &Beam, tile: &Tile) -> Option<Hit> {
        let mut nearest = Nearest::beyond_floors(self, beam);
        let mut max = nearest.beam.max;
        for (first, balls) in tile.balls.iter().enumerate() {
            let first = first * WIDTH;
            if tile.items[first].0 > max {
                break;
            }
            let mut near = solid::nears_of::<L>(token, balls, beam) & 0xff;
            while near != 0 {
                let lane = near.trailing_zeros() as usize;
                near &= near - 1;
                // Beyond the last one nothing is near.
                let Some(&(distance, item)) = tile.items.get(first + lane) else { break };
                if distance <= max {
                    max = nearest.visit::<L>(token, item, distance, max);
                }
            }
        }
        self.hit(&nearest)
    }
}

#[cfg(test)]
mod tests {
    use super::super::LANES;
    use super::*;
    use crate::{Actor, Stage, stone};
    use rockfall_math::hash::mix;
    use rockfall_math::lanes::{Kernel, Width};
    use rockfall_math::{DVec3, Pose, Quat, rotation};
    use rockfall_shape::{Hull, Shape};
    use std::sync::Arc;

    /// Beams of a tile by themselves and through the tile: how many met something, all alike.
    struct Compare<'a>(&'a View<'a>);

    impl Kernel for Compare<'_> {
        type Output = usize;

        fn run<L: Lanes>(self, token: L::Token) -> usize {
            let mut met = 0;
            // At no other width are nodes read.
            for k in (0..400_u32).filter(|_| L::WIDTH == LANES) {
                let [x, y] = [k % 20, k / 20].map(|i| 0.1 * (i as f32 - 10.0));
                let direction = |a: f32, b: f32| Vec3::new(x + 0.1 * a, 1.0, y + 0.1 * b).normalize();
                let edges =
                    [direction(0.0, 0.0), direction(1.0, 0.0), direction(1.0, 1.0), direction(0.0, 1.0)];
                let tile = self.0.tile::<L>(token, edges);
                for (a, b) in [(0.01, 0.01), (0.5, 0.5), (0.99, 0.3), (0.2, 0.99)] {
                    let beam = Beam::new(Vec3::ZERO, direction(a, b), f32::INFINITY);
                    let (alone, with) =
                        (self.0.first::<L>(token, &beam), self.0.first_of::<L>(token, &beam, &tile));
                    assert_eq!(alone.map(|hit| (hit.actor, hit.t)), with.map(|hit| (hit.actor, hit.t)));
                    met += usize::from(alone.is_some());
                }
            }
            met
        }
    }

    #[test]
    fn a_beam_of_a_tile_meets_what_it_meets_by_itself() {
        let share = |k: u32| (mix(k.into()) >> 40) as f32 / (1 << 24) as f32 - 0.5;
        let hull = Hull::cuboid(Vec3::new(0.5, 0.4, 0.6));
        let shapes = vec![
            Shape::Sphere { radius: 0.5 },
            Shape::Box { half: Vec3::new(0.5, 0.2, 0.4) },
            Shape::Hull(Arc::new(hull)),
            Shape::Capsule { half_length: 0.4, radius: 0.2 },
        ];
        let actor = |k: u32| {
            let [a, b, c, d] = [0, 1, 2, 3].map(|i| share(8 * k + i));
            let rotation = rotation::normalize(Quat::from_xyzw(
                share(8 * k + 4),
                share(8 * k + 5),
                share(8 * k + 6),
                0.6,
            ));
            let position = DVec3::new(f64::from(40.0 * a), f64::from(40.0 * b), f64::from(30.0 * c + d));
            Actor { shape: k % 4, pose: Pose { position, rotation }, color: stone(1).to_array(), moves: true }
        };
        let stage = Stage { shapes, actors: (0..3000).map(actor).collect() };
        let met = Width::new(LANES).run(Compare(&View::new(&stage, DVec3::ZERO)));
        assert!(met > 800 && met < 1600, "{met}");
    }
}
