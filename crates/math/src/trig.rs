//! Trigonometry in software: the platform's own differs in the last bit from one C library to the next.

/// Sine and cosine of an angle in radians.
#[inline]
pub fn sin_cos(x: f32) -> (f32, f32) {
    libm::sincosf(x)
}

/// Sine of an angle in radians.
#[inline]
pub fn sin(x: f32) -> f32 {
    libm::sinf(x)
}

/// Cosine of an angle in radians.
#[inline]
pub fn cos(x: f32) -> f32 {
    libm::cosf(x)
}

/// Arc cosine in radians, of `x` clamped to [-1, 1].
#[inline]
pub fn acos(x: f32) -> f32 {
    libm::acosf(x.clamp(-1.0, 1.0))
}

/// Angle of the point (x, y) in radians, in (-π, π].
#[inline]
pub fn atan2(y: f32, x: f32) -> f32 {
    libm::atan2f(y, x)
}

/// Angle of the point (x, y) in radians, in (-π, π], in double precision.
#[inline]
pub fn atan2_double(y: f64, x: f64) -> f64 {
    libm::atan2(y, x)
}

/// e to the power of `x`.
#[inline]
pub fn exp(x: f32) -> f32 {
    libm::expf(x)
}

/// Natural logarithm.
#[inline]
pub fn ln(x: f32) -> f32 {
    libm::logf(x)
}

/// `x` to the power of `y`.
#[inline]
pub fn pow(x: f32, y: f32) -> f32 {
    libm::powf(x, y)
}

/// Cube root.
#[inline]
pub fn cbrt(x: f32) -> f32 {
    libm::cbrtf(x)
}

#[cfg(test)]
mod tests {
    #[test]
    fn known_bits() {
        assert_eq!(super::sin(1.0).to_bits(), 0x3f57_6aa4);
        assert_eq!(super::cos(1.0).to_bits(), 0x3f0a_5140);
    }
}
