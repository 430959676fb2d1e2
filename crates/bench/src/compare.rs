//! Runs engines turn by turn, and takes medians.

use crate::bandwidth::Bandwidth;
use crate::child::{Block, Child, Outcome};
use crate::options::{Case, Options};
use crate::roofline::Roofline;
use crate::{Error, engine};
use serde::Serialize;

/// One engine on one scene: a line of the table.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct Line {
    pub(crate) scene: &'static str,
    pub(crate) bodies: usize,
    /// Of a run, the timed ones included.
    pub(crate) steps: u32,
    pub(crate) threads: usize,
    pub(crate) engine: &'static str,
    pub(crate) version: String,
    /// Median over all timed turns of all runs.
    pub(crate) ms_per_step: f64,
    /// Mean over all steps of a run, from the first fall to the end; the median over all runs.
    pub(crate) all_ms_per_step: f64,
    /// Of the fastest timed turn.
    pub(crate) best_ms_per_step: f64,
    /// The very first step of the engine: indexing, first pairs and contacts are in it, loading is not; the median over all runs.
    pub(crate) first_step_ms: f64,
    /// The same as a multiple of `ms_per_step`.
    pub(crate) first_step_times: f64,
    /// What more threads are worth: time of the same with one thread, where that ran too, as a multiple of `ms_per_step`.
    pub(crate) threads_worth: Option<f64>,
    /// Time as a multiple of the first engine's: the median over turns that were next to each other.
    pub(crate) times_first: f64,
    /// On the processors, all threads together; the median over all timed turns.
    pub(crate) cpu_ms_per_step: Option<f64>,
    /// The same as a multiple of the first engine's.
    pub(crate) cpu_times_first: Option<f64>,
    /// Of all dynamic bodies, kg.
    pub(crate) mass_kg: f64,
    /// Pairs that overlap at the end.
    pub(crate) overlapping_pairs: usize,
    pub(crate) penetration_mean_mm: f64,
    pub(crate) penetration_p99_mm: f64,
    pub(crate) penetration_max_mm: f64,
    pub(crate) escaped: usize,
    pub(crate) kinetic_joule: f64,
    pub(crate) rms_speed_mm_per_s: f64,
    /// Bodies faster than 50 mm/s.
    pub(crate) moving: usize,
    pub(crate) top_drop_mm: Option<f64>,
    pub(crate) top_drift_mm: Option<f64>,
    /// Peak memory of the engine by the number of bodies, those that can't be moved included.
    pub(crate) bytes_per_body: Option<f64>,
    /// The same of the timed turns alone.
    pub(crate) timed_bytes_per_body: Option<f64>,
    /// What the solver reads, where the engine tells.
    pub(crate) roofline: Option<Roofline>,
    /// Times of the stages, milliseconds per step, medians.
    pub(crate) stages: Vec<(String, f64)>,
}

/// All that one engine gave in all runs.
struct Runs {
    kind: engine::Kind,
    /// Timed turns.
    blocks: Vec<Block>,
    /// Mean time of all steps of each run, milliseconds.
    all: Vec<f64>,
    /// Time of the first step of each run, milliseconds.
    first: Vec<f64>,
    outcomes: Vec<Outcome>,
}

/// One scene in all engines. `say` hears how far it is.
pub(crate) fn compare(
    options: &Options,
    verb: Option<&str>,
    roofs: &[Bandwidth],
    case: Case,
    mut say: impl FnMut(&str),
) -> Result<Vec<Line>, Error> {
    let Case { scene, bodies, threads } = case;
    let none =
        |&kind| Runs { kind, blocks: Vec::new(), all: Vec::new(), first: Vec::new(), outcomes: Vec::new() };
    let mut runs: Vec<Runs> = options.engines.iter().map(none).collect();
    for repeat in 1..=options.repeats {
        let children = options.engines.iter().map(|&kind| Child::start(options, verb, kind, case));
        let mut children = children.collect::<Result<Vec<_>, _>>()?;
        let mut sums = vec![0.0; children.len()];
        let mut done = 0;
        for (number, turn) in options.turns(scene).into_iter().enumerate() {
            let mut order: Vec<usize> = (0..children.len()).collect();
            // Whoever goes first meets colder caches or a busier neighbour: they take turns at that, too.
            order.rotate_left((number + repeat as usize) % children.len().max(1));
            let mut last = String::new();
            for i in order {
                let block = children[i].step(turn.steps)?;
                last += &format!("  {} {:.1} ms", runs[i].kind.name(), block.wall);
                runs[i].first.extend(block.first);
                sums[i] += f64::from(turn.steps) * block.wall;
                if turn.timed {
                    runs[i].blocks.push(block);
                }
            }
            done += turn.steps;
            let of = format!("{}, {bodies} bodies, {threads} threads", scene.name());
            say(&format!("{of}: run {repeat}/{} step {done}{last}", options.repeats));
        }
        for ((run, child), sum) in runs.iter_mut().zip(children).zip(sums) {
            run.all.push(sum / f64::from(done));
            run.outcomes.push(child.finish()?);
        }
    }
    let Some(first) = runs.first() else { return Ok(Vec::new()) };
    let roof = roofs.iter().find(|roof| roof.threads == threads);
    let bandwidth = roof.map_or(f64::NAN, |roof| roof.gigabytes_per_second);
    runs.iter().map(|run| line(options, case, run, first, bandwidth)).collect()
}

fn line(options: &Options, case: Case, run: &Runs, first: &Runs, bandwidth: f64) -> Result<Line, Error> {
    let outcomes = &run.outcomes;
    let Some(any) = outcomes.first() else {
        return Err(Error::Engine { engine: run.kind.name(), reason: "it has no result".to_owned() });
    };
    let walls = || run.blocks.iter().map(|b| b.wall);
    let pairs = || run.blocks.iter().zip(&first.blocks);
    let of = |read: &dyn Fn(&Outcome) -> f64| median(outcomes.iter().map(read));
    let per_body = |bytes: u64| bytes as f64 / (any.bodies + any.immovable).max(1) as f64;
    let stage = |i: usize, name: &str| {
        (name.to_owned(), median(run.blocks.iter().filter_map(|b| b.stages.get(i)).map(|s| s.1)))
    };
    let cpu: Option<Vec<f64>> = run.blocks.iter().map(|b| b.cpu).collect();
    let cpu_ratio: Option<Vec<f64>> = pairs().map(|(b, f)| Some(b.cpu? / f.cpu?)).collect();
    let (ms_per_step, first_step_ms) = (median(walls()), median(run.first.iter().copied()));
    Ok(Line {
        scene: case.scene.name(),
        bodies: any.bodies,
        steps: options.turns(case.scene).iter().map(|turn| turn.steps).sum(),
        threads: case.threads,
        engine: run.kind.name(),
        version: run.kind.version(),
        ms_per_step,
        all_ms_per_step: median(run.all.iter().copied()),
        best_ms_per_step: walls().fold(f64::INFINITY, f64::min),
        first_step_ms,
        first_step_times: first_step_ms / ms_per_step,
        threads_worth: None,
        times_first: median(pairs().map(|(b, f)| b.wall / f.wall)),
        cpu_ms_per_step: cpu.map(median),
        cpu_times_first: cpu_ratio.map(median),
        mass_kg: any.mass,
        overlapping_pairs: of(&|o| o.quality.overlapping as f64) as usize,
        penetration_mean_mm: of(&|o| o.quality.mean_mm),
        penetration_p99_mm: of(&|o| o.quality.p99_mm),
        penetration_max_mm: of(&|o| o.quality.deepest_mm),
        escaped: outcomes.iter().map(|o| o.quality.escaped).max().unwrap_or(0),
        kinetic_joule: of(&|o| o.quality.kinetic),
        rms_speed_mm_per_s: of(&|o| 1e3 * o.quality.rms_speed),
        moving: of(&|o| o.quality.moving as f64) as usize,
        top_drop_mm: any.quality.top_drop_mm.map(|_| of(&|o| o.quality.top_drop_mm.unwrap_or(0.0))),
        top_drift_mm: any.quality.top_drift_mm.map(|_| of(&|o| o.quality.top_drift_mm.unwrap_or(0.0))),
        bytes_per_body: any.memory.map(|_| of(&|o| per_body(o.memory.unwrap_or(0)))),
        timed_bytes_per_body: run.blocks.iter().filter_map(|b| b.memory).max().map(per_body),
        roofline: Roofline::new(&run.blocks, bandwidth),
        stages: run.blocks.first().map_or(Vec::new(), |b| {
            b.stages.iter().enumerate().map(|(i, (name, _))| stage(i, name)).collect()
        }),
    })
}

/// Fills in what more threads are worth, where the same ran with one.
pub(crate) fn beside_one_thread(lines: &mut [Line]) {
    fn of(line: &Line) -> (&str, usize, &str) {
        (line.scene, line.bodies, line.engine)
    }
    let ones: Vec<Line> = lines.iter().filter(|line| line.threads == 1).cloned().collect();
    for line in lines.iter_mut().filter(|line| line.threads > 1) {
        let one = ones.iter().find(|one| of(one) == of(line));
        line.threads_worth = one.map(|one| one.ms_per_step / line.ms_per_step);
    }
}

/// The middle one, or the mean of the two in the middle; NaN of nothing.
pub(crate) fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = values.into_iter().collect();
    sorted.sort_unstable_by(f64::total_cmp);
    match sorted.len() {
        0 => f64::NAN,
        n => 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::tests::parse;
    use crate::quality::Quality;

    #[test]
    fn medians_are_in_the_middle() {
        assert_eq!(median([3.0, 1.0, 100.0]), 3.0);
        assert_eq!(median([4.0, 1.0, 2.0, 100.0]), 3.0);
        assert!(median([]).is_nan());
    }

    #[test]
    fn threads_are_held_against_one_of_the_same() {
        let mut lines = ["a", "a", "b"].map(crate::table::tests::sample);
        (lines[0].threads, lines[0].ms_per_step) = (1, 18.51);
        beside_one_thread(&mut lines);
        let worth = lines[1].threads_worth.expect("one thread ran");
        assert!((worth - 1.5).abs() < 1e-12, "{worth}");
        assert_eq!((lines[0].threads_worth, lines[2].threads_worth), (None, None));
    }

    #[test]
    fn ratios_are_of_turns_that_were_neighbours() {
        let runs = |kind, walls: &[f64]| Runs {
            kind,
            blocks: walls
                .iter()
                .map(|&wall| Block {
                    wall,
                    cpu: Some(2.0 * wall),
                    stages: vec![("solve".to_owned(), 0.5 * wall)],
                    first: None,
                    solver_bytes: Some(1e6 * wall),
                    memory: Some(100 * wall as u64),
                })
                .collect(),
            all: vec![2.0, 5.0, 100.0],
            first: vec![90.0, 50.0, 45.0],
            outcomes: vec![Outcome {
                bodies: 6,
                immovable: 4,
                mass: 1.0,
                memory: Some(5000),
                quality: Quality::default(),
            }],
        };
        // A neighbour on the machine doubles the times of both in the last two turns: the ratio does not see it.
        let ours = runs(engine::Kind::Rockfall, &[10.0, 10.0, 20.0, 20.0]);
        let peer = runs(engine::Kind::Rapier, &[15.0, 15.0, 30.0, 30.0]);
        let options = parse(&[]).expect("options");
        let line = line(&options, options.cases()[0], &peer, &ours, 8.0).expect("a line");
        assert_eq!((line.times_first, line.cpu_times_first), (1.5, Some(1.5)));
        assert_eq!((line.ms_per_step, line.best_ms_per_step, line.all_ms_per_step), (22.5, 15.0, 5.0));
        assert_eq!((line.bytes_per_body, line.timed_bytes_per_body), (Some(500.0), Some(300.0)));
        assert!(line.first_step_ms == 50.0 && (line.first_step_times - 50.0 / 22.5).abs() < 1e-12);
        // A million bytes in half a millisecond.
        let roofline = line.roofline.expect("told");
        assert!((roofline.gigabytes_per_second - 2.0).abs() < 1e-9);
        assert!((roofline.of_bandwidth - 0.25).abs() < 1e-9);
    }
}
