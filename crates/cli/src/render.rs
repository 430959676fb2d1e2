//! `rockfall render`: pictures of a run, or of a scene that is simulated for them.

use crate::args::RenderArgs;
use crate::exit::Failure;
use crate::progress::Progress;
use crate::stop::Stop;
use crate::{say, units};
use rockfall_cache::{RunReader, SCENE};
use rockfall_export::{Frames, Run};
use rockfall_picture::{Camera, Look, Recorded, Sight, take};
use rockfall_scene::{Scene, SceneCamera};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The camera that finds its own place.
const AUTOMATIC: &str = "auto";

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
    let last = run.frames().saturating_sub(1);
    let wanted = args.frame.unwrap_or(Frames { first: Some(last), last: Some(last), every: 1 });
    let frames = Frames { every: args.every, ..wanted }.among(run.frames())?;
    let chosen = chosen(args, || Ok(Scene::load(args.path.join(SCENE))?.cameras()))?;
    let recorded = Recorded::new(&run)?;
    let mut job = Job { args, file, chosen, automatic: None, span: None, many: frames.len() > 1 };
    let ends = [frames[0], frames[frames.len() - 1]];
    let ends = if job.many { &ends[..] } else { &ends[..1] };
    job.prepare(&ends.iter().map(|&frame| recorded.at(frame)).collect::<Result<Vec<Sight>, _>>()?)?;
    let stop = Stop::listen("this picture")?;
    let mut progress = Progress::new(frames.len() as u64, 0, args.quiet || !job.many);
    for frame in frames {
        if stop.asked() {
            progress.finish();
            return Err(Failure::Interrupted);
        }
        job.picture(&recorded.at(frame)?)?;
        progress.frames(1);
    }
    progress.finish();
    Ok(())
}

fn of_scene(args: &RenderArgs, file: &File) -> Result<(), Failure> {
    let mut scene = Scene::load(&args.path)?;
    if let Some(threads) = args.threads {
        scene.settings.threads = threads.into();
    }
    let wanted =
        args.frame.unwrap_or(Frames { first: Some(scene.frames), last: Some(scene.frames), every: 1 });
    let frames = Frames { every: args.every, ..wanted }.among(scene.frames + 1)?;
    let chosen = chosen(args, || Ok(scene.cameras()))?;
    let mut running = scene.build()?;
    let mut job = Job { args, file, chosen, automatic: None, span: None, many: frames.len() > 1 };
    let stop = Stop::listen("this step")?;
    let mut progress = Progress::new(frames[frames.len() - 1], 0, args.quiet);
    let mut done = 0;
    for (k, &frame) in frames.iter().enumerate() {
        for step in done..frame {
            if stop.asked() {
                progress.finish();
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
            job.prepare(std::slice::from_ref(&sight))?;
        }
        if k + 1 == frames.len() {
            progress.finish();
        }
        job.picture(&sight)?;
    }
    Ok(())
}

/// The camera of the scene that is asked for; its first one where nobody asks, `None` for the automatic one.
fn chosen(
    args: &RenderArgs,
    cameras: impl FnOnce() -> Result<Vec<SceneCamera>, Failure>,
) -> Result<Option<SceneCamera>, Failure> {
    let mut cameras = cameras()?;
    let Some(name) = args.camera.as_deref() else {
        return Ok((!cameras.is_empty()).then(|| cameras.swap_remove(0)));
    };
    if let Some(found) = cameras.iter().position(|camera| camera.name == name) {
        return Ok(Some(cameras.swap_remove(found)));
    }
    if name == AUTOMATIC {
        return Ok(None);
    }
    let mut names: Vec<String> = cameras.iter().map(|camera| format!("`{}`", camera.name)).collect();
    names.push(format!("`{AUTOMATIC}`"));
    Err(Failure::Usage(format!("the scene has no camera `{name}`, expected {}", names.join(" or "))))
}

/// Pictures with one camera and one legend.
struct Job<'a> {
    args: &'a RenderArgs,
    file: &'a File,
    chosen: Option<SceneCamera>,
    automatic: Option<Camera>,
    span: Option<[f32; 2]>,
    many: bool,
}

impl Job<'_> {
    /// Finds what all pictures have in common from some of their moments: the place of the automatic camera, and the span of the colours.
    fn prepare(&mut self, sights: &[Sight]) -> Result<(), Failure> {
        if self.chosen.is_none()
            && let Some(first) = sights.first()
        {
            let balls: Vec<_> = sights.iter().flat_map(|sight| sight.stage(&blank(sight)).balls()).collect();
            let aspect = f64::from(self.args.size.width) / f64::from(self.args.size.height);
            self.automatic = Some(Camera::fitting(&first.stage(&blank(first)), &balls, aspect));
        }
        for sight in sights {
            if let Some([low, high]) = self.args.color_by.span(sight)? {
                let [a, b] = self.span.unwrap_or([low, high]);
                self.span = Some([a.min(low), b.max(high)]);
            }
        }
        Ok(())
    }

    fn picture(&self, sight: &Sight) -> Result<(), Failure> {
        let args = self.args;
        let camera = match (&self.chosen, self.automatic) {
            (Some(chosen), _) => Camera::of_scene(chosen, sight)?,
            (None, Some(camera)) => camera,
            (None, None) => return Ok(()),
        };
        let look = Look {
            width: args.size.width,
            height: args.size.height,
            quality: args.quality,
            colors: args.color_by,
            span: self.span,
            overlays: args.overlay.clone(),
            caption: args.caption,
        };
        let start = Instant::now();
        let (image, picture) = take(sight, &camera, &look)?;
        let path = self.file.of_frame(sight.frame, self.many);
        match self.file.kind {
            Kind::Png => picture.write_png(&path)?,
            Kind::Exr => image.write_exr(&path)?,
        }
        if !args.quiet {
            say::out(&format!(
                "{}: frame {} of {} bodies, {} × {}, in {}",
                path.display(),
                units::count(sight.frame),
                units::count(sight.bodies.len() as u64),
                picture.width,
                picture.height,
                units::time(start.elapsed()),
            ));
        }
        Ok(())
    }
}

/// Colours for what only has to be there.
fn blank(sight: &Sight) -> Vec<[f32; 3]> {
    vec![[0.0; 3]; sight.bodies.len()]
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
}

impl File {
    fn of(args: &RenderArgs) -> Result<Self, Failure> {
        let Some(path) = &args.output else {
            let name = args
                .path
                .file_stem()
                .map_or_else(|| "picture".into(), |name| name.to_string_lossy().into_owned());
            return Ok(File { path: PathBuf::from(format!("{name}.png")), kind: Kind::Png, given: false });
        };
        let extension = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        let kind = match extension.as_deref() {
            Some("png") => Kind::Png,
            Some("exr") => Kind::Exr,
            _ => {
                let message =
                    format!("{} is not a picture's name, expected NAME.png or NAME.exr", path.display());
                return Err(Failure::Usage(message));
            }
        };
        if kind == Kind::Exr && (!args.overlay.is_empty() || args.caption) {
            let message = "an EXR file holds light alone; overlays and captions need NAME.png";
            return Err(Failure::Usage(message.into()));
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
        let extension = if self.kind == Kind::Png { "png" } else { "exr" };
        let number = if many { format!("{frame:06}") } else { frame.to_string() };
        self.path.with_file_name(format!("{name}-{number}.{extension}"))
    }
}
