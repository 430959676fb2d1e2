//! Ranges of what a caller may say.

use crate::{Body, Error, Material, Settings};
use rockfall_math::{Pose, Vec3};

/// Refuses `value` with a sentence unless it is in its range.
fn value(what: &'static str, value: impl ToString, good: bool, expected: &'static str) -> Result<(), Error> {
    if good { Ok(()) } else { Err(Error::Value { what, value: value.to_string(), expected }) }
}

fn finite(what: &'static str, v: Vec3) -> Result<(), Error> {
    value(what, v, v.is_finite(), "three finite numbers")
}

fn not_negative(what: &'static str, x: f32) -> Result<(), Error> {
    value(what, x, x.is_finite() && x >= 0.0, "a finite number, 0 or larger")
}

impl Settings {
    /// Whether every setting is in its range.
    ///
    /// # Errors
    /// [`Error::Setting`] names the first that is not.
    pub fn check(&self) -> Result<(), Error> {
        let check = |name, value: String, good: bool, expected| {
            if good { Ok(()) } else { Err(Error::Setting { name, value, expected }) }
        };
        let positive =
            |name, x: f32| check(name, x.to_string(), x.is_finite() && x > 0.0, "a positive number");
        let not_negative = |name, x: f32| {
            check(name, x.to_string(), x.is_finite() && x >= 0.0, "a finite number, 0 or larger")
        };
        check("gravity", self.gravity.to_string(), self.gravity.is_finite(), "three finite numbers")?;
        positive("rate", self.rate)?;
        check("substeps", self.substeps.to_string(), (1..=10_000).contains(&self.substeps), "1 to 10000")?;
        positive("contact_hertz", self.contact_hertz)?;
        not_negative("contact_damping", self.contact_damping)?;
        positive("push_speed", self.push_speed)?;
        not_negative("restitution_threshold", self.restitution_threshold)?;
        let sweeps = self.bounce_sweeps;
        check("bounce_sweeps", sweeps.to_string(), (1..=10_000).contains(&sweeps), "1 to 10000")?;
        not_negative("sleep_speed", self.sleep_speed)?;
        not_negative("sleep_time", self.sleep_time)?;
        check("threads", self.threads.to_string(), self.threads <= 4096, "0 (all) to 4096")?;
        check(
            "lanes",
            self.lanes.to_string(),
            [0, 1, 4, 8, 16].contains(&self.lanes),
            "0 (widest), 1, 4, 8 or 16",
        )
    }
}

impl Material {
    pub(crate) fn check(&self) -> Result<(), Error> {
        value("density", self.density, self.density.is_finite() && self.density > 0.0, "a positive number")?;
        let restitution = self.restitution;
        value("restitution", restitution, (0.0..=1.0).contains(&restitution), "a number from 0 to 1")?;
        not_negative("friction", self.friction)?;
        not_negative("rolling friction", self.rolling_friction)?;
        not_negative("twisting friction", self.twisting_friction)
    }
}

/// Poses beyond this lose the millimetre even in double precision, metres.
const FARTHEST: f64 = 1e12;

impl Body {
    pub(crate) fn check_pose(pose: &Pose) -> Result<(), Error> {
        let p = pose.position;
        let near = p.is_finite() && p.abs().max_element() <= FARTHEST;
        value("position", p, near, "three numbers within 1e12 m of the origin")?;
        let q = pose.rotation;
        let length = q.length();
        value("rotation", q, (length - 1.0).abs() < 1e-2, "a quaternion of length 1")
    }

    pub(crate) fn check(&self) -> Result<(), Error> {
        Body::check_pose(&self.pose)?;
        finite("velocity", self.velocity)?;
        finite("angular velocity", self.angular_velocity)?;
        value("gravity scale", self.gravity_scale, self.gravity_scale.is_finite(), "a finite number")?;
        not_negative("linear damping", self.linear_damping)?;
        not_negative("angular damping", self.angular_damping)
    }
}
