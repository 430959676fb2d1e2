//! Prints how long the pair functions take, in nanoseconds per pair, on one thread: each pair alone, and many together; beside them, in turns on the same
//! pairs, `parry3d`'s contact manifolds, and how many times as long as together those take. Build it with `--release`; a word narrows it to the sets whose name has it, a number after it
//! is that of the rounds.

use parry3d::math::{Pose, Rotation};
use parry3d::query::{
    ContactManifold, ContactManifoldsWorkspace, DefaultQueryDispatcher, PersistentQueryDispatcher,
};
use parry3d::shape::{Ball, Capsule, ConvexPolyhedron, Cuboid, SharedShape};
use rockfall_collide::{Cache, Manifold, Meeting, collide, collide_all};
use rockfall_math::hash::mix;
use rockfall_math::lanes::Width;
use rockfall_math::{Isometry, Mat3, Quat, Vec3, rotation};
use rockfall_shape::{Hull, Shape};
use std::sync::Arc;
use std::time::Instant;

/// Pairs in a set; few enough to stay in the cache, many enough that no branch is learnt by heart.
const PAIRS: usize = 4096;
/// Unless the command line says otherwise.
const ROUNDS: usize = 50;
/// Pairs that are met together.
const PORTION: usize = 256;

struct Random(u64);

impl Random {
    fn between(&mut self, low: f32, high: f32) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        low + (high - low) * (mix(self.0) >> 40) as f32 / (1_u32 << 24) as f32
    }

    fn vector(&mut self) -> Vec3 {
        Vec3::new(self.between(-1.0, 1.0), self.between(-1.0, 1.0), self.between(-1.0, 1.0))
    }

    fn rotation(&mut self, tilt: f32) -> Quat {
        rotation::from_rotation_vector(tilt * self.vector())
    }

    fn hull(&mut self, corners: usize) -> Shape {
        let points: Vec<Vec3> = (0..corners).map(|_| 0.7 * self.vector().normalize()).collect();
        Shape::Hull(Arc::new(Hull::from_points(&points).expect("random points span a volume")))
    }
}

/// How pairs are met again and again.
#[derive(Clone, Copy, PartialEq)]
enum Memory {
    /// As if for the first time.
    Fresh,
    /// Where they were, with what they remember.
    Still,
    /// With what they remember, after each has gone some millimetres and turned by some milliradians.
    Moved,
}

type Pairs = [(Shape, Shape, Isometry)];

/// What parry3d remembers of a pair.
type PeerMemory = (Vec<ContactManifold<(), ()>>, Option<ContactManifoldsWorkspace>);

/// The same pairs for parry3d, and what it remembers of each.
struct Peer {
    shapes: Vec<[SharedShape; 2]>,
    memories: Vec<PeerMemory>,
}

impl Peer {
    /// None where it lacks a shape.
    fn new(pairs: &Pairs) -> Option<Self> {
        let shapes = pairs.iter().map(|(a, b, _)| Some([shape(a)?, shape(b)?])).collect::<Option<_>>()?;
        Some(Peer { shapes, memories: (0..pairs.len()).map(|_| (Vec::new(), None)).collect() })
    }

    /// All pairs once; seconds.
    fn round(&mut self, poses: &[Isometry], margin: f32) -> f64 {
        let pose = |pose: &Isometry| Pose::from_parts(pose.translation, Rotation::from_mat3(&pose.rotation));
        let poses: Vec<Pose> = poses.iter().map(pose).collect();
        let start = Instant::now();
        for (([a, b], pose), (manifolds, workspace)) in self.shapes.iter().zip(&poses).zip(&mut self.memories)
        {
            DefaultQueryDispatcher
                .contact_manifolds(pose, &**a, &**b, margin, manifolds, workspace)
                .expect("it knows these shapes");
        }
        start.elapsed().as_secs_f64()
    }
}

fn shape(shape: &Shape) -> Option<SharedShape> {
    Some(match shape {
        Shape::Sphere { radius } => SharedShape::new(Ball::new(*radius)),
        Shape::Capsule { half_length, radius } => {
            SharedShape::new(Capsule::new(Vec3::Z * -*half_length, Vec3::Z * *half_length, *radius))
        }
        Shape::Box { half } => SharedShape::new(Cuboid::new(*half)),
        Shape::Hull(hull) => SharedShape::new(ConvexPolyhedron::from_convex_hull(&hull.vertices)?),
        _ => return None,
    })
}

/// Prints the least time of some rounds.
fn measure(name: &str, pairs: &Pairs, margin: f32) {
    if std::env::args().nth(1).is_some_and(|part| !name.contains(&part)) {
        return;
    }
    let rounds = std::env::args().nth(2).map_or(ROUNDS, |n| n.parse().expect("the number of the rounds"));
    for memory in [Memory::Fresh, Memory::Still, Memory::Moved] {
        let mut poses: Vec<Isometry> = pairs.iter().map(|(.., pose)| *pose).collect();
        let mut random = Random(2);
        let mut caches = [vec![Cache::default(); pairs.len()], vec![Cache::default(); pairs.len()]];
        let (mut mets, mut found) = (Vec::new(), Vec::new());
        let mut out: Vec<Manifold> = Vec::with_capacity(pairs.len());
        let mut peer = Peer::new(pairs);
        let mut least = [f64::INFINITY; 3];
        for _ in 0..rounds {
            if memory == Memory::Fresh {
                caches.iter_mut().for_each(|caches| caches.fill(Cache::default()));
                peer = Peer::new(pairs);
            }
            if memory == Memory::Moved {
                for (pose, (.., start)) in poses.iter_mut().zip(pairs) {
                    let turn = Mat3::from_quat(random.rotation(2e-3));
                    let translation = start.translation + 2e-3 * random.vector();
                    *pose = Isometry { rotation: turn * start.rotation, translation };
                }
            }
            out.clear();
            let start = Instant::now();
            for (((a, b, _), pose), cache) in pairs.iter().zip(&poses).zip(&mut caches[0]) {
                collide(a, b, pose, margin, cache, &mut out);
            }
            least[0] = least[0].min(start.elapsed().as_secs_f64());
            // In portions of some hundreds, as a world does it.
            let start = Instant::now();
            for (k, caches) in caches[1].chunks_mut(PORTION).enumerate() {
                let meeting = |i: usize| {
                    let (a, b, _) = &pairs[k * PORTION + i];
                    Some(Meeting { a, b, b_in_a: &poses[k * PORTION + i], margin })
                };
                collide_all(Width::native(), meeting, caches, &mut mets, &mut found);
            }
            least[1] = least[1].min(start.elapsed().as_secs_f64());
            if let Some(peer) = &mut peer {
                least[2] = least[2].min(peer.round(&poses, margin));
            }
        }
        let points: u32 = out.iter().map(|m| m.count).sum();
        let [alone, together, other] = least.map(|least| least / pairs.len() as f64 * 1e9);
        let beside =
            if peer.is_some() { format!("{other:7.0} ns, {:4.1}", other / together) } else { String::new() };
        println!(
            "{name:28} {} {alone:7.0} ns {together:7.0} ns {beside:18}  {:5.1} % touch, {:.1} points each",
            ["fresh", "still", "moved"][memory as usize],
            100.0 * out.len() as f64 / pairs.len() as f64,
            f64::from(points) / out.len().max(1) as f64,
        );
    }
}

fn main() {
    let mut random = Random(1);
    let cube = Shape::Box { half: Vec3::splat(0.5) };
    let ball = Shape::Sphere { radius: 0.5 };
    let capsule = Shape::Capsule { half_length: 0.5, radius: 0.3 };
    let (small, large) = (random.hull(16), random.hull(32));
    let mut set = |a: &Shape, b: &Shape, tilt: f32, at: &dyn Fn(&mut Random) -> Vec3| {
        (0..PAIRS)
            .map(|_| {
                let translation = at(&mut random);
                let pose = Isometry { rotation: Mat3::from_quat(random.rotation(tilt)), translation };
                (a.clone(), b.clone(), pose)
            })
            .collect::<Vec<_>>()
    };
    let apart = |r: &mut Random| 1.6 * r.vector().normalize() + 0.1 * r.vector();
    let stacked =
        |r: &mut Random| Vec3::new(r.between(-0.4, 0.4), r.between(-0.4, 0.4), r.between(0.995, 1.0));
    let hovering =
        |r: &mut Random| Vec3::new(r.between(-0.4, 0.4), r.between(-0.4, 0.4), r.between(1.002, 1.01));
    let pile = |r: &mut Random| 1.12 * r.vector().normalize();
    measure("box-box apart", &set(&cube, &cube, 1.0, &apart), 0.02);
    measure("box-box stacked", &set(&cube, &cube, 1e-3, &stacked), 0.02);
    measure("box-box hovering", &set(&cube, &cube, 1e-3, &hovering), 0.02);
    measure("box-box any contact", &set(&cube, &cube, 1.0, &pile), 0.02);
    measure("sphere-sphere", &set(&ball, &ball, 1.0, &|r: &mut Random| r.vector()), 0.02);
    measure("sphere-box", &set(&cube, &ball, 1.0, &|r: &mut Random| 1.2 * r.vector()), 0.02);
    measure("capsule-capsule", &set(&capsule, &capsule, 1.0, &|r: &mut Random| 0.8 * r.vector()), 0.02);
    measure("capsule-hull16", &set(&small, &capsule, 1.0, &|r: &mut Random| 1.1 * r.vector()), 0.02);
    measure("capsule-hull32", &set(&large, &capsule, 1.0, &|r: &mut Random| 1.1 * r.vector()), 0.02);
    measure("capsule-box", &set(&cube, &capsule, 1.0, &|r: &mut Random| 1.1 * r.vector()), 0.02);
    measure("hull16-hull16 apart", &set(&small, &small, 3.0, &apart), 0.02);
    measure("hull16-hull16 contact", &set(&small, &small, 3.0, &pile), 0.02);
    let resting = |r: &mut Random| 1.27 * r.vector().normalize();
    measure("hull16-hull16 shallow", &set(&small, &small, 3.0, &resting), 0.02);
    measure(
        "hull32-hull32 shallow",
        &set(&large, &large, 3.0, &|r: &mut Random| 1.32 * r.vector().normalize()),
        0.02,
    );
    measure("hull32-hull32 contact", &set(&large, &large, 3.0, &pile), 0.02);
    measure("hull16-box contact", &set(&small, &cube, 3.0, &pile), 0.02);

    let drum = Shape::Cylinder { half_length: 0.5, radius: 0.5 };
    let egg = Shape::Ellipsoid { half: Vec3::new(0.6, 0.5, 0.4) };
    let die = Shape::RoundedBox { half: Vec3::splat(0.4), radius: 0.1 };
    measure("cylinder-box stacked", &set(&cube, &drum, 1e-3, &stacked), 0.02);
    measure("cylinder-box hovering", &set(&cube, &drum, 1e-3, &hovering), 0.02);
    measure("cylinder-box any contact", &set(&cube, &drum, 1.0, &pile), 0.02);
    measure("cylinder-cylinder apart", &set(&drum, &drum, 1.0, &apart), 0.02);
    measure("cylinder-cylinder contact", &set(&drum, &drum, 1.0, &pile), 0.02);
    measure("cylinder-sphere", &set(&drum, &ball, 1.0, &|r: &mut Random| 1.2 * r.vector()), 0.02);
    measure("ellipsoid-ellipsoid contact", &set(&egg, &egg, 3.0, &|r: &mut Random| r.vector()), 0.02);
    measure(
        "rounded box-rounded box",
        &set(&die, &die, 1.0, &|r: &mut Random| 1.1 * r.vector().normalize()),
        0.02,
    );
}
