//! The command line.

use crate::{Error, engine, scene};
use clap::Parser;
use std::path::PathBuf;

/// Runs the same scene in several engines, turn by turn, and compares time, memory and quality.
#[derive(Clone, Debug, Parser)]
#[command(name = "rockfall-bench", version)]
pub(crate) struct Options {
    /// Scenes, separated by commas.
    #[arg(long, value_enum, value_delimiter = ',', default_values = ["box-pile", "ball-pit"])]
    pub(crate) scene: Vec<scene::Kind>,

    /// Dynamic bodies; as many as are usual for each scene where nothing is said.
    #[arg(long, value_parser = parse_bodies)]
    pub(crate) bodies: Option<usize>,

    /// Steps of 1/60 s, the timed ones included; as many as are usual for each scene where nothing is said.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) steps: Option<u32>,

    /// Steps at the end that are timed.
    #[arg(long, default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) timed: u32,

    /// Steps that an engine does before it is the other's turn.
    #[arg(long, default_value_t = 10, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) turn: u32,

    /// Threads of each engine.
    #[arg(long, default_value_t = 2, value_parser = parse_threads)]
    pub(crate) threads: usize,

    /// Engines, separated by commas; times are compared with the first one's.
    #[arg(long, value_enum, value_delimiter = ',', default_values = ["rockfall", "rapier"])]
    pub(crate) engines: Vec<engine::Kind>,

    /// Runs of each scene; figures are medians over all.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) repeats: u32,

    /// Seed of the scenes.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,

    /// Writes `bench.md`, `bench.csv` and `bench.json` into this folder.
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
    /// The scene of a child, which has one.
    pub(crate) fn only_scene(&self) -> Result<scene::Kind, Error> {
        match self.scene.as_slice() {
            [scene] => Ok(*scene),
            _ => Err(Error::Scenes(self.scene.len())),
        }
    }

    /// Dynamic bodies to ask a scene for.
    pub(crate) fn bodies_of(&self, scene: scene::Kind) -> usize {
        self.bodies.unwrap_or(scene.usual().0)
    }

    /// These options for one scene.
    pub(crate) fn with_scene(&self, scene: scene::Kind) -> Options {
        Options { scene: vec![scene], ..self.clone() }
    }

    /// What a child needs to know.
    pub(crate) fn of_child(&self, kind: engine::Kind) -> Vec<String> {
        let mut arguments = vec![format!("--child={}", kind.name())];
        arguments.extend(self.scene.iter().map(|scene| format!("--scene={}", scene.name())));
        arguments.extend(self.bodies.map(|bodies| format!("--bodies={bodies}")));
        arguments.push(format!("--threads={}", self.threads));
        arguments.push(format!("--seed={}", self.seed));
        arguments
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

/// What an engine does before it is another's turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Turn {
    pub(crate) steps: u32,
    pub(crate) timed: bool,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(arguments: &[&str]) -> Result<Options, String> {
        let all = ["rockfall-bench"].iter().chain(arguments);
        Options::try_parse_from(all).map_err(|e| e.to_string())
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
        let arguments = parent.of_child(engine::Kind::Rapier);
        let child = parse(&arguments.iter().map(String::as_str).collect::<Vec<_>>()).expect("options");
        assert_eq!(child.child, Some(engine::Kind::Rapier));
        assert_eq!((child.bodies, child.threads, child.seed), (Some(55), 3, 9));
        assert!(matches!(child.only_scene(), Ok(scene::Kind::Pyramid)));
    }

    #[test]
    fn scenes_have_their_own_bodies_and_steps_unless_told() {
        let steps = |options: &Options, scene| options.turns(scene).iter().map(|t| t.steps).sum::<u32>();
        let silent = parse(&[]).expect("options");
        let washer = scene::Kind::Box3dWasher;
        assert_eq!((silent.bodies_of(washer), steps(&silent, washer)), (8000, 1000));
        let told = parse(&["--bodies=50", "--steps=70"]).expect("options");
        assert_eq!((told.bodies_of(washer), steps(&told, washer)), (50, 70));
    }

    #[test]
    fn numbers_out_of_range_are_refused() {
        for bad in ["--bodies=0", "--bodies=-1", "--threads=0", "--steps=0", "--repeats=0", "--turn=0"] {
            assert!(parse(&[bad]).is_err(), "{bad}");
        }
        assert_eq!(parse(&["--bodies=10_000"]).expect("options").bodies, Some(10_000));
        assert!(parse(&["--bodies=10000001"]).expect_err("too many").contains("from 1 to 10000000"));
    }
}
