//! The world: bodies, shapes, materials, and `step()`.

mod change;
mod check;
pub(crate) mod query;
mod read;
mod snapshot;
mod spawn;
mod step;
mod watch;

pub use change::Spring;

use crate::bodies::{Bodies, State};
use crate::events::{Events, Watch};
use crate::index::Index;
use crate::link::Islands;
use crate::measure::Sums;
use crate::slots::Slots;
use crate::touch::Fresh;
use crate::touches::Touches;
use crate::{BodyId, Error, Material, Settings, Shape, StepReport};
use query::late::Late;
use read::Sorted;
use rockfall_math::lanes::Width;
use rockfall_math::{DVec3, Quat, Vec3};
use rockfall_shape::MassProperties;
use rockfall_solve::Contacts;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::sync::{Arc, Mutex, OnceLock};

/// A shape of a [`World`], shared by any number of bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ShapeId(pub(crate) u32);

/// A material of a [`World`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct MaterialId(pub(crate) u32);

impl ShapeId {
    /// Shapes are numbered from 0 in the order in which they were added.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

impl MaterialId {
    /// Materials are numbered from 0 in the order in which they were added.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// One contact point, in the world's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The body with the normal's tail.
    pub a: BodyId,
    /// The body that the normal points into.
    pub b: BodyId,
    /// Half-way between the surfaces at the start of the step, metres.
    pub position: DVec3,
    /// Unit vector from `a` to `b`.
    pub normal: Vec3,
    /// Signed distance at the start of the step, metres; negative where the bodies overlapped.
    pub distance: f32,
    /// Normal impulse in the last sub-step, N s; times the rate of the sub-steps it is a force.
    pub impulse: f32,
    /// Impulse of friction on `b` in the last sub-step, in the world's axes, N s. The solver has one for all points of a manifold: each has the share of
    /// it that it has of the normal impulse.
    pub friction: Vec3,
}

/// Bodies, shapes, materials, and the state that goes on from one step to the next.
///
/// ```
/// use rockfall::math::{DVec3, Pose, Vec3};
/// use rockfall::{Body, Material, Settings, Shape, World};
///
/// let mut world = World::new(Settings::default())?;
/// let rock = world.add_material(Material::default())?;
/// let ground = world.add_shape(Shape::HalfSpace { normal: Vec3::Z, offset: 0.0 })?;
/// let ball = world.add_shape(Shape::Sphere { radius: 0.5 })?;
/// world.spawn(Body::fixed(ground, rock, Pose::default()))?;
/// let id = world.spawn(Body::new(ball, rock, Pose::at(DVec3::new(0.0, 0.0, 3.0))))?;
/// for _ in 0..120 {
///     world.step();
/// }
/// let pose = world.pose(id).expect("the ball is still there");
/// assert!((pose.position.z - 0.5).abs() < 1e-3);
/// for contact in world.contacts() {
///     println!("{:?} {:?} {} m", contact.position, contact.normal, contact.distance);
/// }
/// # Ok::<(), rockfall::Error>(())
/// ```
#[derive(Debug)]
pub struct World {
    settings: Settings,
    width: Width,
    pool: Arc<rayon::ThreadPool>,
    shapes: Vec<Shape>,
    /// Mass properties of hulls at 1 kg/m³, by shape; those of others are found quickly.
    masses: BTreeMap<usize, MassProperties>,
    materials: Vec<Material>,
    /// Hash of settings, shapes and materials; made when a state is saved or loaded.
    fingerprint: OnceLock<u64>,
    bodies: Bodies,
    /// Slots by id, of bodies that are alive.
    slots: Slots,
    /// Row of each slot.
    rows: Vec<u32>,
    /// Slots of bodies that were removed, for others.
    vacant: Vec<u32>,
    /// Bodies that are alive, sorted by id; made when somebody asks.
    sorted: OnceLock<Sorted>,
    names: HashMap<u64, String>,
    next_id: u64,
    /// Rows at the end that the last step did not see.
    fresh: usize,
    /// Rows of bodies that were put somewhere else since the last step.
    stirred: BTreeSet<u32>,
    /// Whether the caller has changed anything since the last step.
    handled: bool,
    /// Rows that the last step took out of their boxes; found when somebody asks.
    drifted: OnceLock<Vec<u32>>,
    /// These and all rows that changed since; found when somebody asks.
    late: OnceLock<Late>,
    index: Index,
    touches: Touches,
    contacts: Contacts,
    islands: Islands,
    moved: Vec<bool>,
    /// How each row was turned when the step began.
    starts: Vec<Quat>,
    sums: Vec<Sums>,
    rooms: Vec<Mutex<Fresh>>,
    report: StepReport,
    watch: Watch,
    events: Events,
    /// Masks of sensors, by id.
    sensors: BTreeMap<u64, u32>,
}

impl World {
    /// An empty world.
    ///
    /// # Errors
    /// [`Error::Setting`] names the first setting that is out of range; [`Error::Threads`].
    pub fn new(settings: Settings) -> Result<Self, Error> {
        settings.check()?;
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(settings.threads)
            .thread_name(|i| format!("rockfall-{i}"))
            .build()
            .map_err(|error| Error::Threads { threads: settings.threads, reason: error.to_string() })?;
        Ok(World {
            settings,
            width: Width::new(settings.lanes),
            pool: Arc::new(pool),
            shapes: Vec::new(),
            masses: BTreeMap::new(),
            materials: Vec::new(),
            fingerprint: OnceLock::new(),
            bodies: Bodies::new(),
            slots: Slots::default(),
            rows: Vec::new(),
            vacant: Vec::new(),
            sorted: OnceLock::new(),
            names: HashMap::new(),
            next_id: 1,
            fresh: 0,
            stirred: BTreeSet::new(),
            handled: true,
            drifted: OnceLock::new(),
            late: OnceLock::new(),
            index: Index::default(),
            touches: Touches::default(),
            contacts: Contacts::default(),
            islands: Islands::default(),
            moved: Vec::new(),
            starts: Vec::new(),
            sums: Vec::new(),
            rooms: Vec::new(),
            report: StepReport::default(),
            watch: Watch::default(),
            events: Events::default(),
            sensors: BTreeMap::new(),
        })
    }

    /// The settings, as given.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Adds a shape.
    ///
    /// # Errors
    /// [`Error::Shape`] says what is wrong with it.
    pub fn add_shape(&mut self, shape: Shape) -> Result<ShapeId, Error> {
        shape.validate()?;
        let polyhedron =
            matches!(shape, Shape::Hull(_) | Shape::RoundedHull { .. } | Shape::Field(_) | Shape::Mesh(_));
        if let (true, Some(mass)) = (polyhedron, shape.mass_properties(1.0)) {
            self.masses.insert(self.shapes.len(), mass);
        }
        self.shapes.push(shape);
        self.fingerprint.take();
        Ok(ShapeId(self.shapes.len() as u32 - 1))
    }

    /// Adds a material.
    ///
    /// # Errors
    /// [`Error::Value`] where a number is out of range.
    pub fn add_material(&mut self, material: Material) -> Result<MaterialId, Error> {
        material.check()?;
        self.materials.push(material);
        self.fingerprint.take();
        Ok(MaterialId(self.materials.len() as u32 - 1))
    }

    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.slots.len()
    }

    /// Whether there is no body.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn row(&self, id: BodyId) -> Result<usize, Error> {
        self.slots.get(id.0).map(|slot| self.rows[slot as usize] as usize).ok_or(Error::NoBody(id))
    }

    fn wake(&mut self, row: usize) {
        if self.bodies.states[row] == State::Asleep {
            self.bodies.states[row] = State::Awake;
        }
        self.bodies.rests[row] = 0.0;
    }
}
