//! Set-ups that the tests of the world share.

#![allow(dead_code)] // Every test file uses another part of it.

use rockfall::math::{DVec3, Pose, Quat, Vec3, rotation, trig};
use rockfall::{Body, BodyId, Material, MaterialId, Settings, Shape, ShapeId, World};

/// Standard gravity of the known answers, m/s².
pub(crate) const G: f32 = 9.81;

/// Steps of 1 ms in one sub-step, nobody sleeps: what the closed forms ask for.
pub(crate) fn fine() -> Settings {
    Settings { rate: 1000.0, substeps: 1, ..frames() }
}

/// 60 frames a second with the default sub-steps, nobody sleeps.
pub(crate) fn frames() -> Settings {
    Settings { sleeping: false, continuous: false, threads: 1, ..Settings::default() }
}

/// A place without rotation.
pub(crate) fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose::at(DVec3::new(x, y, z))
}

/// A material of 1000 kg/m³ with the given friction and restitution.
pub(crate) fn rubs(friction: f32, restitution: f32) -> Material {
    Material { density: 1000.0, friction, restitution, ..Material::default() }
}

/// A world with one material.
pub(crate) struct Stage {
    pub(crate) world: World,
    pub(crate) material: MaterialId,
}

impl Stage {
    pub(crate) fn new(settings: Settings, material: Material) -> Self {
        let mut world = World::new(settings).expect("the settings are in range");
        let material = world.add_material(material).expect("the material is in range");
        Stage { world, material }
    }

    /// The same with the ground z ≤ 0.
    pub(crate) fn on_ground(settings: Settings, material: Material) -> Self {
        let mut stage = Stage::new(settings, material);
        stage.plane(Vec3::Z);
        stage
    }

    /// An immovable plane through the origin.
    pub(crate) fn plane(&mut self, normal: Vec3) -> BodyId {
        let shape = self.shape(Shape::HalfSpace { normal, offset: 0.0 });
        self.put(Body::fixed(shape, self.material, Pose::default()))
    }

    pub(crate) fn shape(&mut self, shape: Shape) -> ShapeId {
        self.world.add_shape(shape).expect("the shape makes sense")
    }

    pub(crate) fn ball(&mut self, radius: f32) -> ShapeId {
        self.shape(Shape::Sphere { radius })
    }

    pub(crate) fn cuboid(&mut self, x: f32, y: f32, z: f32) -> ShapeId {
        self.shape(Shape::Box { half: Vec3::new(x, y, z) })
    }

    pub(crate) fn body(&self, shape: ShapeId, pose: Pose) -> Body {
        Body::new(shape, self.material, pose)
    }

    pub(crate) fn put(&mut self, body: Body) -> BodyId {
        self.world.spawn(body).expect("the body makes sense")
    }

    pub(crate) fn steps(&mut self, n: usize) {
        for _ in 0..n {
            self.world.step();
        }
    }

    pub(crate) fn position(&self, id: BodyId) -> DVec3 {
        self.world.pose(id).expect("the body is there").position
    }

    pub(crate) fn rotation(&self, id: BodyId) -> Quat {
        self.world.pose(id).expect("the body is there").rotation
    }

    /// Linear and angular.
    pub(crate) fn velocity(&self, id: BodyId) -> (Vec3, Vec3) {
        self.world.velocity(id).expect("the body is there")
    }

    pub(crate) fn total_energy(&self) -> f64 {
        let report = self.world.report();
        report.kinetic_energy + report.potential_energy
    }

    /// Nobody is at a place, or moves at a speed, that is no number.
    pub(crate) fn all_finite(&self) -> bool {
        self.world.poses().iter().all(|p| p.position.is_finite() && p.rotation.is_finite())
            && self.world.velocities().iter().all(|(v, w)| v.is_finite() && w.is_finite())
    }
}

/// A slope through the origin that falls by `degrees` towards +x.
pub(crate) struct Slope {
    pub(crate) normal: Vec3,
    /// Downhill, unit.
    pub(crate) down: Vec3,
    /// Takes a body that lies flat to one that lies on the slope.
    pub(crate) rotation: Quat,
}

impl Slope {
    pub(crate) fn new(degrees: f32) -> Self {
        let (sin, cos) = trig::sin_cos(degrees.to_radians());
        let normal = Vec3::new(sin, 0.0, cos);
        Slope { normal, down: Vec3::new(cos, 0.0, -sin), rotation: rotation::between(Vec3::Z, normal) }
    }

    /// On the slope, `height` metres off it.
    pub(crate) fn pose(&self, height: f32) -> Pose {
        Pose { position: (self.normal * height).as_dvec3(), rotation: self.rotation }
    }
}

/// Numbers in [0, 1), the same on every machine.
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 += 1;
        (rockfall::math::hash::mix(self.0) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// In [-1, 1) each.
    pub(crate) fn vector(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next()) * 2.0 - 1.0
    }

    pub(crate) fn rotation(&mut self) -> Quat {
        loop {
            let v = self.vector().extend(self.next() * 2.0 - 1.0);
            if (0.01..1.0).contains(&v.length_squared()) {
                return rotation::normalize(Quat::from_vec4(v.as_vec4()));
            }
        }
    }
}

/// Columns of five bodies each, side by side on the ground: `n` × `n` of them.
pub(crate) fn columns(n: usize, balls: bool) -> Stage {
    let settings = Settings { threads: 2, ..frames() };
    let mut stage = Stage::on_ground(settings, rubs(0.6, 0.0));
    let shape = if balls { stage.ball(0.5) } else { stage.cuboid(0.5, 0.5, 0.5) };
    let bodies: Vec<Body> = (0..n * n * 5)
        .map(|i| {
            let (x, y, z) = (i % n, i / n % n, i / n / n);
            let spread = if balls { 1.0 } else { 1.5 };
            stage.body(shape, at(spread * x as f64, spread * y as f64, 0.5 + z as f64))
        })
        .collect();
    stage.world.spawn_all(bodies).expect("they make sense");
    stage
}
