//! The command line.

use crate::{Error, engine, scene};
use clap::Args;
use std::path::PathBuf;

/// What to measure.
#[derive(Clone, Debug, Args)]
pub struct Options {
    /// Scenes, separated by commas.
    #[arg(long, value_enum, value_delimiter = ',', default_values = ["box-pile", "ball-pit"])]
    pub(crate) scene: Vec<scene::Kind>,

    /// Dynamic bodies, numbers separated by commas; as many as are usual for each scene where nothing is said.
    #[arg(long, value_delimiter = ',', value_parser = parse_bodies)]
    pub(crate) bodies: Vec<usize>,

    /// Steps of 1/60 s, the timed ones included; as many as are usual for each scene where nothing is said.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) steps: Option<u32>,

    /// Steps at the end that are timed.
    #[arg(long, default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) timed: u32,

    /// Steps that an engine does before it is the other's turn.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) turn: u32,

    /// Threads of each engine, numbers separated by commas.
    #[arg(long, value_delimiter = ',', default_values_t = [2], value_parser = parse_threads)]
    pub(crate) threads: Vec<usize>,

    /// Engines, separated by commas; times are compared with the first one's.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = engine::Kind::usual())]
    pub(crate) engines: Vec<engine::Kind>,

    /// Runs of each scene; figures are medians over all.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) repeats: u32,

    /// Seed of the scenes.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,

    /// Writes `bench.md`, `bench.html`, `bench.csv` and `bench.json` into this folder.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,

    /// Serves one engine on standard input and output.
    #[arg(long, value_enum, hide = true)]
    pub(crate) child: Option<engine::Kind>,
}

fn parse_bodies(text: &str) -> Result<usize, String> {
    in_range(text, 10_000_000)
}

fn parse_threads(text: &str) -> Result<usize, String> {
    in_range(text, 1024)
}

fn in_range(text: &str, most: usize) -> Result<usize, String> {
    match text.replace('_', "").parse() {
        Ok(n) if (1..=most).contains(&n) => Ok(n),
        _ => Err(format!("expected a number from 1 to {most}")),
    }
}

impl Options {
    /// All that is to be run, scene by scene.
    pub(crate) fn cases(&self) -> Vec<Case> {
        let mut cases = Vec::new();
        for &scene in &self.scene {
            let usual = [scene.usual().0];
            let bodies: &[usize] = if self.bodies.is_empty() { &usual } else { &self.bodies };
            for &bodies in bodies {
                cases.extend(self.threads.iter().map(|&threads| Case { scene, bodies, threads }));
            }
        }
        cases
    }

    /// The case of a child, which has one.
    pub(crate) fn only_case(&self) -> Result<Case, Error> {
        match self.cases().as_slice() {
            [case] => Ok(*case),
            cases => Err(Error::Cases(cases.len())),
        }
    }

    /// What a child needs to know.
    pub(crate) fn of_child(&self, kind: engine::Kind, case: Case) -> [String; 5] {
        [
            format!("--child={}", kind.name()),
            format!("--scene={}", case.scene.name()),
            format!("--bodies={}", case.bodies),
            format!("--threads={}", case.threads),
            format!("--seed={}", self.seed),
        ]
    }

    /// The turns of a run of a scene: so many steps each, the last of them timed.
    pub(crate) fn turns(&self, scene: scene::Kind) -> Vec<Turn> {
        let all = self.steps.unwrap_or(scene.usual().1);
        let timed = self.timed.min(all);
        let cut = |steps: u32, timed: bool| {
            let whole = std::iter::repeat_n(self.turn, (steps / self.turn) as usize);
            whole.chain([steps % self.turn]).filter(|&n| n > 0).map(move |steps| Turn { steps, timed })
        };
        cut(all - timed, false).chain(cut(timed, true)).collect()
    }
}

/// What all engines get.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Case {
    pub(crate) scene: scene::Kind,
    /// As asked for; scenes say what they make of it.
    pub(crate) bodies: usize,
    /// Of each engine.
    pub(crate) threads: usize,
}

/// What an engine does before it is another's turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Turn {
    pub(crate) steps: u32,
    pub(crate) timed: bool,
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Debug, Parser)]
    struct Cli {
        #[command(flatten)]
        options: Options,
    }

    pub(crate) fn parse(arguments: &[&str]) -> Result<Options, String> {
        let all = ["rockfall-bench"].iter().chain(arguments);
        Cli::try_parse_from(all).map(|cli| cli.options).map_err(|e| e.to_string())
    }

    #[test]
    fn turns_add_up_to_the_steps_and_the_timed_ones_are_last() {
        for (steps, timed, turn) in [(600, 60, 10), (67, 60, 25), (5, 60, 10), (1, 1, 1)] {
            let options = Options { steps: Some(steps), timed, turn, ..parse(&[]).expect("defaults") };
            let turns = options.turns(scene::Kind::BoxPile);
            assert_eq!(turns.iter().map(|t| t.steps).sum::<u32>(), steps);
            let of_timed = |turns: &[Turn]| turns.iter().filter(|t| t.timed).map(|t| t.steps).sum::<u32>();
            assert_eq!(of_timed(&turns), timed.min(steps));
            assert!(turns.is_sorted_by_key(|t| t.timed) && turns.iter().all(|t| t.steps <= turn));
        }
    }

    #[test]
    fn a_child_understands_what_it_is_told() {
        let parent = parse(&["--scene=pyramid", "--bodies=55", "--threads=3", "--seed=9"]).expect("options");
        let case = Case { scene: scene::Kind::Pyramid, bodies: 55, threads: 3 };
        assert_eq!(parent.cases(), [case]);
        let arguments = parent.of_child(engine::Kind::Rapier, case);
        let child = parse(&arguments.each_ref().map(String::as_str)).expect("options");
        assert_eq!((child.child, child.seed), (Some(engine::Kind::Rapier), 9));
        assert!(child.only_case().is_ok_and(|only| only == case));
    }

    #[test]
    fn every_scene_meets_every_number_of_bodies_and_threads() {
        let options =
            parse(&["--scene=pyramid,box-pile", "--bodies=55,210,465", "--threads=1,2"]).expect("options");
        let cases = options.cases();
        assert_eq!(cases.len(), 12);
        assert_eq!(cases[3], Case { scene: scene::Kind::Pyramid, bodies: 210, threads: 2 });
        assert!(matches!(options.only_case(), Err(Error::Cases(12))));
    }

    #[test]
    fn scenes_have_their_own_bodies_and_steps_unless_told() {
        let washer = scene::Kind::Box3dWasher;
        let of = |arguments: &[&str]| {
            let options = parse(&[&["--scene=box3d-washer"], arguments].concat()).expect("options");
            (options.cases()[0].bodies, options.turns(washer).iter().map(|t| t.steps).sum::<u32>())
        };
        assert_eq!(of(&[]), (8000, 1000));
        assert_eq!(of(&["--bodies=50", "--steps=70"]), (50, 70));
    }

    #[test]
    fn without_a_word_all_engines_are_built() {
        let engines = parse(&[]).expect("defaults").engines;
        assert!(engines[0] == engine::Kind::Rockfall && engines.iter().all(|kind| kind.is_built()));
    }

    #[test]
    fn numbers_out_of_range_are_refused() {
        for bad in ["--bodies=0", "--bodies=-1", "--threads=0", "--steps=0", "--repeats=0", "--turn=0"] {
            assert!(parse(&[bad]).is_err(), "{bad}");
        }
        assert_eq!(parse(&["--bodies=10_000"]).expect("options").bodies, [10_000]);
        assert!(parse(&["--bodies=10000001"]).expect_err("too many").contains("from 1 to 10000000"));
    }
}
