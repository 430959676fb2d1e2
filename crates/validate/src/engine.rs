//! The engines, behind one face: what a case asks of them.

#[cfg(feature = "peers")]
mod box3d;
// Written in C++, behind an interface of C.
#[cfg(feature = "jolt")]
#[allow(unsafe_code)]
mod jolt;
#[cfg(feature = "physx")]
#[allow(unsafe_code)]
mod physx;
#[cfg(feature = "peers")]
mod rapier;
mod rockfall;

use crate::Error;
#[cfg(any(feature = "peers", feature = "physx"))]
use ::rockfall::math::rotation;
use ::rockfall::math::{DVec3, Pose, Vec3};
use ::rockfall::{Integrator, Kind, Mix, Quality, Settings, Shape, Solver};
use serde::Serialize;

/// Which engine.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum EngineName {
    /// Rockfall's default solver.
    SoftStep,
    /// Rockfall's solver with one impulse per contact point.
    Impulse,
    /// Rockfall's solver that mirrors velocities.
    Reflect,
    /// Rapier, where it is built: the feature `peers`.
    Rapier,
    /// Box3D, likewise.
    Box3d,
    /// Jolt, where it is built: the feature `jolt`.
    Jolt,
    /// PhysX, where it is built: the feature `physx`.
    Physx,
}

/// Rockfall's three solvers, and peers.
pub(crate) const ALL: &[EngineName] = &EngineName::ALL;

/// Those that know friction and restitution: `reflect` knows neither.
pub(crate) const WITH_FRICTION: &[EngineName] = &[
    EngineName::SoftStep,
    EngineName::Impulse,
    EngineName::Rapier,
    EngineName::Box3d,
    EngineName::Jolt,
    EngineName::Physx,
];

/// Those with Coulomb's law in impacts: `impulse` has another one.
pub(crate) const WITH_COULOMB: &[EngineName] =
    &[EngineName::SoftStep, EngineName::Rapier, EngineName::Box3d, EngineName::Jolt, EngineName::Physx];

/// The default solver alone: the others don't claim what the case is about, or don't tell their forces.
pub(crate) const DEFAULT: &[EngineName] = &[EngineName::SoftStep];

impl EngineName {
    /// All.
    pub const ALL: [EngineName; 7] = [
        EngineName::SoftStep,
        EngineName::Impulse,
        EngineName::Reflect,
        EngineName::Rapier,
        EngineName::Box3d,
        EngineName::Jolt,
        EngineName::Physx,
    ];

    /// Those that this build has.
    pub fn built() -> Vec<EngineName> {
        let has = |name: &EngineName| match name {
            EngineName::SoftStep | EngineName::Impulse | EngineName::Reflect => true,
            EngineName::Rapier | EngineName::Box3d => cfg!(feature = "peers"),
            EngineName::Jolt => cfg!(feature = "jolt"),
            EngineName::Physx => cfg!(feature = "physx"),
        };
        EngineName::ALL.into_iter().filter(has).collect()
    }

    /// Whether it is not one of Rockfall's.
    pub(crate) fn is_peer(self) -> bool {
        !matches!(self, EngineName::SoftStep | EngineName::Impulse | EngineName::Reflect)
    }

    /// As on the command line.
    pub fn name(self) -> &'static str {
        match self {
            EngineName::SoftStep => "soft-step",
            EngineName::Impulse => "impulse",
            EngineName::Reflect => "reflect",
            EngineName::Rapier => "rapier",
            EngineName::Box3d => "box3d",
            EngineName::Jolt => "jolt",
            EngineName::Physx => "physx",
        }
    }

    /// The engine without bodies.
    pub(crate) fn build(self, terms: &Terms) -> Result<Box<dyn Engine>, Error> {
        let solver = match self {
            EngineName::SoftStep => Solver::SoftStep,
            EngineName::Impulse => Solver::Impulse,
            EngineName::Reflect => Solver::Reflect,
            #[cfg(feature = "peers")]
            EngineName::Rapier => return Ok(Box::new(rapier::Rapier::new(terms))),
            #[cfg(feature = "peers")]
            EngineName::Box3d => return Ok(Box::new(box3d::Box3d::new(terms)?)),
            #[cfg(not(feature = "peers"))]
            EngineName::Rapier | EngineName::Box3d => {
                return Err(Error::NotBuilt { engine: self.name(), feature: "peers" });
            }
            #[cfg(feature = "jolt")]
            EngineName::Jolt => return Ok(Box::new(jolt::Jolt::new(terms)?)),
            #[cfg(not(feature = "jolt"))]
            EngineName::Jolt => return Err(Error::NotBuilt { engine: self.name(), feature: "jolt" }),
            #[cfg(feature = "physx")]
            EngineName::Physx => return Ok(Box::new(physx::Physx::new(terms)?)),
            #[cfg(not(feature = "physx"))]
            EngineName::Physx => return Err(Error::NotBuilt { engine: self.name(), feature: "physx" }),
        };
        Ok(Box::new(rockfall::Rockfall::new(solver, terms)?))
    }
}

/// What holds for a whole run. All else is as an engine comes, but nobody sleeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Terms {
    /// m/s².
    pub(crate) gravity: Vec3,
    /// Steps per second.
    pub(crate) rate: f32,
    /// Sub-steps in a step.
    pub(crate) substeps: u32,
    /// Contacts that close faster than this bounce, m/s.
    pub(crate) threshold: f32,
    /// Sweeps of restitution, at most, in Rockfall.
    pub(crate) sweeps: u32,
    /// How bodies fly, in Rockfall.
    pub(crate) integrator: Integrator,
    /// Natural frequency of Rockfall's contacts, Hz.
    pub(crate) hertz: f32,
    /// Threads, 0 for as many as the machine has.
    pub(crate) threads: usize,
}

impl Terms {
    /// The steps of most published set-ups: 1 ms without sub-steps, standard gravity, one thread.
    pub(crate) const FINE: Terms = Terms {
        gravity: Vec3::new(0.0, 0.0, -9.81),
        rate: 1000.0,
        substeps: 1,
        threshold: 1.0,
        sweeps: 1,
        integrator: Integrator::SecondOrder,
        hertz: 60.0,
        threads: 1,
    };

    /// Rockfall's defaults: 60 steps a second in four sub-steps.
    pub(crate) const FRAMES: Terms = Terms { rate: 60.0, substeps: 4, ..Terms::FINE };

    /// Rockfall's defaults at a quality.
    pub(crate) fn of(quality: Quality) -> Terms {
        let settings = Settings::of(quality);
        let Settings { substeps, contact_hertz: hertz, bounce_sweeps: sweeps, integrator, .. } = settings;
        Terms { substeps, hertz, sweeps, integrator, ..Terms::FRAMES }
    }

    /// Length of a step, s.
    pub(crate) fn dt(&self) -> f64 {
        f64::from(1.0 / self.rate)
    }

    /// Steps in so many seconds.
    pub(crate) fn steps_in(&self, seconds: f64) -> usize {
        (seconds * f64::from(self.rate)).round() as usize
    }

    /// m/s², how strong gravity is.
    pub(crate) fn g(&self) -> f64 {
        f64::from(self.gravity.length())
    }
}

/// How a thing rubs and bounces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Surface {
    /// Coulomb's coefficient.
    pub(crate) friction: f32,
    /// Coefficient of restitution.
    pub(crate) restitution: f32,
    /// Rolling and twisting friction, m.
    pub(crate) rolling: f32,
    pub(crate) twisting: f32,
    /// How friction of two things mixes; restitution is the larger one.
    pub(crate) mix: Mix,
}

impl Surface {
    /// Friction and restitution. Of two the larger counts.
    pub(crate) const fn new(friction: f32, restitution: f32) -> Self {
        Surface { friction, restitution, rolling: 0.0, twisting: 0.0, mix: Mix::Maximum }
    }
}

/// Something to be put into an engine, of 1000 kg/m³ unless its mass is said.
#[derive(Clone, Debug)]
pub(crate) struct Thing {
    pub(crate) shape: Shape,
    pub(crate) surface: Surface,
    pub(crate) kind: Kind,
    /// Of the shape's frame.
    pub(crate) pose: Pose,
    /// Of the centre of mass, m/s.
    pub(crate) velocity: Vec3,
    /// rad/s, world axes.
    pub(crate) spin: Vec3,
    /// kg.
    pub(crate) mass: Option<f32>,
    /// Principal moments about the shape's axes, kg m²; those of the shape with `mass` where `None`.
    pub(crate) moments: Option<Vec3>,
}

/// kg/m³.
pub(crate) const DENSITY: f32 = 1000.0;

impl Thing {
    /// At rest, at a place.
    pub(crate) fn new(shape: Shape, surface: Surface, position: DVec3) -> Self {
        Thing {
            shape,
            surface,
            kind: Kind::Dynamic,
            pose: Pose::at(position),
            velocity: Vec3::ZERO,
            spin: Vec3::ZERO,
            mass: None,
            moments: None,
        }
    }

    /// Nobody moves it.
    pub(crate) fn fixed(self) -> Self {
        Thing { kind: Kind::Static, ..self }
    }

    /// It moves as it is told.
    pub(crate) fn driven(self) -> Self {
        Thing { kind: Kind::Kinematic, ..self }
    }

    /// Another pose.
    pub(crate) fn pose(self, pose: Pose) -> Self {
        Thing { pose, ..self }
    }

    /// kg.
    pub(crate) fn mass(self, mass: f32) -> Self {
        Thing { mass: Some(mass), ..self }
    }

    /// Its velocities.
    pub(crate) fn moving(self, velocity: Vec3, spin: Vec3) -> Self {
        Thing { velocity, spin, ..self }
    }
}

/// An engine with bodies, which are numbered from 0 in the order in which they come.
pub(crate) trait Engine {
    fn put(&mut self, thing: &Thing) -> Result<(), Error>;

    fn step(&mut self) -> Result<(), Error>;

    /// Of the shape's frame.
    fn pose(&self, body: usize) -> Result<Pose, Error>;

    /// Of the centre of mass, m/s, and rad/s about the world's axes.
    fn velocity(&self, body: usize) -> Result<(Vec3, Vec3), Error>;

    fn set_velocity(&mut self, body: usize, velocity: Vec3, spin: Vec3) -> Result<(), Error>;

    /// An impulse, N s, at the centre of mass.
    fn push(&mut self, body: usize, impulse: Vec3) -> Result<(), Error>;

    /// Sum of the normal forces of all contacts of a body at the end of the last step, on the body, N; `None` where the engine does
    /// not tell.
    fn load(&self, body: usize) -> Option<DVec3>;
}

/// A pose that is given in the frame of another one.
#[cfg(any(feature = "peers", feature = "physx"))]
fn within(outer: &Pose, inner: &Pose) -> Pose {
    let position = outer.point(inner.position.as_vec3());
    Pose { position, rotation: rotation::compose(outer.rotation, inner.rotation) }
}

#[cfg(test)]
mod tests;
