//! Box3D with the settings that it comes with, but for the length of a step, the sub-steps that a set-up asks for, and its restitution threshold; nobody
//! sleeps. Mass and inertia are the same numbers as ours. It has no planes: a half-space is a box of 400 m.

use super::{DENSITY, Engine, Terms, Thing, within};
use crate::Error;
use boxddd::{
    BodyId, BodyType, BoxHull, Capsule, Foundation, Hull, MassData, Matrix3, MeshData, Quat as Turn,
    SurfaceMaterial, Transform, Vec3 as Triple, World,
};
use rockfall::math::{DVec3, Mat3, Pose, Quat, Vec3, rotation};
use rockfall::{Kind, Mix, Shape};

pub(super) struct Box3d {
    world: World,
    foundation: &'static Foundation,
    bodies: Vec<BodyId>,
    /// Places of bodies: those of half-spaces are not ours.
    offsets: Vec<Pose>,
    terms: Terms,
}

/// Half the edge of the box that stands for a half-space, m.
const WIDE: f32 = 200.0;

impl From<boxddd::Error> for Error {
    fn from(error: boxddd::Error) -> Self {
        Error::Peer { engine: "box3d", reason: error.to_string() }
    }
}

impl Box3d {
    pub(super) fn new(terms: &Terms) -> Result<Self, Error> {
        let foundation = Foundation::initialize_default()?;
        let def = foundation.world_def_builder().gravity(terms.gravity.to_array());
        let def = def.restitution_threshold(terms.threshold).enable_sleep(false).build()?;
        let mut world = foundation.create_world(def)?;
        world.set_friction_callback(|a, b| {
            let rule = MIXES[a.user_material_id.max(b.user_material_id) as usize];
            rule.mix(rule, a.coefficient, b.coefficient)
        })?;
        Ok(Box3d { world, foundation, bodies: Vec::new(), offsets: Vec::new(), terms: *terms })
    }

    fn add(&mut self, body: BodyId, shape: &Shape, place: &Pose, thing: &Thing) -> Result<(), Error> {
        let surface = thing.surface;
        let rule = MIXES.iter().position(|mix| *mix == surface.mix).unwrap_or(0);
        let material = SurfaceMaterial {
            friction: surface.friction,
            restitution: surface.restitution,
            user_material_id: rule as u64,
            ..SurfaceMaterial::default()
        };
        let def = self.foundation.shape_def_builder().density(DENSITY).surface_material(material);
        let def = def.build()?;
        let refused = || Error::NoShape { engine: "box3d", shape: shape.name() };
        let at = |p: Vec3| place.point(p).as_vec3().to_array();
        match shape {
            Shape::Sphere { radius } => {
                let ball = boxddd::Sphere::new(at(Vec3::ZERO), *radius);
                self.world.create_sphere_shape(body, &def, &ball)?;
            }
            Shape::Capsule { half_length, radius } => {
                let [lower, upper] = [-*half_length, *half_length].map(|z| at(Vec3::Z * z));
                self.world.create_capsule_shape(body, &def, &Capsule::new(lower, upper, *radius))?;
            }
            Shape::Box { half } => {
                let transform = Transform { p: Triple::from(at(Vec3::ZERO)), q: turn_of(place.rotation) };
                let hull = BoxHull::transformed(half.x, half.y, half.z, transform)?;
                self.world.create_hull_shape(body, &def, &hull)?;
            }
            Shape::HalfSpace { .. } => {
                let hull = BoxHull::new(WIDE, WIDE, WIDE)?;
                self.world.create_hull_shape(body, &def, &hull)?;
            }
            Shape::Hull(hull) => {
                let points: Vec<Triple> = hull.vertices.iter().map(|&v| Triple::from(at(v))).collect();
                let count = i32::try_from(points.len()).map_err(|_| refused())?;
                // It takes so many corners and no more.
                let hull = Hull::from_points(&points, count).map_err(|_| refused())?;
                self.world.create_created_hull_shape(body, &def, &hull)?;
            }
            Shape::Mesh(mesh) if thing.kind == Kind::Static => {
                let vertices: Vec<Triple> = mesh.vertices.iter().map(|&v| Triple::from(at(v))).collect();
                let corners = mesh.triangles.iter().flatten();
                let indices = corners
                    .map(|&i| i32::try_from(i).map_err(|_| refused()))
                    .collect::<Result<Vec<_>, _>>()?;
                let mesh = MeshData::builder(vertices, indices).identify_edges(true).build()?;
                self.world.create_mesh_shape(body, &def, mesh, [1.0, 1.0, 1.0])?;
            }
            Shape::Compound(compound) => {
                for part in compound.parts() {
                    self.add(body, &part.shape, &within(place, &part.pose), thing)?;
                }
            }
            _ => return Err(refused()),
        }
        Ok(())
    }
}

/// In the order in which the later wins.
const MIXES: [Mix; 5] = [Mix::Average, Mix::GeometricMean, Mix::Minimum, Mix::Product, Mix::Maximum];

impl Engine for Box3d {
    fn put(&mut self, thing: &Thing) -> Result<(), Error> {
        let kind = match thing.kind {
            Kind::Dynamic => BodyType::Dynamic,
            Kind::Kinematic => BodyType::Kinematic,
            Kind::Static => BodyType::Static,
        };
        let offset = match &thing.shape {
            Shape::HalfSpace { normal, offset } => Pose {
                position: (*normal * (offset - WIDE)).as_dvec3(),
                rotation: rotation::between(Vec3::Z, *normal),
            },
            _ => Pose::default(),
        };
        let place = within(&thing.pose, &offset);
        let def = self.foundation.body_def_builder().body_type(kind).enable_sleep(false);
        let def = def.position(place.position.as_vec3().to_array()).rotation(turn_of(place.rotation));
        let body = self.world.create_body(def.build()?)?;
        self.add(body, &thing.shape, &Pose::default(), thing)?;
        if let (Some(solid), Kind::Dynamic) = (thing.shape.mass_properties(DENSITY), thing.kind) {
            let solid = thing.mass.map_or(solid, |mass| solid.with_mass(mass));
            let inertia = thing.moments.map_or(solid.inertia, Mat3::from_diagonal);
            let [cx, cy, cz] = inertia.to_cols_array_2d().map(Triple::from);
            let center = Triple::from(solid.center.to_array());
            let inertia = Matrix3 { cx, cy, cz };
            self.world.set_body_mass_data(body, MassData { mass: solid.mass, center, inertia })?;
        }
        self.bodies.push(body);
        self.offsets.push(offset);
        if thing.kind == Kind::Static {
            return Ok(());
        }
        // Of the centre of mass, which it has to know before.
        self.set_velocity(self.bodies.len() - 1, thing.velocity, thing.spin)
    }

    fn step(&mut self) -> Result<(), Error> {
        let substeps = i32::try_from(self.terms.substeps).unwrap_or(i32::MAX);
        Ok(self.world.step(1.0 / self.terms.rate, substeps)?)
    }

    fn pose(&self, body: usize) -> Result<Pose, Error> {
        let place = self.world.body_transform(self.bodies[body])?;
        let (p, q) = (place.p, place.q);
        let position = DVec3::new(f64::from(p.x), f64::from(p.y), f64::from(p.z));
        let offset = &self.offsets[body];
        let turned = Quat::from_xyzw(q.v.x, q.v.y, q.v.z, q.s);
        let rotation = rotation::compose(turned, rotation::inverse(offset.rotation));
        let back = rotation::rotate(rotation, offset.position.as_vec3());
        Ok(Pose { position: position - back.as_dvec3(), rotation })
    }

    fn velocity(&self, body: usize) -> Result<(Vec3, Vec3), Error> {
        let body = self.bodies[body];
        let [v, w] = [self.world.body_linear_velocity(body)?, self.world.body_angular_velocity(body)?];
        Ok((Vec3::new(v.x, v.y, v.z), Vec3::new(w.x, w.y, w.z)))
    }

    fn set_velocity(&mut self, body: usize, velocity: Vec3, spin: Vec3) -> Result<(), Error> {
        let body = self.bodies[body];
        self.world.set_body_linear_velocity(body, velocity.to_array())?;
        Ok(self.world.set_body_angular_velocity(body, spin.to_array())?)
    }

    fn push(&mut self, body: usize, impulse: Vec3) -> Result<(), Error> {
        Ok(self.world.apply_linear_impulse_to_center(self.bodies[body], impulse.to_array(), true)?)
    }

    fn load(&self, _: usize) -> Option<DVec3> {
        None
    }
}

fn turn_of(q: Quat) -> Turn {
    Turn { v: Triple::from([q.x, q.y, q.z]), s: q.w }
}
