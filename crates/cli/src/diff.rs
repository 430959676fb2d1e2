//! `rockfall diff`: where two runs differ first.

use crate::args::DiffArgs;
use crate::exit::Failure;
use crate::{say, units};
use rockfall::math::DVec3;
use rockfall_cache::{Poses, RunReader};

/// Compares the poses of two runs bit by bit, frame after frame.
pub(crate) fn diff(args: &DiffArgs) -> Result<(), Failure> {
    let (first, second) = (RunReader::open(&args.first)?, RunReader::open(&args.second)?);
    let bodies = first.bodies()?;
    if bodies != second.bodies()? {
        return different("they have other bodies");
    }
    let (origins, frames) = ([first.origin()?, second.origin()?], [first.frames()?, second.frames()?]);
    for frame in 0..frames[0].min(frames[1]) {
        let (a, b) = (first.poses(frame)?, second.poses(frame)?);
        let of = |row: usize| (Pose::of(&a, row, origins[0]), Pose::of(&b, row, origins[1]));
        let differ: Vec<usize> = (0..bodies.len()).filter(|&row| !of(row).0.is(&of(row).1)).collect();
        if let Some(&row) = differ.first() {
            let (a, b) = of(row);
            let name = Some(&bodies.names[row]).filter(|name| !name.is_empty());
            let name = name.map_or_else(String::new, |name| format!(" ({name})"));
            return different(&format!(
                "frame {frame}: body {}{name} is the first of {} that differ, {}",
                bodies.ids[row],
                units::count(differ.len() as u64),
                a.way_to(&b),
            ));
        }
    }
    if frames[0] != frames[1] {
        let [a, b] = frames.map(units::count);
        return different(&format!("they are the same as far as they go: {a} and {b} frames"));
    }
    say::out(&format!("{} frames are the same", units::count(frames[0])));
    Ok(())
}

fn different(how: &str) -> Result<(), Failure> {
    say::out(how);
    Err(Failure::Different)
}

/// A body's place in a frame, as it was written.
struct Pose {
    position: [f32; 3],
    rotation: [f32; 4],
    origin: DVec3,
}

impl Pose {
    fn of(poses: &Poses, row: usize, origin: DVec3) -> Self {
        let position = std::array::from_fn(|i| poses.positions.get(3 * row + i).copied().unwrap_or(f32::NAN));
        let rotation =
            std::array::from_fn(|i| poses.orientations.get(4 * row + i).copied().unwrap_or(f32::NAN));
        Pose { position, rotation, origin }
    }

    fn is(&self, other: &Pose) -> bool {
        self.origin == other.origin
            && self.position.map(f32::to_bits) == other.position.map(f32::to_bits)
            && self.rotation.map(f32::to_bits) == other.rotation.map(f32::to_bits)
    }

    /// How far the other one is from here.
    fn way_to(&self, other: &Pose) -> String {
        let [a, b] = [self, other].map(|pose| pose.origin + DVec3::from_array(pose.position.map(f64::from)));
        let way = (b - a).length();
        if !way.is_finite() {
            return "and is there in one of the runs only".into();
        }
        // The angle of a turn is twice that between two unit quaternions; its sine keeps small ones.
        let [p, q] = [self, other].map(|pose| pose.rotation.map(f64::from));
        let same = p.iter().zip(&q).map(|(p, q)| p * q).sum::<f64>() >= 0.0;
        let sign = if same { 1.0 } else { -1.0 };
        let half = 0.5 * p.iter().zip(&q).map(|(p, q)| (p - sign * q).powi(2)).sum::<f64>().sqrt();
        let turn = 4.0 * libm::asin(half.min(1.0));
        format!("by {} and {}", units::si(way, "m"), units::si(turn, "rad"))
    }
}
