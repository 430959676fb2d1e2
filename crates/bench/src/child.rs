//! A process that holds one engine with one scene and steps it when it is told to.
//!
//! Engines live in processes of their own, so that each one's memory can be told apart, and neither finds the
//! other's threads or heap in its way.

use crate::options::{Case, Options};
use crate::quality::{self, Quality};
use crate::scene::Scene;
use crate::{Error, engine, process};
use rockfall::math::Pose;
use serde::{Deserialize, Serialize};
use std::io::{BufRead, BufReader, Write};
use std::process::{ChildStdin, ChildStdout, Command, Stdio};
use std::time::Instant;

/// A line to the child.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) enum Request {
    /// So many steps.
    Step(u32),
    /// One last step, not timed, and the figures.
    Finish,
}

/// A line from the child.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) enum Reply {
    /// The scene is built.
    Ready,
    /// The steps are done.
    Stepped(Block),
    /// The child ends.
    Finished(Outcome),
}

/// Means over a few steps, milliseconds per step.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Block {
    /// On the clock on the wall.
    pub(crate) wall: f64,
    /// On the processors, all threads together.
    pub(crate) cpu: Option<f64>,
    /// By stage, where the engine tells.
    pub(crate) stages: Vec<(String, f64)>,
    /// Of the very first step of the engine alone, where it is among them.
    pub(crate) first: Option<f64>,
    /// Bytes that the solver must have read in a step, at least, where the engine tells.
    pub(crate) solver_bytes: Option<f64>,
    /// Peak memory of the process in these steps less what it had before the engine was built, bytes.
    pub(crate) memory: Option<u64>,
}

/// What is known at the end.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Outcome {
    /// Dynamic bodies.
    pub(crate) bodies: usize,
    /// Fixed and driven ones.
    pub(crate) immovable: usize,
    /// Of all dynamic bodies together, kg.
    pub(crate) mass: f64,
    /// Peak memory of the process less what it had before the engine was built, bytes.
    pub(crate) memory: Option<u64>,
    /// Of the last state.
    pub(crate) quality: Quality,
}

/// Serves requests from `input` until the last or until the input ends.
pub(crate) fn serve(
    options: &Options,
    kind: engine::Kind,
    input: impl BufRead,
    mut output: impl Write,
) -> Result<(), Error> {
    let case = options.only_case()?;
    let scene = case.scene.build(case.bodies, options.seed)?;
    let empty = process::peak_memory();
    let engine = kind.build(&scene, case.threads)?;
    let mut run = Run { scene: &scene, engine, there: scene.present(0), steps: 0, empty, most: None };
    send(&mut output, &Reply::Ready)?;
    for line in input.lines() {
        match serde_json::from_str(&line?)? {
            Request::Step(steps) => {
                let block = run.block(steps)?;
                send(&mut output, &Reply::Stepped(block))?;
            }
            Request::Finish => {
                let memory = run.most.max(run.memory());
                run.begin()?;
                let mass = run.engine.mass();
                let before = run.engine.poses();
                run.engine.step()?;
                let quality = quality::measure(&scene, run.steps, &before, &run.engine.poses());
                let immovable = scene.fixed.len() + scene.driven.len();
                let outcome = Outcome { bodies: before.len(), immovable, mass, memory, quality };
                return send(&mut output, &Reply::Finished(outcome));
            }
        }
    }
    Ok(())
}

/// An engine on its way through a scene.
struct Run<'a> {
    scene: &'a Scene,
    engine: Box<dyn engine::Engine>,
    /// Dynamic bodies so far.
    there: usize,
    /// Begun so far.
    steps: u32,
    /// Memory before the engine was built, bytes.
    empty: Option<u64>,
    /// The most that the engine has had so far, bytes.
    most: Option<u64>,
}

impl Run<'_> {
    /// Begins a step: adds the bodies that come in, and tells driven ones where to go in it.
    fn begin(&mut self) -> Result<(), Error> {
        let present = self.scene.present(self.steps);
        if present > self.there {
            self.engine.spawn(&self.scene.bodies[self.there..present])?;
            self.there = present;
        }
        self.steps += 1;
        let targets: Vec<Pose> = self.scene.driven.iter().map(|driven| driven.after(self.steps)).collect();
        if targets.is_empty() { Ok(()) } else { self.engine.drive(&targets) }
    }

    /// Some steps, timed.
    fn block(&mut self, steps: u32) -> Result<Block, Error> {
        let mut stages: Vec<(String, f64)> = Vec::new();
        let share = 1.0 / f64::from(steps.max(1));
        let (mut wall, cpu) = (0.0, process::cpu_ms());
        let (mut first, mut solver_bytes) = (None, None);
        self.most = self.most.max(self.memory());
        let fresh = process::forget_peak();
        for _ in 0..steps {
            let start = Instant::now();
            self.begin()?;
            self.engine.step()?;
            let time = 1e3 * start.elapsed().as_secs_f64();
            wall += share * time;
            if self.steps == 1 {
                first = Some(time);
            }
            if let Some(bytes) = self.engine.solver_bytes() {
                *solver_bytes.get_or_insert(0.0) += share * bytes;
            }
            for (i, (name, time)) in self.engine.stages().into_iter().enumerate() {
                if i == stages.len() {
                    stages.push((name.to_owned(), 0.0));
                }
                stages[i].1 += share * time;
            }
        }
        let cpu = process::cpu_ms().zip(cpu).map(|(after, before)| share * (after - before));
        let memory = self.memory();
        self.most = self.most.max(memory);
        let memory = memory.filter(|_| fresh);
        Ok(Block { wall, cpu, stages, first, solver_bytes, memory })
    }

    /// Peak memory of the engine, bytes.
    fn memory(&self) -> Option<u64> {
        process::peak_memory().zip(self.empty).map(|(peak, empty)| peak.saturating_sub(empty))
    }
}

fn send(output: &mut impl Write, message: &impl Serialize) -> Result<(), Error> {
    serde_json::to_writer(&mut *output, message)?;
    output.write_all(b"\n")?;
    Ok(output.flush()?)
}

/// The other end: a child to talk to.
pub(crate) struct Child {
    name: &'static str,
    process: std::process::Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
}

impl Child {
    /// Starts this program again with one engine and one scene.
    pub(crate) fn start(
        options: &Options,
        verb: Option<&str>,
        kind: engine::Kind,
        case: Case,
    ) -> Result<Self, Error> {
        let name = kind.name();
        let mut process = Command::new(std::env::current_exe()?)
            .args(verb)
            .args(options.of_child(kind, case))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()?;
        let lost = || Error::Engine { engine: name, reason: "its process has no pipes".to_owned() };
        let input = process.stdin.take().ok_or_else(lost)?;
        let output = BufReader::new(process.stdout.take().ok_or_else(lost)?);
        let mut child = Child { name, process, input, output };
        match child.receive()? {
            Reply::Ready => Ok(child),
            other => Err(child.surprise(&other)),
        }
    }

    /// Does steps.
    pub(crate) fn step(&mut self, steps: u32) -> Result<Block, Error> {
        send(&mut self.input, &Request::Step(steps))?;
        match self.receive()? {
            Reply::Stepped(block) => Ok(block),
            other => Err(self.surprise(&other)),
        }
    }

    /// Gets the figures and ends the child.
    pub(crate) fn finish(mut self) -> Result<Outcome, Error> {
        send(&mut self.input, &Request::Finish)?;
        let reply = self.receive()?;
        self.process.wait()?;
        match reply {
            Reply::Finished(outcome) => Ok(outcome),
            other => Err(self.surprise(&other)),
        }
    }

    fn receive(&mut self) -> Result<Reply, Error> {
        let mut line = String::new();
        if self.output.read_line(&mut line)? == 0 {
            let status = self.process.wait()?;
            let reason = format!("its process ended early ({status})");
            return Err(Error::Engine { engine: self.name, reason });
        }
        Ok(serde_json::from_str(&line)?)
    }

    fn surprise(&self, reply: &Reply) -> Error {
        Error::Engine { engine: self.name, reason: format!("its process answered out of turn: {reply:?}") }
    }
}

impl Drop for Child {
    /// A child whose input ends stops by itself; one that is in a step is stopped.
    fn drop(&mut self) {
        if matches!(self.process.try_wait(), Ok(None)) {
            // Nothing is left to do where this fails: the child is gone already.
            let _ = self.process.kill();
            let _ = self.process.wait();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::options::tests::parse;

    #[test]
    fn a_child_answers_each_request_with_a_line() {
        let options = parse(&["--scene=box-pile", "--bodies=20"]).expect("options");
        let input = "{\"Step\":3}\n\"Finish\"\n";
        let mut output = Vec::new();
        serve(&options, engine::Kind::Rockfall, input.as_bytes(), &mut output).expect("served");
        let text = String::from_utf8(output).expect("text");
        let replies: Vec<Reply> =
            text.lines().map(|line| serde_json::from_str(line).expect("a reply")).collect();
        let [Reply::Ready, Reply::Stepped(block), Reply::Finished(outcome)] = replies.as_slice() else {
            panic!("{text}");
        };
        assert!(block.wall > 0.0 && block.stages.len() == rockfall::STAGES.len());
        let staged: f64 = block.stages.iter().map(|(_, time)| time).sum();
        assert!(staged <= block.wall, "{staged} ms of {}", block.wall);
        assert!(block.first.is_some_and(|first| first > 0.0 && first < 3.0 * block.wall));
        assert!(block.solver_bytes.is_some_and(|bytes| bytes >= 20.0 * (9.0 * 64.0 + 8.0 * 32.0)));
        assert!(outcome.bodies == 20 && outcome.mass > 0.0);
        assert!(block.memory <= outcome.memory);
    }

    #[test]
    fn nonsense_is_an_error_and_the_end_of_input_is_none() {
        let options = parse(&["--scene=box-pile", "--bodies=1"]).expect("options");
        let ask = |input: &str| serve(&options, engine::Kind::Rockfall, input.as_bytes(), Vec::new());
        assert!(matches!(ask("{\"Jump\":1}\n"), Err(Error::Json(_))));
        assert!(ask("").is_ok());
    }
}
