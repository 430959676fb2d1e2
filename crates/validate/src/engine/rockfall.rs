//! Our engine.

use super::{DENSITY, Engine, Surface, Terms, Thing};
use crate::Error;
use rockfall::math::{DVec3, Mat3, Pose, Vec3};
use rockfall::{Body, BodyId, MassOverride, Material, MaterialId, Settings, Shape, ShapeId, Solver, World};

pub(super) struct Rockfall {
    world: World,
    ids: Vec<BodyId>,
    /// The last shape, which the next body often has, too.
    shape: Option<(Shape, ShapeId)>,
    materials: Vec<(Surface, MaterialId)>,
    solver: Solver,
}

impl Rockfall {
    pub(super) fn new(solver: Solver, terms: &Terms) -> Result<Self, Error> {
        let Terms { gravity, rate, substeps, threshold, sweeps, integrator, hertz, threads } = *terms;
        let settings = Settings {
            gravity,
            rate,
            substeps,
            solver,
            restitution_threshold: threshold,
            integrator,
            bounce_sweeps: sweeps,
            contact_hertz: hertz,
            sleeping: false,
            threads,
            ..Settings::default()
        };
        Ok(Rockfall {
            world: World::new(settings)?,
            ids: Vec::new(),
            shape: None,
            materials: Vec::new(),
            solver,
        })
    }

    fn material(&mut self, surface: Surface) -> Result<MaterialId, Error> {
        if let Some((_, id)) = self.materials.iter().find(|(known, _)| *known == surface) {
            return Ok(*id);
        }
        let id = self.world.add_material(Material {
            density: DENSITY,
            friction: surface.friction,
            restitution: surface.restitution,
            rolling_friction: surface.rolling,
            twisting_friction: surface.twisting,
            friction_mix: surface.mix,
            ..Material::default()
        })?;
        self.materials.push((surface, id));
        Ok(id)
    }

    fn shape(&mut self, shape: &Shape) -> Result<ShapeId, Error> {
        if let Some((known, id)) = &self.shape
            && same(known, shape)
        {
            return Ok(*id);
        }
        let id = self.world.add_shape(shape.clone())?;
        self.shape = Some((shape.clone(), id));
        Ok(id)
    }
}

/// Whether two shapes are known to be equal. Two that are not may be.
fn same(a: &Shape, b: &Shape) -> bool {
    match (a, b) {
        (Shape::Sphere { radius: a }, Shape::Sphere { radius: b }) => a == b,
        (Shape::Box { half: a }, Shape::Box { half: b }) => a == b,
        _ => false,
    }
}

impl Engine for Rockfall {
    fn put(&mut self, thing: &Thing) -> Result<(), Error> {
        let (shape, material) = (self.shape(&thing.shape)?, self.material(thing.surface)?);
        let mass = thing.mass.map(|mass| MassOverride {
            mass,
            center: None,
            inertia: thing.moments.map(Mat3::from_diagonal),
        });
        let body = Body {
            kind: thing.kind,
            velocity: thing.velocity,
            angular_velocity: thing.spin,
            mass,
            ..Body::new(shape, material, thing.pose)
        };
        self.ids.push(self.world.spawn(body)?);
        Ok(())
    }

    fn step(&mut self) -> Result<(), Error> {
        self.world.step();
        Ok(())
    }

    fn pose(&self, body: usize) -> Result<Pose, Error> {
        Ok(self.world.pose(self.ids[body])?)
    }

    fn velocity(&self, body: usize) -> Result<(Vec3, Vec3), Error> {
        Ok(self.world.velocity(self.ids[body])?)
    }

    fn set_velocity(&mut self, body: usize, velocity: Vec3, spin: Vec3) -> Result<(), Error> {
        Ok(self.world.set_velocity(self.ids[body], velocity, spin)?)
    }

    fn push(&mut self, body: usize, impulse: Vec3) -> Result<(), Error> {
        let id = self.ids[body];
        let center = self.world.shape(id)?.mass_properties(1.0).map_or(Vec3::ZERO, |mass| mass.center);
        let point = self.world.pose(id)?.point(center);
        Ok(self.world.push(id, impulse, point)?)
    }

    fn load(&self, body: usize) -> Option<DVec3> {
        // The simple solvers keep no impulses.
        if self.solver != Solver::SoftStep {
            return None;
        }
        let id = self.ids[body];
        let settings = self.world.settings();
        let rate = f64::from(settings.rate) * f64::from(settings.substeps);
        let force = |contact: rockfall::Contact| {
            let push = contact.normal.as_dvec3() * f64::from(contact.impulse) * rate;
            if contact.b == id {
                push
            } else if contact.a == id {
                -push
            } else {
                DVec3::ZERO
            }
        };
        Some(self.world.contacts().map(force).sum())
    }
}
