//! What a person can ask for.

use clap::{Args, Parser, Subcommand, ValueEnum};
use rockfall::Solver;
use rockfall_export::{Frames, Ids};
use rockfall_picture::{ColorBy, Overlay, Quality};
use std::net::IpAddr;
use std::path::PathBuf;
use std::time::Duration;

/// Simulates very many rigid bodies in hard contact.
#[derive(Debug, Parser)]
#[command(name = "rockfall", version, propagate_version = true, max_term_width = 100)]
#[command(
    after_help = "Exit codes: 0 done, 1 the run failed or is damaged, 2 wrong usage, 3 wrong scene, 4 another result \
than expected, 130 interrupted."
)]
pub(crate) struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub(crate) verb: Verb,
}

/// The verbs.
#[derive(Debug, Subcommand)]
pub(crate) enum Verb {
    /// Run a scene and write its output.
    Run(Box<RunArgs>),
    /// Say what is in a scene file or in the output of a run.
    Info(InfoArgs),
    /// Check that the output of a run is whole: checksums, rows, frames, poses.
    Verify(VerifyArgs),
    /// Say where two runs differ first, and by how much.
    Diff(DiffArgs),
    /// Write a run as files that other programs open.
    Export(ExportArgs),
    /// Drive the solvers through cases with known answers, and say how far off they are.
    Validate(ValidateArgs),
    /// Take pictures of a run, or of a scene that is simulated for them.
    Render(Box<RenderArgs>),
    /// Show a scene that is simulated, or a run, on a page in the browser.
    View(ViewArgs),
    /// Write a page that shows a run: pictures, figures and curves.
    Report(ReportArgs),
    /// Run the same scene in several engines, turn by turn, and compare time, memory and quality.
    #[cfg(feature = "bench")]
    Bench(Box<rockfall_bench::Options>),
    /// What a build without the feature says of it: how to get it.
    #[cfg(not(feature = "bench"))]
    #[command(hide = true, disable_help_flag = true, disable_version_flag = true)]
    Bench(NoBenchArgs),
}

/// `rockfall bench` where it is not built: whatever is asked of it.
#[cfg(not(feature = "bench"))]
#[derive(Debug, Args)]
pub(crate) struct NoBenchArgs {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    _all: Vec<std::ffi::OsString>,
}

/// `rockfall run`.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Scene file, or a scene of another program: .usd, .usda, .usdc, .usdz, .gltf or .glb.
    #[arg(required_unless_present = "resume")]
    pub(crate) scene: Option<PathBuf>,
    /// Go on with the run in this folder, from its last checkpoint. Only threads, lanes and what is printed can be chosen.
    #[arg(long, value_name = "DIR", conflicts_with_all = [
        "scene", "out", "overwrite", "no_output", "frames", "solver", "substeps", "seed", "position_error", "rotation_error",
        "dry_run",
    ])]
    pub(crate) resume: Option<PathBuf>,
    /// Save the whole state every so many frames, or so much time (90s, 10min, 1h), or never; the last two are kept.
    #[arg(long, value_name = "N", default_value = "10min", value_parser = every)]
    pub(crate) checkpoint_every: Every,
    /// Folder for the output, made where it is missing [default: the next free runs/SCENE-NUMBER].
    #[arg(long, value_name = "DIR", conflicts_with = "no_output")]
    pub(crate) out: Option<PathBuf>,
    /// Replace the run that is in the output folder.
    #[arg(long, requires = "out")]
    pub(crate) overwrite: bool,
    /// Write nothing to disk.
    #[arg(long)]
    pub(crate) no_output: bool,
    /// Make a film of it as well, NAME.mp4: of all frames, by the scene's first camera. `rockfall render` makes others of the run.
    #[arg(long, value_name = "PATH", conflicts_with_all = ["resume", "dry_run"])]
    pub(crate) film: Option<PathBuf>,
    /// Steps to simulate [default: the scene's].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000_000))]
    pub(crate) frames: Option<u64>,
    /// Threads [default: as many as the machine has]. Never changes the result.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096))]
    pub(crate) threads: Option<u16>,
    /// SIMD lanes, no more than the machine has [default: as many]. Never changes the result.
    #[arg(long, value_name = "N", value_parser = lanes)]
    pub(crate) lanes: Option<usize>,
    /// How contacts are answered [default: the scene's].
    #[arg(long, value_name = "NAME")]
    pub(crate) solver: Option<SolverName>,
    /// Sub-steps in a step [default: the scene's].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) substeps: Option<u32>,
    /// Seed of everything random [default: the scene's].
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,
    /// Metres by which positions on disk may be off; they take less space then [default: the scene's].
    #[arg(long, value_name = "M", value_parser = |text: &str| within(text, 1e-6, 1000.0))]
    pub(crate) position_error: Option<f64>,
    /// Degrees by which rotations on disk may be off; they take less space then [default: the scene's].
    #[arg(long, value_name = "DEG", value_parser = |text: &str| within(text, 0.0075, 20.0))]
    pub(crate) rotation_error: Option<f64>,
    /// Print the summary as JSON on standard output.
    #[arg(long)]
    pub(crate) json: bool,
    /// Print the hash of the last state, and nothing else, on standard output.
    #[arg(long, conflicts_with = "json")]
    pub(crate) hash: bool,
    /// Fail with exit code 4 when the hash of the last state is another one.
    #[arg(long, value_name = "HASH", value_parser = hash)]
    pub(crate) expect_hash: Option<u64>,
    /// Read the scene, count its bodies, estimate memory and disk, and stop there.
    #[arg(long)]
    pub(crate) dry_run: bool,
    /// Print errors only.
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

/// `rockfall info`.
#[derive(Debug, Args)]
pub(crate) struct InfoArgs {
    /// Scene file, scene of another program, or folder of a run.
    pub(crate) path: PathBuf,
    /// Print JSON.
    #[arg(long)]
    pub(crate) json: bool,
}

/// `rockfall verify`.
#[derive(Debug, Args)]
pub(crate) struct VerifyArgs {
    /// Folder of a run.
    pub(crate) run: PathBuf,
}

/// `rockfall diff`.
#[derive(Debug, Args)]
pub(crate) struct DiffArgs {
    /// Folder of a run.
    pub(crate) first: PathBuf,
    /// Folder of the run to compare it with.
    pub(crate) second: PathBuf,
}

/// `rockfall export`.
#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    /// Folder of a run; of one that is not finished, the frames that are there are exported.
    pub(crate) run: PathBuf,
    /// Format.
    #[arg(long, value_name = "FORMAT")]
    pub(crate) to: FormatName,
    /// The file or folder to make [default: RUN.FORMAT or RUN-FORMAT beside the run].
    #[arg(long, short, value_name = "PATH")]
    pub(crate) output: Option<PathBuf>,
    /// Frames, both ends included: 7, 3..7, 3.. or ..7 [default: all].
    #[arg(long, value_name = "A..B")]
    pub(crate) frames: Option<Frames>,
    /// Every so many frames of these.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) every: u64,
    /// csv, parquet, glb: bodies by their ids, such as 1,5,10..20 [default: all].
    #[arg(long, value_name = "IDS")]
    pub(crate) bodies: Option<Ids>,
    /// vtp: the triangles of all bodies, instead of a point for each.
    #[arg(long)]
    pub(crate) meshes: bool,
    /// parquet: a folder with a file for each frame, instead of one file.
    #[arg(long)]
    pub(crate) per_frame: bool,
    /// usd: velocities and angular velocities, 24 bytes more for a body and frame.
    #[arg(long)]
    pub(crate) velocities: bool,
    /// usd: orientations of single precision beside those of half, 16 bytes more for a body and frame.
    #[arg(long)]
    pub(crate) precise: bool,
    /// usd: a folder with files of N frames each, or one file with 0 [default: one file up to 1 GiB, else files of about 256 MiB].
    #[arg(long, value_name = "N")]
    pub(crate) clips: Option<u64>,
    /// Replace a former export.
    #[arg(long)]
    pub(crate) overwrite: bool,
    /// Threads [default: as many as the machine has]. Never changes the result.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096))]
    pub(crate) threads: Option<u16>,
    /// Print errors only.
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

/// `rockfall validate`.
#[derive(Debug, Args)]
pub(crate) struct ValidateArgs {
    /// Cases and groups of cases by name, such as rolling-y,friction [default: all].
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub(crate) only: Vec<String>,
    /// Fewer steps and bodies, and no long cases.
    #[arg(long)]
    pub(crate) quick: bool,
    /// Solvers [default: all].
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub(crate) solver: Vec<SolverName>,
    /// Write a page with all figures and pictures.
    #[arg(long, value_name = "FILE")]
    pub(crate) report: Option<PathBuf>,
    /// Print JSON, with all curves, in place of the table.
    #[arg(long)]
    pub(crate) json: bool,
    /// Say what cases there are, and where each is from.
    #[arg(long, conflicts_with_all = ["report", "json"])]
    pub(crate) list: bool,
}

/// `rockfall render`.
#[derive(Debug, Args)]
pub(crate) struct RenderArgs {
    /// Folder of a run, or a scene, which is simulated up to the frame and leaves no run behind.
    #[arg(value_name = "RUN|SCENE")]
    pub(crate) path: PathBuf,
    /// Frames, both ends included: 7, 3..7, 3.. or ..7; a picture for each [default: the last one; all of them for a film or a contact sheet].
    #[arg(long, visible_alias = "frames", value_name = "N|A..B")]
    pub(crate) frame: Option<Frames>,
    /// Every so many frames of these [default: 1; for a film as many as leave 60 a second].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) every: Option<u64>,
    /// Pixels across and down [default: 1280x720, for each picture of a contact sheet 480x270].
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(crate) size: Option<Size>,
    /// What pictures look like.
    #[command(flatten)]
    pub(crate) look: LookArgs,
    /// Pictures a second of a film [default: so many that it is as fast as the world].
    #[arg(long, value_name = "N", value_parser = |text: &str| within(text, 0.001, 1000.0))]
    pub(crate) fps: Option<f64>,
    /// One picture of many moments, from the first frame to the last, in so many columns and rows.
    #[arg(long, value_name = "COLUMNSxROWS", value_parser = grid, num_args = 0..=1, default_missing_value = "4x3")]
    pub(crate) contact_sheet: Option<Grid>,
    /// NAME.png, NAME.exr with light and depth, or the film NAME.mp4; what is there is replaced. The frame's number is put behind the name where there are many [default:
    /// RUN-FRAME.png here].
    #[arg(long, short, value_name = "PATH")]
    pub(crate) output: Option<PathBuf>,
    /// Threads [default: as many as the machine has]. Never changes the result.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096))]
    pub(crate) threads: Option<u16>,
    /// Print errors only.
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

/// `rockfall report`.
#[derive(Debug, Args)]
pub(crate) struct ReportArgs {
    /// Folder of a run.
    pub(crate) run: PathBuf,
    /// The page; what is there is replaced [default: RUN.html here].
    #[arg(long, short, value_name = "PATH")]
    pub(crate) output: Option<PathBuf>,
    /// Put a film into the page in place of a contact sheet: this one, or one that is made for it.
    #[arg(long, value_name = "NAME.mp4", num_args = 0..=1)]
    pub(crate) film: Option<Option<PathBuf>>,
    /// How much work goes into its pictures: draft, default or fine.
    #[arg(long, value_name = "HOW", default_value = "default", value_parser = quality)]
    pub(crate) quality: Quality,
    /// Print errors only.
    #[arg(long, short)]
    pub(crate) quiet: bool,
}

/// What pictures look like.
#[derive(Debug, Args)]
pub(crate) struct LookArgs {
    /// What colours tell.
    #[arg(long, value_name = "WHAT", default_value = "body", value_parser = color_by)]
    pub(crate) color_by: ColorBy,
    /// A camera of the scene, or auto for one that finds its own place [default: the scene's first, else auto].
    #[arg(long, value_name = "NAME")]
    pub(crate) camera: Option<String>,
    /// Draw over the picture: contacts, normals, impulses, bounds, centres, paths.
    #[arg(long, value_name = "WHAT,..", value_delimiter = ',', value_parser = overlay)]
    pub(crate) overlay: Vec<Overlay>,
    /// How much work goes into a picture: draft, default or fine.
    #[arg(long, value_name = "HOW", default_value = "default", value_parser = quality)]
    pub(crate) quality: Quality,
    /// Write frame, time and number of bodies on the picture.
    #[arg(long)]
    pub(crate) caption: bool,
    /// Blur what moves, as a shutter that is open for this share of the time from picture to picture; more than 0, at most 1.
    #[arg(long, value_name = "SHARE", value_parser = |text: &str| within(text, 1e-3, 1.0))]
    pub(crate) blur: Option<f64>,
}

/// What a film of `rockfall run` looks like: what one of `rockfall render` does where nobody says anything.
impl Default for LookArgs {
    fn default() -> Self {
        LookArgs {
            color_by: ColorBy::Body,
            camera: None,
            overlay: Vec::new(),
            quality: Quality::Standard,
            caption: false,
            blur: None,
        }
    }
}

/// Columns and rows of a contact sheet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Grid {
    pub(crate) columns: u32,
    pub(crate) rows: u32,
}

/// `rockfall view`.
#[derive(Debug, Args)]
pub(crate) struct ViewArgs {
    /// A scene, which is simulated as one looks, or the folder of a run, finished or still being written.
    #[arg(value_name = "SCENE|RUN")]
    pub(crate) path: PathBuf,
    /// Port to listen at [default: one that is free].
    #[arg(long, value_name = "PORT", default_value_t = 0, hide_default_value = true)]
    pub(crate) port: u16,
    /// Address to listen at, such as 0.0.0.0 for all of this machine; others than this machine need the token that is printed then.
    #[arg(long, value_name = "ADDR", default_value = "127.0.0.1")]
    pub(crate) host: IpAddr,
    /// Open the page in the browser.
    #[arg(long)]
    pub(crate) open: bool,
    /// Folder for scenes that are saved on the page.
    #[arg(long, value_name = "DIR", default_value = "saved")]
    pub(crate) saves: PathBuf,
    /// Threads [default: as many as the machine has]. Never changes the result.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096))]
    pub(crate) threads: Option<u16>,
}

/// Pixels across and down.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Size {
    pub(crate) width: u32,
    pub(crate) height: u32,
}

/// The formats of exports by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum FormatName {
    /// Blender, Houdini, Omniverse: OpenUSD, one file or a folder with value clips.
    Usd,
    /// ParaView: a folder with one file per frame.
    Vtp,
    /// One row per body and frame, as text.
    Csv,
    /// One row per body and frame, column by column.
    Parquet,
    /// glTF: a still of one frame, or an animation.
    Glb,
}

/// How often the state is saved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Every {
    /// After so many frames.
    Frames(u64),
    /// After the first frame that ends so long after the last time.
    Time(Duration),
    /// Not even when the run is interrupted.
    Never,
}

/// The solvers by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SolverName {
    /// Soft contacts in sub-steps; carries large piles.
    SoftStep,
    /// One impulse per contact point, with restitution and friction.
    Impulse,
    /// The velocity is mirrored at the contact, without friction.
    Reflect,
}

impl From<SolverName> for Solver {
    fn from(name: SolverName) -> Self {
        match name {
            SolverName::SoftStep => Solver::SoftStep,
            SolverName::Impulse => Solver::Impulse,
            SolverName::Reflect => Solver::Reflect,
        }
    }
}

/// The name of a solver.
pub(crate) fn solver_name(solver: Solver) -> &'static str {
    match solver {
        Solver::SoftStep => "soft-step",
        Solver::Impulse => "impulse",
        Solver::Reflect => "reflect",
    }
}

/// A number of lanes that there is.
fn lanes(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(lanes @ (1 | 4 | 8 | 16)) => Ok(lanes),
        _ => Err("expected 1, 4, 8 or 16".into()),
    }
}

/// A number between two others.
fn within(text: &str, least: f64, most: f64) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| (least..=most).contains(number));
    number.ok_or_else(|| format!("expected a number from {least} to {most}"))
}

/// A number of frames, a time, or `never`.
fn every(text: &str) -> Result<Every, String> {
    let expected = || "expected a number of frames, a time such as 90s, 10min or 1h, or never".to_owned();
    if text == "never" {
        return Ok(Every::Never);
    }
    let split = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let number = number.parse::<u64>().ok().filter(|number| (1..=1_000_000_000).contains(number));
    let number = number.ok_or_else(expected)?;
    match unit {
        "" => Ok(Every::Frames(number)),
        "s" => Ok(Every::Time(Duration::from_secs(number))),
        "min" => Ok(Every::Time(Duration::from_secs(60 * number))),
        "h" => Ok(Every::Time(Duration::from_secs(3600 * number))),
        _ => Err(expected()),
    }
}

/// Pixels across and down, such as 1280x720.
fn size(text: &str) -> Result<Size, String> {
    let side = |text: &str| text.parse::<u32>().ok().filter(|side| (16..=16384).contains(side));
    let sides = text.split_once('x').and_then(|(width, height)| side(width).zip(side(height)));
    let sides = sides.map(|(width, height)| Size { width, height });
    sides.ok_or_else(|| "expected WIDTHxHEIGHT, each from 16 to 16384, such as 1280x720".into())
}

fn grid(text: &str) -> Result<Grid, String> {
    let side = |text: &str| text.parse::<u32>().ok().filter(|side| (1..=100).contains(side));
    let sides = text.split_once('x').and_then(|(columns, rows)| side(columns).zip(side(rows)));
    let sides = sides.map(|(columns, rows)| Grid { columns, rows });
    sides.ok_or_else(|| "expected COLUMNSxROWS, each from 1 to 100, such as 4x3".into())
}

/// One of some words.
fn word<T: Copy>(text: &str, words: &[(&str, T)]) -> Result<T, String> {
    let found = words.iter().find(|(word, _)| *word == text).map(|(_, value)| *value);
    let all = || words.iter().map(|(word, _)| *word).collect::<Vec<&str>>().join(", ");
    found.ok_or_else(|| format!("expected one of {}", all()))
}

fn color_by(text: &str) -> Result<ColorBy, String> {
    word(text, &ColorBy::WORDS)
}

fn overlay(text: &str) -> Result<Overlay, String> {
    word(text, &Overlay::WORDS)
}

fn quality(text: &str) -> Result<Quality, String> {
    word(text, &[("draft", Quality::Draft), ("default", Quality::Standard), ("fine", Quality::Fine)])
}

/// A hash as the program prints it.
fn hash(text: &str) -> Result<u64, String> {
    let digits = text.strip_prefix("0x").unwrap_or(text);
    let value = u64::from_str_radix(digits, 16).ok();
    // A sign is no digit, though the parser takes one.
    let well_formed = digits.len() == 16 && digits.chars().all(|c| c.is_ascii_hexdigit());
    value.filter(|_| well_formed).ok_or_else(|| "expected 16 hexadecimal digits".into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_well_formed() {
        Cli::command().debug_assert();
    }

    #[test]
    fn checkpoints_come_after_frames_or_a_time() {
        assert_eq!(every("250"), Ok(Every::Frames(250)));
        assert_eq!(every("90s"), Ok(Every::Time(Duration::from_secs(90))));
        assert_eq!(every("10min"), every("600s"));
        assert_eq!(every("2h"), every("120min"));
        assert_eq!(every("never"), Ok(Every::Never));
        for wrong in ["", "0", "-1", "min", "10 min", "1.5h", "10m", "99999999999"] {
            assert!(every(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_size_has_two_sides() {
        assert_eq!(size("1280x720"), Ok(Size { width: 1280, height: 720 }));
        for wrong in ["", "1280", "1280x", "x720", "8x720", "1280x99999", "-1x5", "1280X720"] {
            assert!(size(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_hash_has_sixteen_digits() {
        assert_eq!(hash("00000000000000ff"), Ok(255));
        assert_eq!(hash("0xABCDEF0123456789"), Ok(0xabcd_ef01_2345_6789));
        for wrong in ["", "ff", "+0000000000000ff", "00000000000000zz", "00000000000000000"] {
            assert!(hash(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn solvers_have_one_name_everywhere() {
        for name in SolverName::value_variants() {
            let value = name.to_possible_value().unwrap();
            assert_eq!(value.get_name(), solver_name((*name).into()));
        }
    }
}
