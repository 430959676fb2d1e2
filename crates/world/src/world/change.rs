//! What holds for the whole world, changed between two steps.

use super::{MaterialId, World};
use crate::bodies::State;
use crate::{BodyId, Error, Kind, Material, Settings};
use rockfall_math::{DVec3, Mat3, Vec3, rotation};
use std::f32::consts::TAU;

/// A spring between a point of a body and a point of the world; see [`World::pull`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// The point of the body, in the frame of its shape, metres.
    pub at: Vec3,
    /// Where it is pulled to, metres.
    pub to: DVec3,
    /// How often it would swing in a second without damping, for whatever resists at the point.
    pub hertz: f32,
    /// Damping ratio: it swings below 1, and creeps above.
    pub damping: f32,
    /// The largest force, N.
    pub most: f32,
}

impl World {
    /// Other settings from the next step on, which wake every body. The number of threads and of lanes stays what it was.
    ///
    /// # Errors
    /// [`Error::Setting`] names the first setting that is out of range; nothing is changed then.
    ///
    /// # Examples
    /// ```
    /// use rockfall::math::Vec3;
    /// use rockfall::{Settings, World};
    ///
    /// let mut world = World::new(Settings::default())?;
    /// let moon = Settings { gravity: Vec3::new(0.0, 0.0, -1.62), ..*world.settings() };
    /// world.set_settings(moon)?;
    /// assert_eq!(world.settings().gravity.z, -1.62);
    /// # Ok::<(), rockfall::Error>(())
    /// ```
    pub fn set_settings(&mut self, settings: Settings) -> Result<(), Error> {
        settings.check()?;
        let Settings { threads, lanes, .. } = self.settings;
        self.settings = Settings { threads, lanes, ..settings };
        self.fingerprint.take();
        self.handled = true;
        (1..self.bodies.rows()).for_each(|row| self.wake(row));
        Ok(())
    }

    /// A material, as it is now.
    ///
    /// # Errors
    /// [`Error::Unknown`].
    pub fn material(&self, id: MaterialId) -> Result<Material, Error> {
        self.materials.get(id.index()).copied().ok_or(Error::Unknown { what: "material", index: id.0 })
    }

    /// Another surface for all bodies of a material from the next step on; it wakes them and what they touch. Mass stays what it was: the density is that
    /// with which bodies were added.
    ///
    /// # Errors
    /// [`Error::Unknown`]; [`Error::Value`] where a number is out of range.
    pub fn set_material(&mut self, id: MaterialId, material: Material) -> Result<(), Error> {
        material.check()?;
        self.material(id)?;
        self.materials[id.index()] = material;
        self.fingerprint.take();
        for row in 1..self.bodies.rows() {
            if self.bodies.materials[row] == id.0 && self.bodies.states[row] != State::Dead {
                self.wake(row);
                // Its contacts are found anew, with the new surface and the impulses that they have.
                self.stirred.insert(row as u32);
            }
        }
        self.late.take();
        Ok(())
    }

    /// Pulls a point of a dynamic body towards a point of the world for one step, and wakes it. The spring is made for what the body resists with at that
    /// point, so that it feels the same for a pebble and for a boulder; it is implicit in time, and stable however stiff it is (Catto, "Soft Constraints",
    /// GDC 2011). To be called before each step for as long as it is held. Bodies that are not dynamic stay as they are.
    ///
    /// # Errors
    /// [`Error::NoBody`]; [`Error::Value`] for numbers that are not finite, and a frequency or a force that is not positive.
    ///
    /// # Examples
    /// ```
    /// use rockfall::math::{DVec3, Pose, Vec3};
    /// use rockfall::{Body, Material, Settings, Shape, Spring, World};
    ///
    /// let mut world = World::new(Settings { gravity: Vec3::ZERO, ..Settings::default() })?;
    /// let rock = world.add_material(Material::default())?;
    /// let ball = world.add_shape(Shape::Sphere { radius: 0.5 })?;
    /// let ball = world.spawn(Body::new(ball, rock, Pose::default()))?;
    /// let to = DVec3::new(2.0, 0.0, 0.0);
    /// for _ in 0..60 {
    ///     world.pull(ball, &Spring { at: Vec3::ZERO, to, hertz: 3.0, damping: 1.0, most: 1e6 })?;
    ///     world.step();
    /// }
    /// assert!((world.pose(ball)?.position - to).length() < 1e-3);
    /// # Ok::<(), rockfall::Error>(())
    /// ```
    pub fn pull(&mut self, id: BodyId, spring: &Spring) -> Result<(), Error> {
        let row = self.row(id)?;
        spring.check()?;
        if self.bodies.kinds[row] != Kind::Dynamic {
            return Ok(());
        }
        let arm = rotation::rotate(self.bodies.rotations[row], spring.at - self.bodies.centers[row]);
        let place = self.bodies.positions[row] + arm.as_dvec3();
        let line = &self.bodies.lines[row];
        let velocity = line.velocity() + line.angular_velocity().cross(arm);
        // How fast the point gets by a unit impulse at it: the report's K, of one body.
        let across = Mat3::from_cols(Vec3::X.cross(arm), Vec3::Y.cross(arm), Vec3::Z.cross(arm));
        let turning = across.transpose() * self.bodies.world_inverse_inertia(row) * across;
        let gives = Mat3::from_diagonal(Vec3::splat(line.inverse_mass())) + turning;
        // v' = v - h (ω² x' + 2 ζ ω v'), x' = x + h v'.
        let h = 1.0 / self.settings.rate;
        let omega = TAU * spring.hertz;
        let stiff = h * omega * omega;
        let slows = h * (2.0 * spring.damping * omega + stiff);
        let error = (place - spring.to).as_vec3();
        let change = -(error * stiff + velocity * slows) / (1.0 + slows);
        // Where the body can't be moved at all there is no inverse.
        let impulse =
            Some(gives.inverse() * change).filter(|impulse| impulse.is_finite()).unwrap_or_default();
        self.push(id, impulse.clamp_length_max(spring.most * h), place)
    }
}

impl Spring {
    fn check(&self) -> Result<(), Error> {
        let Spring { at, to, hertz, damping, most } = *self;
        let positive = |x: f32| x.is_finite() && x > 0.0;
        for (what, good, value, expected) in [
            ("point of the body", at.is_finite(), at.to_string(), "three finite numbers"),
            ("point to pull to", to.is_finite(), to.to_string(), "three finite numbers"),
            ("frequency of a spring", positive(hertz), hertz.to_string(), "a positive number"),
            (
                "damping of a spring",
                damping.is_finite() && damping >= 0.0,
                damping.to_string(),
                "a number, 0 or larger",
            ),
            ("largest force of a spring", positive(most), most.to_string(), "a positive number"),
        ] {
            if !good {
                return Err(Error::Value { what, value, expected });
            }
        }
        Ok(())
    }
}
