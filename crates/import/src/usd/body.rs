//! Rigid bodies: what `PhysicsRigidBodyAPI` and `PhysicsMassAPI` say of a prim.

use super::units::Units;
use super::values::{flag, number, quaternion, radians, said, value, vector};
use crate::affine::{Affine, unit};
use crate::build::{Builder, Draft, spin};
use crate::content::{Kind, Weight};
use openusd::usd::Prim;
use rockfall_math::{DMat3, DQuat, DVec3};

/// A rigid body without its colliders. `place` takes it to the world, `parent` what it lies in.
pub(super) fn draft(
    prim: &Prim,
    place: &Affine,
    parent: &Affine,
    units: &Units,
    builder: &mut Builder,
) -> Result<Draft, String> {
    let name = prim.path().as_str();
    let kinematic = flag(prim, "physics:kinematicEnabled", false)?;
    let kind = if kinematic { Kind::Kinematic } else { Kind::Dynamic };
    let mut draft = Draft::new(name.to_owned(), kind, *place);
    if flag(prim, "physics:startsAsleep", false)? {
        builder.note("a body that starts asleep starts awake", name);
    }
    if let Some(velocity) = vector(prim, "physics:velocity")? {
        draft.velocity = parent.linear * velocity;
    }
    if let Some(degrees) = vector(prim, "physics:angularVelocity")? {
        draft.angular_velocity = spin(parent, radians(degrees));
    }
    if flag(prim, "physxRigidBody:disableGravity", false)? {
        draft.gravity_scale = 0.0;
    }
    let damping = |name: &str| -> Result<f32, String> { Ok(number(prim, name)?.unwrap_or(0.0) as f32) };
    draft.damping = [damping("physxRigidBody:linearDamping")?, damping("physxRigidBody:angularDamping")?];
    if !(draft.velocity.is_finite() && draft.angular_velocity.is_finite()) {
        return Err(format!("{name}: its velocity is not finite"));
    }
    if prim.has_api_schema("PhysicsMassAPI").map_err(said)? {
        mass(prim, &mut draft, parent, units)?;
    }
    Ok(draft)
}

/// Numbers that say nothing are 0, and minus infinity for the centre of mass.
fn mass(prim: &Prim, draft: &mut Draft, parent: &Affine, units: &Units) -> Result<(), String> {
    draft.mass = positive(prim, "physics:mass")?.map(|m| m * units.mass);
    draft.density = positive(prim, "physics:density")?.map(|d| d * units.density);
    draft.center = vector(prim, "physics:centerOfMass")?.filter(|c| c.is_finite());
    let diagonal = vector(prim, "physics:diagonalInertia")?.filter(|d| *d != DVec3::ZERO);
    if let Some(diagonal) = diagonal {
        if !(diagonal.is_finite() && diagonal.min_element() > 0.0) {
            let name = prim.path().as_str();
            return Err(format!("{name}: `physics:diagonalInertia` is {diagonal}, expected numbers above 0"));
        }
        let axes = quaternion(prim, "physics:principalAxes")?.unwrap_or(DQuat::IDENTITY);
        let turn = DMat3::from_quat(unit(axes));
        // Lengths of the world that the body is in.
        let metre = libm::cbrt(parent.linear.determinant().abs());
        let scale = units.mass * metre * metre;
        draft.inertia = Some(turn * DMat3::from_diagonal(diagonal * scale) * turn.transpose());
    }
    Ok(())
}

/// How heavy a collider is by itself.
pub(super) fn weight(prim: &Prim, units: &Units) -> Result<Option<Weight>, String> {
    if !prim.has_api_schema("PhysicsMassAPI").map_err(said)? {
        return Ok(None);
    }
    let mass = positive(prim, "physics:mass")?.map(|m| Weight::Mass((m * units.mass) as f32));
    let density = positive(prim, "physics:density")?.map(|d| Weight::Density((d * units.density) as f32));
    Ok(mass.or(density))
}

fn positive(prim: &Prim, name: &str) -> Result<Option<f64>, String> {
    let found = number(prim, name)?;
    if found.is_some_and(|x| !(x >= 0.0 && x.is_finite())) {
        let value = value(prim, name)?;
        return Err(format!(
            "{}: `{name}` is {value:?}, expected a number of at least 0",
            prim.path().as_str()
        ));
    }
    Ok(found.filter(|x| *x > 0.0))
}
