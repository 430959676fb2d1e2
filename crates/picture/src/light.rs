//! Sun, sky and air.
//!
//! Light is in linear red, green and blue; 1 is a white wall in full sun, about.

use rockfall_math::{DVec3, Vec3, trig};

/// Towards the middle of the sun, not of unit length: late morning, in the west of south.
const SUN: Vec3 = Vec3::new(-0.42, -0.62, 0.66);

/// Radius of the sun, radians: three times the real one, so that shadows are soft at the size of a picture.
pub(crate) const SUN_RADIUS: f32 = 0.014;

const SUN_LIGHT: Vec3 = Vec3::new(2.75, 2.45, 2.0);

/// What the sky gives to a surface that faces it, and what the ground gives to one that faces down.
const SKY_LIGHT: Vec3 = Vec3::new(0.52, 0.64, 0.84);
const GROUND_LIGHT: Vec3 = Vec3::new(0.30, 0.27, 0.23);

/// The sky overhead, at the horizon, and below it where there is no ground.
const ZENITH: Vec3 = Vec3::new(0.22, 0.40, 0.74);
const HORIZON: Vec3 = Vec3::new(0.80, 0.87, 0.95);
const BELOW: Vec3 = Vec3::new(0.62, 0.66, 0.70);

/// Share of the sky's light that comes around every corner.
const STRAY: f32 = 0.12;

/// How thick the air is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Air {
    /// Distance from which one e-th of a thing's light comes through, metres; infinite where there is no air.
    pub reach: f64,
}

impl Air {
    /// No air at all.
    pub const NONE: Air = Air { reach: f64::INFINITY };

    /// For a picture of something at a distance, metres: hardly any there, and a horizon that fades.
    pub fn beyond(distance: f64) -> Air {
        Air { reach: 6.5 * distance }
    }

    /// Share of a thing's light that comes through so much air: e to the minus square of the way, which is clear in front and dense behind.
    fn through(&self, distance: f64) -> f32 {
        let way = (distance / self.reach) as f32;
        trig::exp(-(way * way).min(80.0))
    }

    /// A thing seen through the air.
    pub(crate) fn veil(&self, light: Vec3, direction: DVec3, distance: f64) -> Vec3 {
        let through = self.through(distance);
        // Towards the horizon all that is far has the horizon's light.
        light * through + air_light(direction) * (1.0 - through)
    }
}

/// Unit vector towards the middle of the sun.
pub(crate) fn sun() -> Vec3 {
    SUN.normalize()
}

/// How much the air towards the sun is brighter.
fn glow(direction: DVec3) -> f32 {
    let near = direction.as_vec3().dot(sun()).max(0.0);
    let near = near * near;
    near * near
}

fn air_light(direction: DVec3) -> Vec3 {
    HORIZON + Vec3::new(0.16, 0.12, 0.05) * glow(direction)
}

/// The sky in a direction, unit vector.
pub(crate) fn sky(direction: DVec3) -> Vec3 {
    let z = direction.z as f32;
    if z < 0.0 {
        // A little below the horizon it is as above.
        let down = (-6.0 * z).min(1.0);
        return air_light(direction).lerp(BELOW, down * down * (3.0 - 2.0 * down));
    }
    let rest = 1.0 - z.min(1.0);
    let rest = rest * rest;
    let low = rest * rest * rest;
    ZENITH.lerp(air_light(direction), low.max(0.0))
}

/// What a surface sends to the eye: `color` is its share of the light, `sun_seen` and `sky_seen` the shares of sun and sky that it sees.
pub(crate) fn shade(color: Vec3, normal: Vec3, to_eye: Vec3, sun_seen: f32, sky_seen: f32) -> Vec3 {
    let sun = sun();
    let facing = normal.dot(sun).max(0.0);
    let upwards = 0.5 + 0.5 * normal.z;
    let around = GROUND_LIGHT.lerp(SKY_LIGHT, upwards) * (STRAY + (1.0 - STRAY) * sky_seen);
    // A dull gloss (Blinn, "Models of light reflection for computer synthesized pictures", SIGGRAPH 1977), at a grazing view stronger, after Schlick
    // ("An inexpensive BRDF model", Computer Graphics Forum 13, 1994).
    let middle = (sun + to_eye).normalize_or_zero();
    let power = |x: f32, doublings: u32| (0..doublings).fold(x, |x, _| x * x);
    let grazing = 1.0 - to_eye.dot(middle).clamp(0.0, 1.0);
    let mirror = 0.04 + 0.96 * power(grazing, 2) * grazing;
    let gloss = if facing > 0.0 { 4.0 * mirror * power(normal.dot(middle).max(0.0), 5) } else { 0.0 };
    color * (SUN_LIGHT * (facing * sun_seen) + around) + SUN_LIGHT * (gloss * facing * sun_seen)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_far_is_as_bright_as_the_horizon_and_what_is_near_is_clear() {
        let air = Air::beyond(10.0);
        let (direction, red) = (DVec3::Y, Vec3::new(1.0, 0.0, 0.0));
        assert!((air.veil(red, direction, 1e5) - sky(direction)).length() < 1e-6);
        assert!((air.veil(red, direction, 1.0) - red).length() < 0.001);
        assert_eq!(Air::NONE.veil(red, direction, 1e9), red);
    }

    #[test]
    fn the_sky_has_no_step_at_the_horizon() {
        for z in [1e-4, 1e-3] {
            let (above, below) = (DVec3::new(1.0, 0.2, z).normalize(), DVec3::new(1.0, 0.2, -z).normalize());
            assert!((sky(above) - sky(below)).length() < 10.0 * z as f32, "{} {}", sky(above), sky(below));
        }
    }

    #[test]
    fn a_surface_in_shadow_without_sky_is_dark_and_none_gives_back_more_than_it_gets() {
        let (normal, eye) = (Vec3::Z, Vec3::new(0.6, 0.0, 0.8));
        let lit = shade(Vec3::splat(0.5), normal, eye, 1.0, 1.0);
        let dark = shade(Vec3::splat(0.5), normal, eye, 0.0, 0.0);
        assert!(dark.max_element() < 0.1 * lit.min_element(), "{dark} {lit}");
        assert!(lit.cmplt(SUN_LIGHT + SKY_LIGHT).all());
    }
}
