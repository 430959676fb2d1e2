//! What a surface is made of, and how two surfaces mix.

/// A material. Friction and restitution are those of the report: `friction` is μ_T, `restitution` μ_N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// kg/m³, positive.
    pub density: f32,
    /// 0 stops dead, 1 bounces back to the start; within [0, 1].
    pub restitution: f32,
    /// Coulomb's coefficient, not negative.
    pub friction: f32,
    /// Coefficient of rolling friction: the torque against rolling is at most this length (m) times the normal force.
    pub rolling_friction: f32,
    /// Coefficient of twisting (spinning) friction: the torque about the normal is at most this length (m) times
    /// the normal force.
    pub twisting_friction: f32,
    /// How friction of two materials mixes. Of two different rules the later in the list of [`Mix`] wins.
    pub friction_mix: Mix,
    /// How restitution of two materials mixes.
    pub restitution_mix: Mix,
}

impl Default for Material {
    /// Rock on rock.
    fn default() -> Self {
        Material {
            density: 2600.0,
            restitution: 0.0,
            friction: 0.6,
            rolling_friction: 0.0,
            twisting_friction: 0.0,
            friction_mix: Mix::GeometricMean,
            restitution_mix: Mix::Maximum,
        }
    }
}

/// The rule that makes one coefficient of two.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Mix {
    /// (a + b) / 2.
    Average,
    /// The square root of a · b.
    #[default]
    GeometricMean,
    /// The smaller one.
    Minimum,
    /// a · b.
    Product,
    /// The larger one.
    Maximum,
}

impl Mix {
    /// Mixes two coefficients by the later of the two rules.
    pub fn mix(self, other: Mix, a: f32, b: f32) -> f32 {
        match self.max(other) {
            Mix::Average => 0.5 * (a + b),
            Mix::GeometricMean => (a * b).sqrt(),
            Mix::Minimum => a.min(b),
            Mix::Product => a * b,
            Mix::Maximum => a.max(b),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_rule_is_its_formula_and_symmetric() {
        for (rule, expected) in [
            (Mix::Average, 0.5),
            (Mix::GeometricMean, 0.4),
            (Mix::Minimum, 0.2),
            (Mix::Product, 0.16),
            (Mix::Maximum, 0.8),
        ] {
            assert!((rule.mix(rule, 0.2, 0.8) - expected).abs() < 1e-6);
            assert_eq!(rule.mix(rule, 0.2, 0.8), rule.mix(rule, 0.8, 0.2));
        }
        assert_eq!(Mix::Average.mix(Mix::Maximum, 0.2, 0.8), 0.8);
    }
}
