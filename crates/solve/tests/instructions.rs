//! Figures that don't wobble: instructions per contact of the kernels that a step consists of, counted by callgrind.
//!
//! The test runs this very file once more, under valgrind, and reads what each of the functions below has cost with everything that it calls. Valgrind knows
//! AVX2 but not AVX-512, so 4 lanes (SSE2, on every x86) and 8 (AVX2) are counted.

// Compiled for the release profile alone: every kernel in every width once more takes a hundred seconds, and the development profile counts what nobody ships.
#![cfg(all(target_os = "linux", target_arch = "x86_64", not(debug_assertions)))]

use rockfall_math::lanes::Width;
use rockfall_math::{Mat3, Quat, Vec3};
use rockfall_solve::advance::Stay;
use rockfall_solve::follow::follow;
use rockfall_solve::iterate::{relax, solve};
use rockfall_solve::line::Role;
use rockfall_solve::warm::warm;
use rockfall_solve::{Columns, Contacts, Drift, Found, Line, Manifold, Memory, Softness, SubStep, Surface};
use std::collections::HashMap;
use std::process::Command;

/// Contacts of a kind, each between two bodies of its own: all of one colour, in full blocks.
const CONTACTS: usize = 2048;

/// Sweeps that are counted of each kernel.
const SWEEPS: usize = 4;

/// A kernel, lanes, and instructions per contact and sweep as they were counted with Rust 1.95.
const COUNTED: [(&str, usize, f64); 16] = [
    ("warm_balls", 4, 148.3),
    ("solve_balls", 4, 199.2),
    ("relax_balls", 4, 190.4),
    ("follow_balls", 4, 101.4),
    ("warm_boxes", 4, 554.2),
    ("solve_boxes", 4, 505.8),
    ("relax_boxes", 4, 476.4),
    ("follow_boxes", 4, 221.2),
    ("warm_balls", 8, 108.6),
    ("solve_balls", 8, 136.3),
    ("relax_balls", 8, 133.4),
    ("follow_balls", 8, 59.7),
    ("warm_boxes", 8, 347.4),
    ("solve_boxes", 8, 269.9),
    ("relax_boxes", 8, 265.1),
    ("follow_boxes", 8, 117.0),
];

/// What a compiler or a small change may add.
const ROOM: f64 = 1.1;

/// Promise: no kernel takes more than a tenth more instructions per contact than was counted. One that takes less than half should get a
/// new figure here.
///
/// Without valgrind the test passes, and says so; not where `CI` is set.
#[test]
fn instructions_per_contact() {
    if Command::new("valgrind").arg("--version").output().is_err() {
        assert!(std::env::var_os("CI").is_none(), "no valgrind: install it, for this test counts by it");
        println!("not counted: there is no valgrind here");
        return;
    }
    let mut over = Vec::new();
    for lanes in [4, 8] {
        let Some(costs) = count(lanes) else {
            println!("not counted with {lanes} lanes: the machine has no AVX2");
            continue;
        };
        for &(name, _, counted) in COUNTED.iter().filter(|(_, width, _)| *width == lanes) {
            let now = costs.get(name).copied().unwrap_or(0) as f64 / (CONTACTS * SWEEPS) as f64;
            println!("{name:12} {lanes} lanes {now:7.1} instructions a contact, {counted:.1} expected");
            if !(0.5 * counted..=ROOM * counted).contains(&now) {
                over.push(format!("{name} with {lanes} lanes: {now:.1}, not {counted:.1}"));
            }
        }
    }
    assert!(over.is_empty(), "instructions per contact: {}", over.join("; "));
}

/// Runs `under_callgrind` with so many lanes; instructions by the names of functions.
fn count(lanes: usize) -> Option<HashMap<String, u64>> {
    let file = std::env::temp_dir().join(format!("rockfall-instructions-{}-{lanes}", std::process::id()));
    let run = Command::new("valgrind")
        .args(["--tool=callgrind", "--compress-strings=no", "--compress-pos=no"])
        .arg(format!("--callgrind-out-file={}", file.display()))
        .arg(std::env::current_exe().expect("a test has a file"))
        .args(["--ignored", "--exact", "under_callgrind", "--nocapture"])
        .env("ROCKFALL_COUNT_LANES", lanes.to_string())
        .output()
        .expect("valgrind runs");
    let said = String::from_utf8_lossy(&run.stdout);
    assert!(run.status.success(), "{said}{}", String::from_utf8_lossy(&run.stderr));
    let text = std::fs::read_to_string(&file).expect("callgrind has written its file");
    std::fs::remove_file(&file).expect("its file can be removed");
    said.contains("counted").then(|| inclusive(&text))
}

/// What each function has cost with all that it called, from callgrind's file: after `cfn=` (who is called) and `calls=` comes a line that
/// ends with that cost.
fn inclusive(text: &str) -> HashMap<String, u64> {
    let mut costs = HashMap::new();
    let mut called = "";
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        if let Some(name) = line.strip_prefix("cfn=") {
            // Rust's names end with a hash: `instructions::warm_balls::h0123456789abcdef` or, of its newer mangling, with none.
            let parts = name.split("::").map(|part| part.split(['\'', ' ']).next().unwrap_or(part));
            called = parts.filter(|part| !is_hash(part)).last().unwrap_or(name);
        } else if line.starts_with("calls=") {
            let cost = lines.next().and_then(|costs| costs.split(' ').next_back()?.parse().ok());
            *costs.entry(called.to_owned()).or_default() += cost.unwrap_or(0_u64);
        }
    }
    costs
}

fn is_hash(part: &str) -> bool {
    part.len() == 17 && part.starts_with('h') && part[1..].bytes().all(|byte| byte.is_ascii_hexdigit())
}

/// What is counted.
#[test]
#[ignore = "is run by `instructions_per_contact`"]
fn under_callgrind() {
    let lanes = std::env::var("ROCKFALL_COUNT_LANES").ok().and_then(|lanes| lanes.parse().ok()).unwrap_or(4);
    if lanes > 4 && !std::arch::is_x86_feature_detected!("avx2") {
        return;
    }
    println!("counted");
    let width = Width::new(lanes);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool");
    pool.install(|| {
        let (mut balls, mut boxes) = (Scene::new(true), Scene::new(false));
        for _ in 0..SWEEPS {
            follow_balls(&mut balls, width);
            follow_boxes(&mut boxes, width);
            warm_balls(&mut balls, width);
            warm_boxes(&mut boxes, width);
            solve_balls(&mut balls, width);
            solve_boxes(&mut boxes, width);
            relax_balls(&mut balls, width);
            relax_boxes(&mut boxes, width);
        }
        // Something came of it.
        for scene in [&balls, &boxes] {
            assert!(scene.lines.iter().skip(1).all(|line| line.velocity().is_finite()));
            assert!(scene.lines.iter().skip(1).any(|line| line.velocity() != Scene::START));
        }
    });
}

/// A function of its own for each figure, so that callgrind knows it by its name.
macro_rules! kernels {
    ($($name:ident: $what:expr;)*) => {
        $(
            #[inline(never)]
            fn $name(scene: &mut Scene, width: Width) {
                // Functions with the same instructions would be made one.
                std::hint::black_box(stringify!($name));
                let run: fn(&mut Contacts, &mut Columns<'_>, Width) = $what;
                scene.run(|contacts, columns| run(contacts, columns, width));
            }
        )*
    };
}

kernels! {
    warm_balls: |contacts, columns, width| warm(contacts, columns, width, &Stay);
    warm_boxes: |contacts, columns, width| warm(contacts, columns, width, &Stay);
    solve_balls: |contacts, columns, width| solve(contacts, columns, width, &Stay, &step());
    solve_boxes: |contacts, columns, width| solve(contacts, columns, width, &Stay, &step());
    relax_balls: |contacts, columns, width| relax(contacts, columns, width, &Stay, &step());
    relax_boxes: |contacts, columns, width| relax(contacts, columns, width, &Stay, &step());
    follow_balls: follow;
    follow_boxes: follow;
}

fn step() -> SubStep {
    let h = 1.0 / 240.0;
    let (two_sided, one_sided) = (Softness::new(60.0, 0.5, h), Softness::new(120.0, 0.5, h));
    SubStep { h, push_speed: 3.0, two_sided, one_sided }
}

/// Bodies in pairs, one upon the other, each pair with one contact: of two balls, or of the four corners of two boxes' faces.
struct Scene {
    contacts: Contacts,
    lines: Vec<Line>,
    drifts: Vec<Drift>,
    references: Vec<[f32; 8]>,
    rotations: Vec<Quat>,
    starts: Vec<Quat>,
    frames: Vec<Quat>,
    inverse_moments: Vec<Vec3>,
    dampings: Vec<[f32; 2]>,
    roles: Vec<Role>,
    locks: Vec<u8>,
}

impl Scene {
    /// Velocity of all bodies at first, m/s: the lower ones come against the upper ones.
    const START: Vec3 = Vec3::new(0.01, 0.02, -0.04);

    fn new(balls: bool) -> Self {
        let rows = 1 + 2 * CONTACTS;
        let mut lines = vec![Line::default(); rows];
        let mut drifts = vec![Drift::default(); rows];
        for (row, (line, drift)) in lines.iter_mut().zip(&mut drifts).enumerate().skip(1) {
            line.motion[6] = 1.0;
            line.set_inverse_inertia(&Mat3::from_diagonal(Vec3::splat(6.0)));
            let spin = Vec3::new(0.02, -0.01, 0.01) * if row % 2 == 0 { 1.0 } else { -1.0 };
            line.set_velocities(Self::START, spin);
            drift.set(Self::START / 60.0, spin / 60.0);
        }
        let corner = |x: f32, y: f32| Vec3::new(0.5 * x, 0.5 * y, 0.499);
        let arms = match balls {
            true => [Vec3::new(0.0, 0.0, 0.499), Vec3::ZERO, Vec3::ZERO, Vec3::ZERO],
            false => [corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)],
        };
        let count = if balls { 1 } else { 4 };
        let surface = Surface { friction: 0.5, ..Surface::default() };
        let found = |pair: usize| Found {
            manifold: Manifold {
                a: 1 + 2 * pair as u32,
                b: 2 + 2 * pair as u32,
                count,
                normal: Vec3::Z,
                arms,
                distances: [-0.002; 4],
            },
            memory: Memory { normals: [0.01; 4], ..Memory::default() },
            surface,
            offset: Vec3::new(0.0, 0.0, 0.998),
            active: true,
            balls,
            ..Found::default()
        };
        let mut arrivals = vec![(0..CONTACTS).map(found).collect::<Vec<Found>>()];
        let mut contacts = Contacts::default();
        contacts.paint(&mut arrivals, rows);
        contacts.place(&mut arrivals);
        contacts.prepare(&lines);
        assert_eq!(contacts.tally().manifolds, CONTACTS);
        assert_eq!(contacts.colors(), 1, "pairs that share no body share a colour");
        Scene {
            contacts,
            lines,
            drifts,
            references: vec![[0.0; 8]; rows],
            rotations: vec![Quat::IDENTITY; rows],
            starts: vec![Quat::IDENTITY; rows],
            frames: vec![Quat::IDENTITY; rows],
            inverse_moments: vec![Vec3::splat(6.0); rows],
            dampings: vec![[0.0; 2]; rows],
            roles: vec![Role::Free; rows],
            locks: vec![0; rows],
        }
    }

    #[inline(always)]
    fn run(&mut self, kernel: impl FnOnce(&mut Contacts, &mut Columns<'_>)) {
        let mut columns = Columns {
            lines: &mut self.lines,
            drifts: &mut self.drifts,
            references: &mut self.references,
            rotations: &mut self.rotations,
            starts: &self.starts,
            frames: &self.frames,
            inverse_moments: &self.inverse_moments,
            dampings: &self.dampings,
            roles: &self.roles,
            locks: &self.locks,
        };
        kernel(&mut self.contacts, &mut columns);
    }
}
