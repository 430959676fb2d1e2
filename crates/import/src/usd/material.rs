//! What colliders are made of: the material that is bound to a prim for physics, or to one above it.

use super::units::Units;
use super::values::{number, said, targets, word};
use crate::build::Builder;
use crate::content::{Material, Mix};
use openusd::sdf::Path;
use openusd::tf::Token;
use openusd::usd::{Prim, Stage};
use std::collections::BTreeMap;

/// Materials that have been looked up, by path; none where what is bound has nothing to do with physics.
#[derive(Debug, Default)]
pub(super) struct Materials {
    known: BTreeMap<String, Option<(u32, Option<f64>)>>,
}

/// Bindings for physics come before those for everything.
const BINDINGS: [&str; 2] = ["material:binding:physics", "material:binding"];

impl Materials {
    /// The material of a prim, and its density in kg/m³ where it has one.
    pub(super) fn of(
        &mut self,
        prim: &Prim,
        units: &Units,
        builder: &mut Builder,
    ) -> Result<Option<(u32, Option<f64>)>, String> {
        let Some(path) = bound(prim)? else { return Ok(None) };
        if let Some(known) = self.known.get(path.as_str()) {
            return Ok(*known);
        }
        let material = read(&prim.stage().prim(path.clone()), units, builder)?;
        self.known.insert(path.as_str().to_owned(), material);
        Ok(material)
    }
}

/// The path of what is bound to a prim: by the nearest prim on the way up, but one above that says it is stronger wins.
fn bound(prim: &Prim) -> Result<Option<Path>, String> {
    let stage: &Stage = prim.stage();
    for name in BINDINGS {
        let mut found: Option<Path> = None;
        for path in prim.path().ancestors_below_root() {
            let above = stage.prim(path);
            let Some(target) = targets(&above, name)?.into_iter().next() else { continue };
            let strength = above.attribute(name).get_metadata::<Token>("bindMaterialAs").map_err(said)?;
            let stronger = strength.is_some_and(|s| s.as_str() == "strongerThanDescendants");
            if found.is_none() || stronger {
                found = Some(target);
            }
        }
        if found.is_some() {
            return Ok(found);
        }
    }
    Ok(None)
}

fn read(prim: &Prim, units: &Units, builder: &mut Builder) -> Result<Option<(u32, Option<f64>)>, String> {
    if !prim.has_api_schema("PhysicsMaterialAPI").map_err(said)? {
        return Ok(None);
    }
    let name = prim.path().as_str();
    let (still, sliding) =
        (number(prim, "physics:staticFriction")?, number(prim, "physics:dynamicFriction")?);
    if let (Some(still), Some(sliding)) = (still, sliding)
        && still != sliding
    {
        builder.note("static and dynamic friction differ: the dynamic one is taken for both", name);
    }
    let density = number(prim, "physics:density")?.filter(|d| *d > 0.0).map(|d| d * units.density);
    let mix = |name: &str| -> Result<Mix, String> {
        Ok(match word(prim, name)?.as_deref() {
            Some("min") => Mix::Minimum,
            Some("multiply") => Mix::Product,
            Some("max") => Mix::Maximum,
            _ => Mix::Average,
        })
    };
    let material = Material {
        name: name.to_owned(),
        friction: sliding.or(still).unwrap_or(0.0) as f32,
        restitution: number(prim, "physics:restitution")?.unwrap_or(0.0) as f32,
        density: density.map(|d| d as f32),
        friction_mix: mix("physxMaterial:frictionCombineMode")?,
        restitution_mix: mix("physxMaterial:restitutionCombineMode")?,
    };
    Ok(Some((builder.material(material), density)))
}
