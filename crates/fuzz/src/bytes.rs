//! From bytes to numbers.

use rockfall_math::{Mat3, Quat, Vec3, rotation};

/// Numbers where arithmetic tends to break.
const STRANGE: [f32; 16] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    1e-7,
    -1e-7,
    1e-6,
    1e6,
    0.5,
    1e-20,
    1e20,
    f32::MIN_POSITIVE,
    f32::MAX,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
];

/// Bytes that are read one after the other; behind the last there are zeros.
#[derive(Clone, Copy, Debug)]
pub struct Bytes<'a>(pub &'a [u8]);

impl Bytes<'_> {
    /// Whether all have been read.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The next one.
    pub fn byte(&mut self) -> u8 {
        let Some((&first, rest)) = self.0.split_first() else { return 0 };
        self.0 = rest;
        first
    }

    /// The next four.
    pub fn word(&mut self) -> u32 {
        u32::from_le_bytes(std::array::from_fn(|_| self.byte()))
    }

    /// In [-1, 1].
    pub fn share(&mut self) -> f32 {
        self.word() as f32 / (u32::MAX / 2) as f32 - 1.0
    }

    /// Any number: one with these bits, a strange one, a whole one, or one of ordinary size.
    pub fn number(&mut self) -> f32 {
        match self.byte() % 8 {
            0 => f32::from_bits(self.word()),
            1 => STRANGE[self.byte() as usize % STRANGE.len()],
            2 => f32::from(self.byte() % 4) - 1.0,
            3 => self.share() * 1e-7,
            _ => self.share(),
        }
    }

    /// A length in metres that a shape may have, mostly of ordinary size.
    pub fn length(&mut self) -> f32 {
        match self.byte() % 8 {
            0 => 1e-6,
            1 => 1e6,
            2 => 10.0_f32.powi(i32::from(self.byte() % 13) - 6),
            _ => 0.02 + 0.5 * (self.share() + 1.0),
        }
    }

    /// Three numbers.
    pub fn vector(&mut self) -> Vec3 {
        Vec3::new(self.number(), self.number(), self.number())
    }

    /// Any rotation, often one that puts axes along axes, or nearly so.
    pub fn rotation(&mut self) -> Mat3 {
        let quarters = Vec3::new(f32::from(self.byte() % 4), f32::from(self.byte() % 4), 0.0);
        let turn = |v: Vec3| rotation::from_rotation_vector(v * std::f32::consts::FRAC_PI_2);
        let aligned = rotation::compose(turn(Vec3::X * quarters.x), turn(Vec3::Z * quarters.y));
        let size =
            if self.byte().is_multiple_of(2) { 3.0 } else { 10.0_f32.powi(-i32::from(self.byte() % 9)) };
        let more = Vec3::new(self.share(), self.share(), self.share()) * size;
        let q: Quat = rotation::compose(rotation::from_rotation_vector(more), aligned);
        Mat3::from_quat(rotation::normalize(q))
    }
}
