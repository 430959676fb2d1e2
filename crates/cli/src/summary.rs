//! The figures of a run: gathered step by step, and shown at its end.

use crate::args::solver_name;
use crate::units;
use rockfall::snapshot::{self, Reader, Writer};
use rockfall::{Invariant, STAGES, StepReport};
use rockfall_cache::{Breach, FORMAT, Final, Status, Summary, VERSION, Whole, checksum};
use rockfall_scene::Scene;
use std::fmt::Write;
use std::path::Path;
use std::time::{Duration, Instant};

/// What is known of a run before its first step.
pub(crate) fn head(path: &Path, scene: &Scene) -> Summary {
    let settings = &scene.settings;
    Summary {
        format: FORMAT.into(),
        format_version: VERSION,
        rockfall: env!("CARGO_PKG_VERSION").into(),
        status: Status::Running,
        scene: path.display().to_string(),
        scene_checksum: checksum(scene.to_toml_filled().as_bytes()),
        seed: scene.seed,
        solver: solver_name(settings.solver).into(),
        substeps: settings.substeps,
        frames_per_second: f64::from(settings.rate),
        threads: settings.threads,
        lanes: settings.lanes,
        bodies: usize::try_from(scene.body_count()).unwrap_or(usize::MAX),
        frames_planned: scene.frames,
        ..Summary::default()
    }
}

/// Gathers the figures of the steps.
#[derive(Debug)]
pub(crate) struct Tally {
    start: Instant,
    load: Duration,
    /// Time of each step, milliseconds.
    steps_ms: Vec<f32>,
    stages: [Duration; STAGES.len()],
    body_steps: u64,
    deepest: f32,
    most_contacts: usize,
    last: StepReport,
    /// Of each of [`Invariant::ALL`] the frames that broke it, the first of them, and the largest error.
    broken: [(u64, u64, f64); 3],
    /// What took time before a run went on: all of it but loading, and waiting for the disk.
    before: [Duration; 2],
}

impl Tally {
    /// Starts the clock; loading took `load`.
    pub(crate) fn new(load: Duration) -> Self {
        Tally {
            start: Instant::now(),
            load,
            steps_ms: Vec::new(),
            stages: [Duration::ZERO; STAGES.len()],
            body_steps: 0,
            deepest: 0.0,
            most_contacts: 0,
            last: StepReport::default(),
            broken: Default::default(),
            before: [Duration::ZERO; 2],
        }
    }

    /// Writes the figures so far; the simulation has waited for the disk for so long.
    pub(crate) fn save(&self, waited: Duration, to: &mut Writer<'_>) -> Result<(), snapshot::Error> {
        #[rustfmt::skip]
        let Tally {
            start, load, steps_ms, stages, body_steps, deepest, most_contacts, last: _, broken, before,
        } = self;
        let times = [*load, before[0] + start.elapsed(), before[1] + waited];
        to.column("tally.times_s", &times.map(|time| time.as_secs_f64()))?;
        to.column("tally.stages_s", &stages.map(|time| time.as_secs_f64()))?;
        to.column("tally.steps_ms", steps_ms)?;
        to.column("tally.counts", &[*body_steps, *most_contacts as u64])?;
        to.column("tally.broken", &broken.map(|(frames, first, _)| [frames, first]).concat())?;
        to.column("tally.worst", &broken.map(|(_, _, worst)| worst))?;
        to.one("tally.deepest_m", *deepest)
    }

    /// Goes on with the figures that [`Tally::save`] wrote; the clock starts now.
    pub(crate) fn load(from: &mut Reader<'_>) -> Result<Self, snapshot::Error> {
        let time = |s: &f64| Duration::try_from_secs_f64(*s).unwrap_or_default();
        let times: Vec<f64> = from.column_of("tally.times_s", 3)?;
        let stages: Vec<f64> = from.column_of("tally.stages_s", STAGES.len())?;
        let steps_ms = from.column("tally.steps_ms")?;
        let counts: Vec<u64> = from.column_of("tally.counts", 2)?;
        let broken: Vec<u64> = from.column_of("tally.broken", 6)?;
        let worst: Vec<f64> = from.column_of("tally.worst", 3)?;
        Ok(Tally {
            broken: std::array::from_fn(|i| (broken[2 * i], broken[2 * i + 1], worst[i])),
            stages: std::array::from_fn(|i| time(&stages[i])),
            steps_ms,
            body_steps: counts[0],
            most_contacts: counts[1] as usize,
            deepest: from.one("tally.deepest_m")?,
            before: [time(&times[1]), time(&times[2])],
            ..Tally::new(time(&times[0]))
        })
    }

    /// The last step was the one that `report` tells of, before the run went on.
    pub(crate) fn resume(&mut self, report: &StepReport) {
        self.last.clone_from(report);
    }

    /// A step is done; it took `time`.
    pub(crate) fn step(&mut self, report: &StepReport, time: Duration) {
        self.steps_ms.push(time.as_secs_f32() * 1e3);
        for (sum, stage) in self.stages.iter_mut().zip(&report.times) {
            *sum += *stage;
        }
        self.body_steps = self.body_steps.saturating_add(report.bodies as u64);
        self.deepest = self.deepest.max(report.deepest_penetration);
        self.most_contacts = self.most_contacts.max(report.contacts);
        for (invariant, (frames, first, worst)) in Invariant::ALL.into_iter().zip(&mut self.broken) {
            *worst = worst.max(report.error_of(invariant));
            if report.breaks(invariant) {
                *frames += 1;
                if *frames == 1 {
                    *first = report.step;
                }
            }
        }
        self.last.clone_from(report);
    }

    /// Puts the figures into `summary`.
    pub(crate) fn fill(&self, summary: &mut Summary, waited: Duration, world_memory: usize) {
        let last = &self.last;
        let step_s = self.steps_ms.iter().map(|&ms| f64::from(ms)).sum::<f64>() / 1e3;
        summary.frames = self.steps_ms.len() as u64;
        summary.simulated_s = last.time;
        summary.last = Final {
            bodies: last.bodies,
            awake: last.awake,
            frozen: last.frozen,
            touching: last.touching,
            contacts: last.contacts,
            deepest_penetration_m: last.deepest_penetration.into(),
            mean_penetration_m: last.mean_penetration.into(),
            kinetic_energy: last.kinetic_energy,
            potential_energy: last.potential_energy,
            momentum_kg_m_s: last.momentum,
            angular_momentum_kg_m2_s: last.angular_momentum,
        };
        let breach = |(invariant, &(frames, first, worst)): (Invariant, &(u64, u64, f64))| {
            (frames > 0).then(|| Breach { invariant: invariant.name().into(), frames, first, worst })
        };
        summary.broken = Invariant::ALL.into_iter().zip(&self.broken).filter_map(breach).collect();
        let mut sorted = self.steps_ms.clone();
        sorted.sort_by(f32::total_cmp);
        summary.whole = Whole {
            deepest_penetration_m: self.deepest.into(),
            most_contacts: self.most_contacts,
            load_s: self.load.as_secs_f64(),
            wall_s: (self.before[0] + self.start.elapsed()).as_secs_f64(),
            step_s,
            wait_for_disk_s: (self.before[1] + waited).as_secs_f64(),
            median_step_ms: sorted.get(sorted.len() / 2).copied().unwrap_or(0.0).into(),
            slowest_step_ms: sorted.last().copied().unwrap_or(0.0).into(),
            body_steps_per_s: if step_s > 0.0 { self.body_steps as f64 / step_s } else { 0.0 },
            stages_s: STAGES.iter().zip(&self.stages).map(|(n, t)| ((*n).into(), t.as_secs_f64())).collect(),
            world_memory_bytes: world_memory as u64,
            peak_memory_bytes: peak_memory(),
        };
    }
}

/// The most memory that this program has had at a time, bytes, where the system says so (Linux).
fn peak_memory() -> Option<u64> {
    peak_of(&std::fs::read_to_string("/proc/self/status").ok()?)
}

fn peak_of(status: &str) -> Option<u64> {
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kibibytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kibibytes.checked_mul(1024)
}

/// The summary for people.
pub(crate) fn table(summary: &Summary) -> String {
    let (mut text, facts) = facts(summary);
    for (name, value) in facts {
        // Writing to a string cannot fail.
        let _ = write!(text, "\n  {name:<20} {value}");
    }
    text
}

/// A sentence about the run, and its figures by name.
pub(crate) fn facts(summary: &Summary) -> (String, Vec<(String, String)>) {
    let (last, whole) = (&summary.last, &summary.whole);
    let seconds = |s: f64| units::time(Duration::try_from_secs_f64(s).unwrap_or_default());
    let count = |n: usize| units::count(n as u64);
    let text = format!(
        "{} {} after {} of {} frames: {} simulated in {} with {} threads, {} lanes",
        summary.scene,
        match summary.status {
            Status::Running => "running",
            Status::Finished => "finished",
            Status::Interrupted => "interrupted",
            Status::Failed => "failed",
        },
        units::count(summary.frames),
        units::count(summary.frames_planned),
        seconds(summary.simulated_s),
        seconds(whole.wall_s),
        summary.threads,
        summary.lanes,
    );
    let mut facts = Vec::new();
    let mut line = |name: &str, value: String| facts.push((name.to_owned(), value));
    line("bodies", format!("{}, {} awake", count(last.bodies), count(last.awake)));
    if last.frozen > 0 {
        line("frozen", format!("{}, their state was not finite", count(last.frozen)));
    }
    for Breach { invariant, frames, first, worst } in &summary.broken {
        let count = units::count(*frames);
        line(
            &format!("{invariant} broken"),
            format!("in {count} frames from {first} on, at most {worst:.3e}"),
        );
    }
    line("contacts", format!("{}, at most {}", count(last.contacts), count(whole.most_contacts)));
    line(
        "deepest penetration",
        format!(
            "{}, at most {}",
            units::si(last.deepest_penetration_m, "m"),
            units::si(whole.deepest_penetration_m, "m")
        ),
    );
    line("mean penetration", units::si(last.mean_penetration_m, "m"));
    line("kinetic energy", units::si(last.kinetic_energy, "J"));
    line("step", format!("{:.2} ms median, {:.2} ms slowest", whole.median_step_ms, whole.slowest_step_ms));
    line("throughput", units::si(whole.body_steps_per_s, "body·steps/s"));
    line("waited for disk", seconds(whole.wait_for_disk_s));
    let peak = whole.peak_memory_bytes.map_or_else(|| "unknown".into(), units::bytes);
    line("peak memory", format!("{peak}, world {}", units::bytes(whole.world_memory_bytes)));
    let total: f64 = whole.stages_s.values().sum();
    for stage in STAGES {
        let time = whole.stages_s.get(stage).copied().unwrap_or(0.0);
        let share = if total > 0.0 { 100.0 * time / total } else { 0.0 };
        let mean = 1e3 * time / summary.frames.max(1) as f64;
        line(&format!("stage {stage}"), format!("{mean:>10.3} ms/step {share:5.1} %"));
    }
    line("hash", summary.hash.clone());
    (text, facts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_those_of_the_steps() {
        let mut tally = Tally::new(Duration::from_secs(2));
        for (contacts, deepest, ms) in [(10, 0.5, 4), (30, 0.25, 1), (20, 0.125, 7)] {
            let mut report =
                StepReport { bodies: 100, contacts, deepest_penetration: deepest, ..StepReport::default() };
            report.times[4] = Duration::from_millis(ms);
            tally.step(&report, Duration::from_millis(ms));
        }
        let mut summary = Summary::default();
        tally.fill(&mut summary, Duration::from_millis(250), 1000);
        assert_eq!((summary.frames, summary.last.contacts), (3, 20));
        assert_eq!(summary.last.deepest_penetration_m, 0.125);
        let whole = &summary.whole;
        assert_eq!((whole.most_contacts, whole.deepest_penetration_m), (30, 0.5));
        assert_eq!((whole.median_step_ms, whole.slowest_step_ms), (4.0, 7.0));
        assert!((whole.step_s - 0.012).abs() < 1e-9);
        assert!((whole.body_steps_per_s - 300.0 / 0.012).abs() < 1e-3);
        assert_eq!((whole.load_s, whole.wait_for_disk_s), (2.0, 0.25));
        assert!((whole.stages_s["touch"] - 0.012).abs() < 1e-12);
        assert_eq!(whole.stages_s.len(), STAGES.len());
        let table = table(&summary);
        assert!(table.contains("stage touch"), "{table}");
        assert!(table.contains("500.0 mm"), "{table}");
    }

    #[test]
    fn the_peak_is_read_from_what_linux_says() {
        assert_eq!(peak_of("VmPeak:\t 9 kB\nVmHWM:\t   2048 kB\n"), Some(2 << 20));
        assert_eq!(peak_of("VmPeak:\t 9 kB\n"), None);
        assert_eq!(peak_of("VmHWM:\t many\n"), None);
    }
}
