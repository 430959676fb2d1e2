//! Where a picture is taken from.

mod fit;

use rockfall_math::{DVec3, Vec2, trig};

/// A camera: a pinhole, or a thin lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where it is, metres.
    pub eye: DVec3,
    /// What is in the middle of its picture.
    pub target: DVec3,
    /// What is upwards in the picture, as far as the way to the target allows.
    pub up: DVec3,
    /// Vertical field of view, degrees.
    pub fov: f32,
    /// The lens; everything is sharp where there is none.
    pub lens: Option<Lens>,
}

/// A lens that is not small.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lens {
    /// Its diameter, metres.
    pub aperture: f64,
    /// Distance along the line of sight at which things are sharp, metres; at the target where not given.
    pub focus: Option<f64>,
}

/// The axes of a picture of so many pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Frame {
    pub(crate) eye: DVec3,
    right: DVec3,
    up: DVec3,
    pub(crate) forward: DVec3,
    /// Width and height of a pixel at unit distance.
    pub(crate) pixel: f64,
    half: [f64; 2],
}

impl Camera {
    /// Right, up and forward.
    fn axes(&self) -> [DVec3; 3] {
        let forward = (self.target - self.eye).normalize_or(DVec3::Y);
        // Looking straight up or down, any side is up.
        let side = [self.up, DVec3::Y, DVec3::X].map(|up| forward.cross(up));
        let right = side.into_iter().find(|side| side.length_squared() > 1e-12).unwrap_or(DVec3::X);
        let right = right.normalize_or(DVec3::X);
        [right, right.cross(forward), forward]
    }

    /// Half of the height of a picture at unit distance.
    fn half_height(&self) -> f64 {
        let (sin, cos) = trig::sin_cos(0.5 * self.fov.clamp(0.1, 170.0).to_radians());
        f64::from(sin) / f64::from(cos)
    }

    /// The axes for a picture that is moved to the right and downwards by parts of a pixel.
    pub(crate) fn shifted(&self, width: u32, height: u32, shift: [f64; 2]) -> Frame {
        let frame = self.frame(width, height);
        Frame { half: [frame.half[0] - shift[0], frame.half[1] - shift[1]], ..frame }
    }

    pub(crate) fn frame(&self, width: u32, height: u32) -> Frame {
        let [right, up, forward] = self.axes();
        let pixel = 2.0 * self.half_height() / f64::from(height);
        let half = [width, height].map(|n| 0.5 * f64::from(n));
        Frame { eye: self.eye, right, up, forward, pixel, half }
    }

    /// Unit vector through the point (x, y) of a picture of so many pixels; pixels from the left and the top.
    pub fn direction(&self, x: f64, y: f64, width: u32, height: u32) -> DVec3 {
        self.frame(width.max(1), height.max(1)).direction(x, y)
    }

    /// Distance at which things are sharp.
    pub(crate) fn focus(&self) -> f64 {
        self.lens.and_then(|lens| lens.focus).unwrap_or_else(|| (self.target - self.eye).length())
    }

    /// The same camera with its eye at a point of the lens, in units of its radius: what is at the focus stays where it is in the picture.
    pub(crate) fn through(&self, at: Vec2) -> Camera {
        let Some(lens) = self.lens else { return *self };
        let [right, up, forward] = self.axes();
        let moved = 0.5 * lens.aperture * (f64::from(at.x) * right + f64::from(at.y) * up);
        // The plane of the picture turns a little with the view; over the width of a lens that is nothing.
        Camera { eye: self.eye + moved, target: self.eye + self.focus() * forward, up, ..*self }
    }
}

impl Frame {
    /// Unit vector through the point (x, y) of the picture: pixels from the left and the top.
    #[inline]
    pub(crate) fn direction(&self, x: f64, y: f64) -> DVec3 {
        let (a, b) = ((x - self.half[0]) * self.pixel, (self.half[1] - y) * self.pixel);
        (self.forward + a * self.right + b * self.up).normalize()
    }

    /// Where a point of the world is in the picture, pixels from the left and the top, and its distance from the eye; `None` behind the eye.
    pub(crate) fn project(&self, point: DVec3) -> Option<([f64; 2], f64)> {
        let from = point - self.eye;
        let depth = from.dot(self.forward);
        if depth.is_nan() || depth <= 1e-6 * from.length() || depth <= 0.0 {
            return None;
        }
        let scale = 1.0 / (depth * self.pixel);
        let at = [self.half[0] + from.dot(self.right) * scale, self.half[1] - from.dot(self.up) * scale];
        Some((at, from.length()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera {
            eye: DVec3::new(1e6, -3.0, 2.0),
            target: DVec3::new(1e6 + 4.0, 5.0, 1.0),
            up: DVec3::Z,
            fov: 40.0,
            lens: None,
        }
    }

    #[test]
    fn what_a_ray_passes_is_projected_to_its_pixel() {
        let frame = camera().frame(320, 200);
        for (x, y) in [(160.0, 100.0), (0.0, 0.0), (319.5, 10.25), (40.0, 199.0)] {
            let point = frame.eye + 7.0 * frame.direction(x, y);
            let (at, distance) = frame.project(point).expect("it is in front");
            assert!((at[0] - x).abs() < 1e-6 && (at[1] - y).abs() < 1e-6, "{at:?} for {x}, {y}");
            assert!((distance - 7.0).abs() < 1e-6);
        }
        assert!(frame.project(frame.eye - frame.forward).is_none());
    }

    #[test]
    fn the_height_of_the_picture_is_the_field_of_view() {
        let frame = camera().frame(320, 200);
        let angle = frame.direction(160.0, 0.0).dot(frame.direction(160.0, 200.0)).acos();
        assert!((angle.to_degrees() - 40.0).abs() < 1e-4, "{}", angle.to_degrees());
    }

    #[test]
    fn through_any_point_of_the_lens_the_focus_stays_in_place() {
        let lens = Lens { aperture: 0.5, focus: Some(6.0) };
        let camera = Camera { lens: Some(lens), ..camera() };
        let sharp = camera.eye + 6.0 * (camera.target - camera.eye).normalize();
        for at in [Vec2::new(1.0, 0.0), Vec2::new(-0.3, 0.8)] {
            let (pixel, _) = camera.through(at).frame(320, 200).project(sharp).expect("it is in front");
            assert!((pixel[0] - 160.0).abs() < 1e-6 && (pixel[1] - 100.0).abs() < 1e-6, "{pixel:?}");
        }
    }

    #[test]
    fn a_camera_that_looks_straight_down_has_a_side_that_is_up() {
        let down = Camera { eye: DVec3::Z, target: DVec3::ZERO, ..camera() };
        let frame = down.frame(10, 10);
        assert!(frame.direction(0.0, 0.0).is_finite() && (frame.direction(5.0, 5.0).z + 1.0).abs() < 1e-12);
    }
}
