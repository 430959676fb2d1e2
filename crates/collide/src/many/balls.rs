//! Balls against boxes, capsules and balls: the point of a core that is nearest to a ball's middle, of many pairs side by side.
//!
//! The core of a ball is a point, of a capsule a segment, of a box the box: each is a box, of which some extents are nothing.

use super::{Found, Meeting, SIDE};
use crate::closest::{CONCENTRIC, Closest};
use crate::convex::{put, within};
use crate::feature;
use crate::round::{Capsule, height_name};
use crate::sphere_box::region;
use rockfall_math::Vec3;
use rockfall_math::lanes::{Kernel, Lanes, Lanes3, Width};
use rockfall_shape::Shape;

/// A core and the skin around it, metres.
struct Core {
    half: Vec3,
    skin: f32,
}

impl Core {
    fn of(shape: &Shape) -> Option<Self> {
        let (half, skin) = match shape {
            Shape::Sphere { radius } => (Vec3::ZERO, *radius),
            Shape::Capsule { half_length, radius } => (Vec3::Z * *half_length, *radius),
            Shape::Box { half } => (*half, 0.0),
            _ => return None,
        };
        Some(Core { half, skin })
    }
}

/// Pairs that wait for the lanes to fill.
#[derive(Default)]
pub(super) struct Balls {
    /// Half extents of the core, and the middle of the ball in its frame.
    half: [[f32; SIDE]; 3],
    middle: [[f32; SIDE]; 3],
    /// Numbers of the pairs.
    who: [usize; SIDE],
    count: usize,
}

/// The core, the radius of the ball, the middle of the ball in the core's frame, and whether the ball is A.
fn parts(pair: &Meeting<'_>) -> Option<(Core, f32, Vec3, bool)> {
    match (pair.a, pair.b) {
        (other, Shape::Sphere { radius }) => {
            Some((Core::of(other)?, *radius, pair.b_in_a.translation, false))
        }
        (Shape::Sphere { radius }, other) => {
            Some((Core::of(other)?, *radius, pair.b_in_a.inverse().translation, true))
        }
        _ => None,
    }
}

impl Balls {
    /// Takes a pair if it is of this kind.
    pub(super) fn takes(&mut self, i: usize, pair: &Meeting<'_>) -> bool {
        let Some((core, _, middle, _)) = parts(pair) else { return false };
        for k in 0..3 {
            self.half[k][self.count] = core.half[k];
            self.middle[k][self.count] = middle[k];
        }
        self.who[self.count] = i;
        self.count += 1;
        true
    }

    pub(super) fn is_full(&self) -> bool {
        self.count == SIDE
    }

    pub(super) fn meet<'a>(
        &mut self,
        width: Width,
        meeting: &impl Fn(usize) -> Option<Meeting<'a>>,
        found: &mut Found<'_>,
    ) {
        if self.count == 0 {
            return;
        }
        let mut ways = Ways::default();
        width.run(Nearest { balls: self, ways: &mut ways });
        for (lane, &i) in self.who[..self.count].iter().enumerate() {
            let Some(pair) = meeting(i) else { continue };
            let Some((core, radius, middle, is_a)) = parts(&pair) else { continue };
            let distance = ways.distance[lane];
            // In the core, or to the bit on it, there is no way to go along.
            if distance.is_nan() || distance <= CONCENTRIC {
                found.one(i, &pair);
                continue;
            }
            let vector = |rows: &[[f32; SIDE]; 3]| Vec3::new(rows[0][lane], rows[1][lane], rows[2][lane]);
            let (on_a, between) = (vector(&ways.on_core), vector(&ways.between));
            let name = match if is_a { pair.b } else { pair.a } {
                Shape::Box { .. } => region(between),
                Shape::Capsule { half_length, radius } => {
                    height_name(Capsule { half_length: *half_length, radius: *radius }, middle.z)
                }
                _ => 0,
            };
            let normal = vector(&ways.normal);
            let closest = Closest { distance, normal, on_a, on_b: middle, feature: feature::pair(name, 0) };
            found.put(i, |_, out| {
                let first = out.len();
                let apart = put(within(closest.with_skins(core.skin, radius), pair.margin), out);
                if is_a {
                    out[first..].iter_mut().for_each(|manifold| manifold.swap(pair.b_in_a));
                }
                apart
            });
        }
        self.count = 0;
    }
}

/// The way from each core to the middle of the ball.
#[derive(Default)]
struct Ways {
    on_core: [[f32; SIDE]; 3],
    between: [[f32; SIDE]; 3],
    normal: [[f32; SIDE]; 3],
    distance: [f32; SIDE],
}

struct Nearest<'a> {
    balls: &'a Balls,
    ways: &'a mut Ways,
}

impl Kernel for Nearest<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self, token: L::Token) {
        let Nearest { balls, ways } = self;
        for l in (0..SIDE).step_by(L::WIDTH) {
            let load = |rows: &[[f32; SIDE]; 3]| {
                let [x, y, z] = rows.each_ref().map(|row| L::load(token, &row[l..]));
                Lanes3::new(x, y, z)
            };
            let save = |v: Lanes3<L>, rows: &mut [[f32; SIDE]; 3]| {
                v.x.store(&mut rows[0][l..]);
                v.y.store(&mut rows[1][l..]);
                v.z.store(&mut rows[2][l..]);
            };
            let (half, middle) = (load(&balls.half), load(&balls.middle));
            let clamp = |x: L, h: L| x.max(-h).min(h);
            let on_core =
                Lanes3::new(clamp(middle.x, half.x), clamp(middle.y, half.y), clamp(middle.z, half.z));
            let between = middle - on_core;
            let distance = between.dot(between).sqrt();
            save(on_core, &mut ways.on_core);
            save(between, &mut ways.between);
            save(
                Lanes3::new(between.x / distance, between.y / distance, between.z / distance),
                &mut ways.normal,
            );
            distance.store(&mut ways.distance[l..]);
        }
    }
}
