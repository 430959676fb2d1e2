//! Masses of imported bodies: of their parts, one by one, and of what the file says of the whole.

use super::cook::Cooked;
use rockfall::MassOverride;
use rockfall_import::{Body, Kind, Part, Weight};
use rockfall_math::Pose;
use rockfall_shape::MassProperties;

/// What replaces the mass that a body has by its shape and its material, whose density is `density` kg/m³; none where the file says nothing else.
pub(super) fn of(body: &Body, parts: &[Part], cooked: &Cooked, density: f32) -> Option<MassOverride> {
    if body.kind != Kind::Dynamic || (body.mass.is_default() && parts.iter().all(|p| p.weight.is_none())) {
        return None;
    }
    let weigh = |(part, unit): (&Part, &Option<MassProperties>)| -> Option<(MassProperties, Pose)> {
        let unit = unit.as_ref()?;
        let mass = match part.weight {
            Some(Weight::Mass(mass)) => mass,
            Some(Weight::Density(density)) => unit.mass * density,
            None => unit.mass * density,
        };
        Some((unit.with_mass(mass), part.pose))
    };
    let solids = parts.iter().zip(&cooked.parts).map(weigh).collect::<Option<Vec<_>>>()?;
    let whole = match &solids[..] {
        [(one, _)] => *one,
        all => MassProperties::sum(all),
    };
    let whole = body.mass.mass.map_or(whole, |mass| whole.with_mass(mass));
    Some(MassOverride {
        mass: whole.mass,
        center: Some(body.mass.center.unwrap_or(whole.center)),
        inertia: Some(body.mass.inertia.unwrap_or(whole.inertia)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rockfall::Shape;
    use rockfall_import::Mass;
    use rockfall_math::{DVec3, Mat3, Vec3};

    fn body(mass: Mass) -> Body {
        Body {
            name: String::new(),
            kind: Kind::Dynamic,
            sensor: false,
            shape: 0,
            material: None,
            pose: Pose::default(),
            velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
            gravity_scale: 1.0,
            linear_damping: 0.0,
            angular_damping: 0.0,
            group: 1,
            mask: u32::MAX,
            mass,
        }
    }

    /// Two unit cubes, 2 m apart.
    fn dumbbell(weights: [Option<Weight>; 2]) -> (Vec<Part>, Cooked) {
        let shape = Shape::Box { half: Vec3::splat(0.5) };
        let unit = shape.mass_properties(1.0);
        let part = |x: f64, weight| Part { geometry: 0, pose: Pose::at(DVec3::new(x, 0.0, 0.0)), weight };
        let parts = vec![part(-1.0, weights[0]), part(1.0, weights[1])];
        (parts, Cooked { shape, parts: vec![unit, unit] })
    }

    #[test]
    fn nothing_is_said_where_the_file_says_nothing() {
        let (parts, cooked) = dumbbell([None, None]);
        assert_eq!(of(&body(Mass::default()), &parts, &cooked, 100.0), None);
    }

    #[test]
    fn parts_of_two_weights_turn_about_their_common_centre() {
        let (parts, cooked) = dumbbell([Some(Weight::Mass(3.0)), None]);
        let all = of(&body(Mass::default()), &parts, &cooked, 1.0).unwrap();
        assert_eq!((all.mass, all.center), (4.0, Some(Vec3::new(-0.5, 0.0, 0.0))));
        // A sixth of the mass each, and 3 · 0.5² + 1 · 1.5² about the centre.
        let inertia = all.inertia.unwrap();
        assert!((inertia.x_axis.x - 4.0 / 6.0).abs() < 1e-6);
        assert!((inertia.y_axis.y - (4.0 / 6.0 + 3.0)).abs() < 1e-6);
    }

    #[test]
    fn what_is_said_of_the_whole_wins() {
        let (parts, cooked) = dumbbell([Some(Weight::Density(2.0)), None]);
        let inertia = Some(Mat3::from_diagonal(Vec3::new(1.0, 2.0, 2.5)));
        let mass = Mass { mass: Some(12.0), center: None, inertia };
        let all = of(&body(mass), &parts, &cooked, 1.0).unwrap();
        assert_eq!((all.mass, all.inertia), (12.0, inertia));
        assert!((all.center.unwrap() - Vec3::new(-1.0 / 3.0, 0.0, 0.0)).length() < 1e-6);
    }
}
