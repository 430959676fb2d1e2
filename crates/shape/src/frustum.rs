//! Cylinders, cones and truncated cones: two discs on one axis and all that is between them.

use crate::Shape;
use rockfall_math::{DVec3, Vec3};

/// A cylinder, cone or truncated cone around the z axis, its middle at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frustum {
    /// Half of the height, metres.
    pub half_length: f32,
    /// Radius of the lower end, at z = -`half_length`, metres.
    pub lower: f32,
    /// Radius of the upper end, metres.
    pub upper: f32,
}

impl Frustum {
    /// What a cylinder or a cone is; `None` for other shapes.
    pub fn of(shape: &Shape) -> Option<Frustum> {
        match *shape {
            Shape::Cylinder { half_length, radius } => {
                Some(Frustum { half_length, lower: radius, upper: radius })
            }
            Shape::Cone { half_length, lower, upper } => Some(Frustum { half_length, lower, upper }),
            _ => None,
        }
    }

    /// The larger of both radii.
    pub fn widest(&self) -> f32 {
        if self.lower < self.upper { self.upper } else { self.lower }
    }

    /// The outward normal of the side: its part away from the axis, which is not negative, and its part along z.
    pub fn side(&self) -> (f64, f64) {
        let (height, widens) = (2.0 * f64::from(self.half_length), f64::from(self.upper - self.lower));
        let length = (height * height + widens * widens).sqrt();
        (height / length, -widens / length)
    }

    /// The point that is farthest along `direction`, of any length: on a rim, or the middle of an end along the axis.
    pub fn support(&self, direction: DVec3) -> DVec3 {
        let across = (direction.x * direction.x + direction.y * direction.y).sqrt();
        let (h, lower, upper) = (f64::from(self.half_length), f64::from(self.lower), f64::from(self.upper));
        let high = upper * across + h * direction.z >= lower * across - h * direction.z;
        let (radius, z) = if high { (upper, h) } else { (lower, -h) };
        let share = if across > 0.0 { radius / across } else { 0.0 };
        DVec3::new(share * direction.x, share * direction.y, z)
    }

    /// The largest ball inside: the height of its centre, and its radius. Of several the one nearest to the middle.
    pub fn inner_ball(&self) -> (f32, f32) {
        let h = f64::from(self.half_length);
        let (across, _) = self.side();
        let mean = 0.5 * (f64::from(self.lower) + f64::from(self.upper));
        // Distance from the side at height z towards the wider end: across (mean + slope z).
        let slope = (f64::from(self.upper) - f64::from(self.lower)).abs() / (2.0 * h);
        if across * mean >= h {
            return (0.0, h as f32);
        }
        // Touches the side and the wider end: across (mean + slope z) = h - z.
        let z = (h - across * mean) / (1.0 + across * slope);
        let z = if slope > 0.0 { z } else { 0.0 };
        let radius = across * (mean + slope * z);
        (if self.upper > self.lower { z as f32 } else { -z as f32 }, radius as f32)
    }

    /// Distance from `center` to the farthest point, metres.
    pub(crate) fn radius_about(&self, center: Vec3) -> f32 {
        let aside = center.truncate().length();
        let to_rim = |radius: f32, z: f32| {
            let (across, along) = (aside + radius, center.z - z);
            (across * across + along * along).sqrt()
        };
        to_rim(self.lower, -self.half_length).max(to_rim(self.upper, self.half_length))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distance_to_surface(f: &Frustum, z: f32) -> f32 {
        let (across, _) = f.side();
        let share = 0.5 * (1.0 + z / f.half_length);
        let side = across as f32 * (f.lower + (f.upper - f.lower) * share);
        side.min(f.half_length - z).min(f.half_length + z)
    }

    #[test]
    fn the_inner_ball_touches_and_none_on_the_axis_is_larger() {
        for (half_length, lower, upper) in [
            (1.0, 1.0, 1.0),
            (0.1, 1.0, 1.0),
            (1.0, 0.1, 0.1),
            (1.0, 1.0, 0.0),
            (2.0, 0.0, 0.3),
            (0.5, 3.0, 0.1),
        ] {
            let f = Frustum { half_length, lower, upper };
            let (z, radius) = f.inner_ball();
            assert!((distance_to_surface(&f, z) - radius).abs() < 1e-6, "{f:?} {z} {radius}");
            for k in -100_i8..=100 {
                assert!(
                    distance_to_surface(&f, half_length * f32::from(k) / 100.0) <= radius + 1e-6,
                    "{f:?}"
                );
            }
        }
    }

    #[test]
    fn support_points_by_hand() {
        let cone = Frustum { half_length: 1.0, lower: 2.0, upper: 0.0 };
        assert_eq!(cone.support(DVec3::X), DVec3::new(2.0, 0.0, -1.0));
        assert_eq!(cone.support(DVec3::Z), DVec3::Z);
        assert_eq!(cone.support(-DVec3::Z), -DVec3::Z);
        // The side of this cone is at 45 degrees: a little steeper is the tip, a little flatter the rim.
        assert_eq!(cone.support(DVec3::new(1.0, 0.0, 1.01)), DVec3::Z);
        assert_eq!(cone.support(DVec3::new(0.0, 1.01, 1.0)), DVec3::new(0.0, 2.0, -1.0));
    }
}
