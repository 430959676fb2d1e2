//! A scene, from its file to a world.

use crate::cameras::{self, SceneCamera};
use crate::error::{Problem, SceneError};
use crate::load::{self, Loaded, Loader};
use crate::memory::{self, Estimate};
use crate::node::{Table, Value};
use crate::plan::{BodyRow, Cut, Plan, cuts, plan};
use crate::root::Output;
use crate::running::Running;
use crate::source::{Source, Sources};
use crate::start::{Begun, Lookup, center};
use crate::visual::Color;
use crate::{import, root, write};
use rockfall::{Kind, Settings, Shape, Solver};
use rockfall_cache::Start;
use rockfall_import::Content;
use rockfall_math::Vec3;
use std::path::Path;
use std::sync::Arc;

/// A scene that has been read and checked.
///
/// # Examples
/// ```
/// let text = r#"
///     [shapes.ball]
///     kind = "sphere"
///     radius = 0.5
///
///     [[bodies]]
///     shape = "ball"
///     position = [0, 0, 10]
/// "#;
/// let scene = rockfall_scene::Scene::parse(text, "ball.toml", ".")?;
/// assert_eq!(scene.body_count(), 1);
/// assert_eq!(scene.frames, 300);
/// # Ok::<(), rockfall_scene::SceneError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Scene {
    /// Settings of the world. Threads and lanes are left to the machine; they never change a result.
    pub settings: Settings,
    /// Frames to simulate.
    pub frames: u64,
    /// All random numbers of the scene come from it.
    pub seed: u64,
    /// What a run of it writes.
    pub output: Output,
    root: Table,
    sources: Sources,
    /// The bodies that it starts with.
    begun: Option<Arc<Begun>>,
    imports: Vec<Arc<Content>>,
}

/// What the bodies of a scene look like.
#[derive(Clone, Debug)]
pub struct Inventory {
    /// All shapes, at the size of their bodies.
    pub shapes: Vec<Shape>,
    /// What is seen in place of shapes, in their frames: meshes that [`Look::visual`](crate::Look::visual) counts. They collide with nothing.
    pub visuals: Vec<Shape>,
    /// Names of all materials.
    pub materials: Vec<String>,
    /// The colour of each material, where it has one.
    pub colors: Vec<Option<Color>>,
    /// All bodies, also those that are poured later; ids ascend unless the scene chose some.
    pub bodies: Vec<BodyRow>,
    /// The centre of mass of each body in the frame of its shape, metres; zero of one that is not dynamic.
    pub centers: Vec<Vec3>,
}

/// Two scenes are equal when they describe the same thing, however it was written.
impl PartialEq for Scene {
    fn eq(&self, other: &Self) -> bool {
        self.root == other.root
    }
}

impl Scene {
    /// Reads the scene file at `path` and all that it includes. A file of another program that [`rockfall_import`] reads is a scene by itself.
    ///
    /// # Errors
    /// Everything that is wrong with the files.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, SceneError> {
        let mut loader = Loader::default();
        loader.file(path.as_ref(), None);
        let folder = path.as_ref().parent().unwrap_or(Path::new(""));
        Scene::new(loader, Lookup::Beside(folder.to_owned()))
    }

    /// Reads a scene from a text. `name` is what messages call it; paths in it start at the folder `base`.
    ///
    /// # Errors
    /// Everything that is wrong with the text and the files that it includes.
    pub fn parse(text: &str, name: &str, base: impl AsRef<Path>) -> Result<Self, SceneError> {
        let base = base.as_ref();
        Scene::parse_with(text, name, base, Lookup::Beside(base.to_owned()))
    }

    /// The same, with what it starts with somewhere else.
    pub(crate) fn parse_with(
        text: &str,
        name: &str,
        base: &Path,
        lookup: Lookup,
    ) -> Result<Self, SceneError> {
        let mut loader = Loader::default();
        loader.text(Source { name: name.to_owned(), text: text.to_owned(), base: base.to_owned() });
        Scene::new(loader, lookup)
    }

    fn new(loader: Loader, lookup: Lookup) -> Result<Self, SceneError> {
        let Loaded { mut root, sources, imports } = loader.finish()?;
        let begun = root.table("start").map(|table| Begun::read(table, &root, &imports, lookup)).transpose();
        let begun = begun.map_err(|problem| SceneError::one(problem, &sources))?.map(Arc::new);
        if let Some(begun) = &begun {
            // That run may go on.
            load::edit(&mut root, "start", |start| start.set("frame", Value::Int(begun.start.state.frame)));
        }
        let missing = || SceneError::one(Problem::new("the scene has no `[world]`"), &sources);
        let world = root.table("world").ok_or_else(missing)?;
        let (settings, frames, seed) = (root::settings(world), world.int("frames"), world.int("seed"));
        let output = root.table("output").map(root::output).unwrap_or_default();
        Ok(Scene { settings, frames, seed, output, root, sources, begun, imports })
    }

    /// Another seed: other random numbers.
    pub fn override_seed(&mut self, seed: u64) {
        self.seed = seed;
        self.set("seed", Value::Int(seed));
    }

    /// Another number of frames.
    pub fn override_frames(&mut self, frames: u64) {
        self.frames = frames;
        self.set("frames", Value::Int(frames));
    }

    /// Another solver.
    pub fn override_solver(&mut self, solver: Solver) {
        self.settings.solver = solver;
        self.set("solver", Value::Text(root::solver_word(solver).to_owned()));
    }

    /// Another number of sub-steps.
    pub fn override_substeps(&mut self, substeps: u32) {
        self.settings.substeps = substeps;
        self.set("substeps", Value::Int(substeps.into()));
    }

    /// Positions on disk may be off by so much, metres: from 1e-6 to 1000.
    pub fn override_position_error(&mut self, bound: f64) {
        self.output.position_error = Some(bound);
        load::edit(&mut self.root, "output", |output| output.set("position_error", Value::Number(bound)));
    }

    /// Rotations on disk may be off by so much, degrees: from 0.0075 to 20.
    pub fn override_rotation_error(&mut self, bound: f64) {
        self.output.rotation_error = Some(bound);
        load::edit(&mut self.root, "output", |output| output.set("rotation_error", Value::Number(bound)));
    }

    fn set(&mut self, key: &'static str, value: Value) {
        load::edit(&mut self.root, "world", |world| world.set(key, value));
    }

    /// What files of other programs hold and the scene can't have, and what was taken for something else: a line for each, with its file. Also, where it
    /// starts with a frame that is not there to the bit, which one that is.
    pub fn notes(&self) -> Vec<String> {
        let begun = self.begun.as_ref().and_then(|begun| begun.note());
        begun.into_iter().chain(import::notes(&self.root, &self.imports)).collect()
    }

    /// Its cameras, in the order of the file.
    pub fn cameras(&self) -> Vec<SceneCamera> {
        cameras::cameras(&self.root)
    }

    /// Bodies, those included that will be poured.
    pub fn body_count(&self) -> u64 {
        self.estimate().bodies
    }

    /// What the scene will need, without building it.
    pub fn estimate(&self) -> Estimate {
        let (bodies, shapes) =
            self.begun.as_ref().map_or((0, 0), |begun| (begun.bodies.len(), begun.shapes.len()));
        memory::estimate(&self.root, &self.imports, bodies as u64, shapes as u64)
    }

    /// The frame of another run that the scene starts with. A run of the scene has to keep it ([`Start::write`]) beside its `scene.toml`.
    pub fn start(&self) -> Option<&Start> {
        self.begun.as_ref().map(|begun| &begun.start)
    }

    /// Names of all materials, those of the run that the scene starts with last.
    pub fn materials(&self) -> Vec<String> {
        let own = import::materials(&self.root, &self.imports).into_iter().map(|(name, _)| name);
        let former = self.begun.iter().flat_map(|begun| &begun.materials).map(|former| former.name.clone());
        own.chain(former).collect()
    }

    /// The scene as TOML with every default filled in, includes resolved and paths absolute. Generators stay
    /// generators. It reads back as an equal scene.
    pub fn to_toml_filled(&self) -> String {
        write::scene(&self.root)
    }

    /// Id, name, shape, scale, kind and material of every body, those included that will be poured. [`Running::body_table`] has the
    /// same for a scene that is being built anyway.
    ///
    /// # Errors
    /// As for [`Scene::build`].
    pub fn body_table(&self) -> Result<Vec<BodyRow>, SceneError> {
        Ok(self.plan()?.rows)
    }

    /// What bodies look like: all shapes cooked, and who has which. For programs that show a run and don't simulate it; the memory that a
    /// world would need is not asked for.
    ///
    /// # Errors
    /// Geometry that can't be cooked, a fill that does not fit.
    pub fn inventory(&self) -> Result<Inventory, SceneError> {
        let plan = self.plan_within(None)?;
        let of_shapes: Vec<Vec3> = plan.shapes.iter().map(center).collect();
        let center = |(k, body): (usize, &BodyRow)| match body.kind {
            Kind::Dynamic => {
                let own = plan.templates[plan.template_of(k) as usize].mass.and_then(|mass| mass.center);
                own.unwrap_or(of_shapes[body.shape])
            }
            Kind::Kinematic | Kind::Static => Vec3::ZERO,
        };
        let centers = plan.rows.iter().enumerate().map(center).collect();
        let Plan { shapes, visuals, colors, rows: bodies, .. } = plan;
        Ok(Inventory { shapes, visuals, materials: self.materials(), colors, bodies, centers })
    }

    /// How the scene's `decomposition` shapes are cut, and how far the hulls are from the meshes. Cuts them, which may take seconds.
    ///
    /// # Errors
    /// A mesh that can't be read or cut.
    pub fn cuts(&self) -> Result<Vec<Cut>, SceneError> {
        cuts(&self.root, self.seed).map_err(|p| SceneError::one(p, &self.sources))
    }

    /// Cooks the shapes, places the bodies and sets up the world.
    ///
    /// # Errors
    /// A scene that needs more memory than there is, geometry that can't be cooked, a fill that does not fit.
    pub fn build(&self) -> Result<Running, SceneError> {
        let plan = self.plan()?;
        Running::new(self.settings, plan).map_err(|e| {
            SceneError::one(Problem::new(format!("the world refused the scene: {e}")), &self.sources)
        })
    }

    /// Looks for everything that could go wrong in [`Scene::build`], short of the world itself, on a machine with
    /// `memory` bytes to spare; `None` for no limit.
    ///
    /// # Errors
    /// As for [`Scene::build`].
    pub fn check_within(&self, memory: Option<u64>) -> Result<(), SceneError> {
        self.plan_within(memory).map(|_| ())
    }

    pub(crate) fn plan(&self) -> Result<Plan, SceneError> {
        self.plan_within(memory::available())
    }

    pub(crate) fn plan_within(&self, available: Option<u64>) -> Result<Plan, SceneError> {
        let Estimate { bodies, memory, .. } = self.estimate();
        if let Some(available) = available.filter(|&a| memory > a) {
            let message = format!(
                "{bodies} bodies need about {} of memory, and {} are free",
                memory::human(memory),
                memory::human(available)
            );
            let problem = match memory::largest(&self.root) {
                Some(generator) => Problem::at(generator.span, message),
                None => Problem::new(message),
            };
            return Err(SceneError::one(problem.expecting("fewer bodies"), &self.sources));
        }
        plan(&self.root, &self.imports, self.seed, self.begun.as_deref())
            .map_err(|p| SceneError::one(p, &self.sources))
    }
}
