//! What cases are written with: an engine with what was put into it.

use crate::Error;
use crate::engine::{DENSITY, Engine, EngineName, Surface, Terms, Thing};
use cpu_time::ProcessTime;
use rockfall::math::{DMat3, DVec3, Mat3, Pose, Quat, Vec3, rotation};
use rockfall::{Kind, Shape};
use std::time::Duration;

/// What a case is run with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rig {
    pub(crate) engine: EngineName,
    /// Little time is allowed: fewer steps, fewer bodies.
    pub(crate) quick: bool,
}

impl Rig {
    /// An engine without bodies.
    pub(crate) fn stage(&self, terms: Terms) -> Result<Stage, Error> {
        let engine = self.engine.build(&terms)?;
        Ok(Stage { engine, terms, bodies: Vec::new(), steps: 0, spent: Duration::ZERO })
    }

    /// The same with the ground z ≤ 0.
    pub(crate) fn on_ground(&self, terms: Terms, surface: Surface) -> Result<Stage, Error> {
        let mut stage = self.stage(terms)?;
        stage.plane(Vec3::Z, surface)?;
        Ok(stage)
    }
}

/// What a dynamic body weighs, known apart from the engine.
#[derive(Clone, Copy, Debug)]
struct Weight {
    mass: f64,
    /// In the shape's frame, metres.
    center: Vec3,
    /// About the centre of mass in the shape's axes, kg m².
    inertia: DMat3,
}

/// An engine with bodies.
pub(crate) struct Stage {
    engine: Box<dyn Engine>,
    pub(crate) terms: Terms,
    /// `None` for what does not move freely.
    bodies: Vec<Option<Weight>>,
    steps: usize,
    /// Processor time of the steps.
    spent: Duration,
}

impl Stage {
    /// Puts a thing there and returns its number.
    pub(crate) fn put(&mut self, thing: &Thing) -> Result<usize, Error> {
        let weight = (thing.kind == Kind::Dynamic).then(|| weight(thing)).flatten();
        self.engine.put(thing)?;
        self.bodies.push(weight);
        Ok(self.bodies.len() - 1)
    }

    /// An immovable plane through the origin.
    pub(crate) fn plane(&mut self, normal: Vec3, surface: Surface) -> Result<usize, Error> {
        self.wall(normal, 0.0, surface)
    }

    /// An immovable plane at `offset` metres along its normal.
    pub(crate) fn wall(&mut self, normal: Vec3, offset: f32, surface: Surface) -> Result<usize, Error> {
        self.put(&Thing::new(Shape::HalfSpace { normal, offset }, surface, DVec3::ZERO).fixed())
    }

    pub(crate) fn step(&mut self) -> Result<(), Error> {
        self.steps += 1;
        let start = ProcessTime::now();
        let done = self.engine.step();
        self.spent += start.elapsed();
        done
    }

    /// Steps for so many seconds.
    pub(crate) fn seconds(&mut self, seconds: f64) -> Result<(), Error> {
        (0..self.terms.steps_in(seconds)).try_for_each(|_| self.step())
    }

    /// Seconds so far.
    pub(crate) fn time(&self) -> f64 {
        self.steps as f64 * self.terms.dt()
    }

    /// Processor time that the steps took so far, all threads of the process together, s. What cases ask between steps does not count.
    pub(crate) fn processor(&self) -> f64 {
        self.spent.as_secs_f64()
    }

    /// Numbers of the bodies that move freely.
    pub(crate) fn movers(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.bodies.len()).filter(|&body| self.bodies[body].is_some())
    }

    pub(crate) fn pose(&self, body: usize) -> Result<Pose, Error> {
        self.engine.pose(body)
    }

    pub(crate) fn position(&self, body: usize) -> Result<DVec3, Error> {
        Ok(self.pose(body)?.position)
    }

    pub(crate) fn rotation(&self, body: usize) -> Result<Quat, Error> {
        Ok(self.pose(body)?.rotation)
    }

    /// m/s, of the centre of mass.
    pub(crate) fn velocity(&self, body: usize) -> Result<DVec3, Error> {
        Ok(self.engine.velocity(body)?.0.as_dvec3())
    }

    /// rad/s about the world's axes.
    pub(crate) fn spin(&self, body: usize) -> Result<DVec3, Error> {
        Ok(self.engine.velocity(body)?.1.as_dvec3())
    }

    pub(crate) fn set_velocity(&mut self, body: usize, velocity: Vec3, spin: Vec3) -> Result<(), Error> {
        self.engine.set_velocity(body, velocity, spin)
    }

    /// An impulse at the centre of mass, N s.
    pub(crate) fn push(&mut self, body: usize, impulse: Vec3) -> Result<(), Error> {
        self.engine.push(body, impulse)
    }

    /// Sum of the normal forces on a body, N, where the engine tells.
    pub(crate) fn load(&self, body: usize) -> Option<DVec3> {
        self.engine.load(body)
    }

    /// kg; 0 of what does not move freely.
    pub(crate) fn mass(&self, body: usize) -> f64 {
        self.bodies[body].map_or(0.0, |weight| weight.mass)
    }

    /// Kinetic energy of a body, J.
    pub(crate) fn kinetic(&self, body: usize) -> Result<f64, Error> {
        let Some(weight) = self.bodies[body] else { return Ok(0.0) };
        let (v, w) = (self.velocity(body)?, self.spin(body)?);
        Ok(0.5 * (weight.mass * v.length_squared() + w.dot(self.spun(body)?)))
    }

    /// Angular momentum of a body about its centre of mass, kg m²/s.
    pub(crate) fn spun(&self, body: usize) -> Result<DVec3, Error> {
        let Some(weight) = self.bodies[body] else { return Ok(DVec3::ZERO) };
        let axes = Mat3::from_quat(self.rotation(body)?).as_dmat3();
        Ok(axes * (weight.inertia * (axes.transpose() * self.spin(body)?)))
    }

    /// Kinetic and potential energy of all bodies, J; the latter is zero at the origin.
    pub(crate) fn energy(&self) -> Result<f64, Error> {
        let gravity = self.terms.gravity.as_dvec3();
        self.movers().try_fold(0.0, |sum, body| {
            let Some(weight) = self.bodies[body] else { return Ok(sum) };
            let height = gravity.dot(self.pose(body)?.point(weight.center));
            Ok(sum + self.kinetic(body)? - weight.mass * height)
        })
    }

    /// Momentum of all bodies, kg m/s.
    pub(crate) fn momentum(&self) -> Result<DVec3, Error> {
        self.movers().try_fold(DVec3::ZERO, |sum, body| Ok(sum + self.velocity(body)? * self.mass(body)))
    }

    /// The largest speed of a body, m/s.
    pub(crate) fn fastest(&self) -> Result<f64, Error> {
        self.movers().try_fold(0.0_f64, |most, body| Ok(most.max(self.velocity(body)?.length())))
    }
}

fn weight(thing: &Thing) -> Option<Weight> {
    let solid = thing.shape.mass_properties(DENSITY)?;
    let solid = thing.mass.map_or(solid, |mass| solid.with_mass(mass));
    let inertia = thing.moments.map_or(solid.inertia, Mat3::from_diagonal);
    Some(Weight { mass: f64::from(solid.mass), center: solid.center, inertia: inertia.as_dmat3() })
}

/// A slope through the origin that falls towards +x.
pub(crate) struct Slope {
    pub(crate) normal: Vec3,
    /// Downhill, unit.
    pub(crate) down: DVec3,
    /// Takes a body that lies flat to one that lies on the slope.
    pub(crate) rotation: Quat,
}

impl Slope {
    /// By its angle, rad.
    pub(crate) fn new(angle: f64) -> Self {
        let (sin, cos) = libm::sincos(angle);
        let normal = DVec3::new(sin, 0.0, cos).as_vec3().normalize();
        Slope { normal, down: DVec3::new(cos, 0.0, -sin), rotation: rotation::between(Vec3::Z, normal) }
    }

    /// Flat on the slope, `height` metres off it.
    pub(crate) fn pose(&self, height: f64) -> Pose {
        Pose { position: self.normal.as_dvec3() * height, rotation: self.rotation }
    }
}

/// A box by its edges, metres.
pub(crate) fn cuboid(x: f32, y: f32, z: f32) -> Shape {
    Shape::Box { half: 0.5 * Vec3::new(x, y, z) }
}

/// A ball by its radius, metres.
pub(crate) fn ball(radius: f32) -> Shape {
    Shape::Sphere { radius }
}

/// A turn about an axis by an angle, rad.
pub(crate) fn turn(axis: Vec3, angle: f64) -> Quat {
    rotation::from_rotation_vector(axis * angle as f32)
}

/// Numbers in [0, 1), the same on every machine.
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 += 1;
        (rockfall::math::hash::mix(self.0) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// In [0, 1) each.
    pub(crate) fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }
}
