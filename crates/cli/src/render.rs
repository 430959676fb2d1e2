//! `rockfall render`: pictures, films and contact sheets of a run, or of a scene that is simulated for them.

use crate::args::{RenderArgs, Size};
use crate::exit::Failure;
use crate::film::{Pace, Reel, SIZE};
use crate::progress::Progress;
use crate::shots::{self, Shots};
use crate::stop::Stop;
use crate::{say, units};
use rockfall_cache::{RunReader, SCENE};
use rockfall_export::{Frames, Run};
use rockfall_picture::{Picture, Recorded, Sight, sheet};
use rockfall_scene::Scene;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Takes the pictures that the options want.
pub(crate) fn render(args: &RenderArgs) -> Result<(), Failure> {
    // Whatever does not hang on the frames is found out before the work begins.
    let file = File::of(args)?;
    match args.threads {
        None => pictures(args, &file),
        Some(threads) => {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build();
            let pool = pool.map_err(|error| Failure::Run(format!("cannot start threads: {error}")))?;
            pool.install(|| pictures(args, &file))
        }
    }
}

fn pictures(args: &RenderArgs, file: &File) -> Result<(), Failure> {
    if RunReader::is_run(&args.path) || args.path.is_dir() {
        of_run(args, file)
    } else {
        of_scene(args, file)
    }
}

fn of_run(args: &RenderArgs, file: &File) -> Result<(), Failure> {
    let run = Run::open(&args.path)?;
    let plan = Plan::new(args, file, run.frames(), run.summary().frames_per_second)?;
    let cameras = Scene::load(args.path.join(SCENE))?.cameras();
    let chosen = shots::chosen(args.look.camera.as_deref(), cameras)?;
    let recorded = Recorded::new(&run)?;
    let mut shots = Shots::new(&args.look, plan.size, chosen);
    let ends = [plan.frames[0], plan.frames[plan.frames.len() - 1]];
    let ends = if plan.frames.len() > 1 { &ends[..] } else { &ends[..1] };
    shots.prepare(&ends.iter().map(|&frame| recorded.at(frame)).collect::<Result<Vec<Sight>, _>>()?)?;
    let mut output = Output::start(args, file, &plan)?;
    let stop = Stop::listen("this picture")?;
    let mut progress = Progress::new(plan.frames.len() as u64, 0, args.quiet || plan.frames.len() == 1);
    for &frame in &plan.frames {
        if stop.asked() {
            progress.finish();
            output.finish(args)?;
            return Err(Failure::Interrupted);
        }
        output.picture(args, &mut shots, recorded.at(frame)?)?;
        progress.frames(1);
    }
    progress.finish();
    output.finish(args)
}

fn of_scene(args: &RenderArgs, file: &File) -> Result<(), Failure> {
    let mut scene = Scene::load(&args.path)?;
    if let Some(threads) = args.threads {
        scene.settings.threads = threads.into();
    }
    let plan = Plan::new(args, file, scene.frames + 1, scene.settings.rate.into())?;
    let chosen = shots::chosen(args.look.camera.as_deref(), scene.cameras())?;
    let mut running = scene.build()?;
    let mut shots = Shots::new(&args.look, plan.size, chosen);
    let mut output = Output::start(args, file, &plan)?;
    let stop = Stop::listen("this step")?;
    let mut progress = Progress::new(plan.frames[plan.frames.len() - 1], 0, args.quiet);
    let mut done = 0;
    for (k, &frame) in plan.frames.iter().enumerate() {
        for step in done..frame {
            if stop.asked() {
                progress.finish();
                output.finish(args)?;
                return Err(Failure::Interrupted);
            }
            running.before_step(step).map_err(|error| Failure::Run(format!("at frame {step}: {error}")))?;
            let start = Instant::now();
            running.world.step();
            progress.step(running.world.report(), start.elapsed());
        }
        done = frame;
        let sight = Sight::of_world(&scene, &running, frame);
        if k == 0 {
            shots.prepare(std::slice::from_ref(&sight))?;
        }
        if k + 1 == plan.frames.len() {
            progress.finish();
        }
        output.picture(args, &mut shots, sight)?;
    }
    output.finish(args)
}

/// Size of one of the pictures on a sheet.
const SMALL: Size = Size { width: 480, height: 270 };

/// Which frames, how large, how fast.
struct Plan {
    frames: Vec<u64>,
    size: Size,
    rate: f64,
}

impl Plan {
    /// Of a run with frames 0 to `count` - 1, `rate` a second.
    fn new(args: &RenderArgs, file: &File, count: u64, rate: f64) -> Result<Self, Failure> {
        let last = count.saturating_sub(1);
        let many = file.kind == Kind::Mp4 || args.contact_sheet.is_some();
        let all = if many {
            Frames { first: None, last: None, every: 1 }
        } else {
            Frames { first: Some(last), last: Some(last), every: 1 }
        };
        let wanted = args.frame.unwrap_or(all);
        let size = args.size.unwrap_or(if args.contact_sheet.is_some() { SMALL } else { SIZE });
        if let Some(grid) = args.contact_sheet {
            let frames = wanted.among(count)?;
            let (cells, every) = (u64::from(grid.columns) * u64::from(grid.rows), args.every.unwrap_or(1));
            let frames: Vec<u64> = frames.into_iter().step_by(every as usize).collect();
            // From the first to the last, evenly; where there are fewer, all.
            let (most, shown) = (frames.len() as u64 - 1, cells.min(frames.len() as u64));
            let at = |k: u64| frames[(k * most).checked_div(shown - 1).unwrap_or(0) as usize];
            return Ok(Plan { frames: (0..shown).map(at).collect(), size, rate });
        }
        let pace = match file.kind {
            Kind::Mp4 => Pace::new(rate, args.every, args.fps),
            Kind::Png | Kind::Exr => Pace { every: args.every.unwrap_or(1), rate },
        };
        Ok(Plan { frames: Frames { every: pace.every, ..wanted }.among(count)?, size, rate: pace.rate })
    }
}

/// What becomes of the pictures.
enum Output<'a> {
    Files { file: &'a File, many: bool },
    Film(Box<Reel>),
    Sheet { file: &'a File, pictures: Vec<Picture> },
}

impl<'a> Output<'a> {
    fn start(args: &RenderArgs, file: &'a File, plan: &Plan) -> Result<Self, Failure> {
        let pictures = plan.frames.len() as u64;
        if file.kind == Kind::Mp4 {
            let reel = Reel::start(&file.path, plan.size, plan.rate, pictures, args.look.quality)?;
            return Ok(Output::Film(Box::new(reel)));
        }
        Ok(match args.contact_sheet {
            Some(_) => Output::Sheet { file, pictures: Vec::new() },
            None => Output::Files { file, many: pictures > 1 },
        })
    }

    fn picture(&mut self, args: &RenderArgs, shots: &mut Shots, sight: Sight) -> Result<(), Failure> {
        let start = Instant::now();
        let (frame, bodies) = (sight.frame, sight.bodies.len() as u64);
        let (image, picture) = shots.take(sight)?;
        match self {
            Output::Film(reel) => reel.push(picture),
            Output::Sheet { pictures, .. } => {
                pictures.push(picture);
                Ok(())
            }
            Output::Files { file, many } => {
                let path = file.of_frame(frame, *many);
                match file.kind {
                    Kind::Exr => image.write_exr(&path)?,
                    Kind::Png | Kind::Mp4 => picture.write_png(&path)?,
                }
                let what = format!("frame {} of {} bodies", units::count(frame), units::count(bodies));
                written(args, &path, &what, &picture, start);
                Ok(())
            }
        }
    }

    /// Completes what is there, also if it is not all that was to come.
    fn finish(self, args: &RenderArgs) -> Result<(), Failure> {
        match self {
            Output::Files { .. } => Ok(()),
            Output::Film(reel) => reel.finish(args.quiet),
            Output::Sheet { file, pictures } => {
                let (start, count) = (Instant::now(), pictures.len());
                if count == 0 {
                    return Ok(());
                }
                let all = sheet(&pictures, args.contact_sheet.map_or(1, |grid| grid.columns));
                let path = file.of_sheet();
                all.write_png(&path)?;
                written(args, &path, &format!("{count} moments"), &all, start);
                Ok(())
            }
        }
    }
}

/// Says what was written.
fn written(args: &RenderArgs, path: &Path, what: &str, picture: &Picture, start: Instant) {
    if !args.quiet {
        let Picture { width, height, .. } = picture;
        let time = units::time(start.elapsed());
        say::out(&format!("{}: {what}, {width} × {height}, in {time}", path.display()));
    }
}

/// Where pictures go.
struct File {
    path: PathBuf,
    kind: Kind,
    /// Whether somebody chose it.
    given: bool,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Png,
    Exr,
    Mp4,
}

impl File {
    fn of(args: &RenderArgs) -> Result<Self, Failure> {
        let Some(path) = &args.output else {
            let name = args
                .path
                .file_stem()
                .map_or_else(|| "picture".into(), |name| name.to_string_lossy().into_owned());
            if args.fps.is_some() {
                return Err(Failure::Usage("--fps is for films, -o NAME.mp4".into()));
            }
            return Ok(File { path: PathBuf::from(format!("{name}.png")), kind: Kind::Png, given: false });
        };
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        let kind = match extension.as_deref() {
            Some("png") => Kind::Png,
            Some("exr") => Kind::Exr,
            Some("mp4") => Kind::Mp4,
            _ => {
                let message = format!(
                    "{} is not a picture's name, expected NAME.png, NAME.exr or NAME.mp4",
                    path.display()
                );
                return Err(Failure::Usage(message));
            }
        };
        if kind == Kind::Exr && (!args.look.overlay.is_empty() || args.look.caption) {
            let message = "an EXR file holds light alone; overlays and captions need NAME.png";
            return Err(Failure::Usage(message.into()));
        }
        if kind != Kind::Png && args.contact_sheet.is_some() {
            return Err(Failure::Usage("a contact sheet is one picture, and needs NAME.png".into()));
        }
        if kind != Kind::Mp4 && args.fps.is_some() {
            return Err(Failure::Usage("--fps is for films, -o NAME.mp4".into()));
        }
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        if !folder.is_dir() {
            return Err(Failure::Run(format!(
                "cannot write {}: there is no folder {}",
                path.display(),
                folder.display()
            )));
        }
        Ok(File { path: path.clone(), kind, given: true })
    }

    /// The file of a frame: its number is in the name where there are many, or nobody chose one.
    fn of_frame(&self, frame: u64, many: bool) -> PathBuf {
        if self.given && !many {
            return self.path.clone();
        }
        let name = self.path.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        let extension = if self.kind == Kind::Exr { "exr" } else { "png" };
        let number = if many { format!("{frame:06}") } else { frame.to_string() };
        self.path.with_file_name(format!("{name}-{number}.{extension}"))
    }

    /// The file of a contact sheet.
    fn of_sheet(&self) -> PathBuf {
        if self.given {
            return self.path.clone();
        }
        let name = self.path.file_stem().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        self.path.with_file_name(format!("{name}-sheet.png"))
    }
}
