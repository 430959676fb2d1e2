//! What of a prim has to do with physics and is not made use of: said, never passed over.

use super::values::{said, targets, value};
use crate::build::Builder;
use openusd::sdf::Value;
use openusd::usd::Prim;

/// Schemas whose properties are read, or that say nothing by themselves.
const SCHEMAS: &[&str] = &[
    "PhysicsRigidBodyAPI",
    "PhysicsCollisionAPI",
    "PhysicsMeshCollisionAPI",
    "PhysicsMassAPI",
    "PhysicsMaterialAPI",
    "PhysicsFilteredPairsAPI",
    "PhysxRigidBodyAPI",
    "PhysxCollisionAPI",
    "PhysxMaterialAPI",
    "PhysxSceneAPI",
    "PhysxConvexHullCollisionAPI",
    "PhysxConvexDecompositionCollisionAPI",
    "PhysxTriangleMeshCollisionAPI",
    "PhysxSDFMeshCollisionAPI",
];

/// Properties that are read.
const PROPERTIES: &[&str] = &[
    "physics:rigidBodyEnabled",
    "physics:kinematicEnabled",
    "physics:startsAsleep",
    "physics:velocity",
    "physics:angularVelocity",
    "physics:simulationOwner",
    "physics:collisionEnabled",
    "physics:approximation",
    "physics:mass",
    "physics:density",
    "physics:centerOfMass",
    "physics:diagonalInertia",
    "physics:principalAxes",
    "physics:staticFriction",
    "physics:dynamicFriction",
    "physics:restitution",
    "physics:gravityDirection",
    "physics:gravityMagnitude",
    "physics:filteredPairs",
    "physics:filteredGroups",
    "physics:invertFilteredGroups",
    "physics:mergeGroup",
    "physxRigidBody:disableGravity",
    "physxRigidBody:linearDamping",
    "physxRigidBody:angularDamping",
    "physxMaterial:frictionCombineMode",
    "physxMaterial:restitutionCombineMode",
    "physxConvexDecompositionCollision:maxConvexHulls",
    "physxSDFMeshCollision:sdfResolution",
];

/// Notes what of `prim` is not supported. Returns whether its type is one that physics has and we have not.
pub(super) fn unsupported(prim: &Prim, builder: &mut Builder) -> Result<bool, String> {
    let name = prim.path().as_str();
    let kind = prim.type_name().map_err(said)?;
    let kind = kind.as_ref().map_or("", |kind| kind.as_str());
    let stranger = is_physics(kind) && !matches!(kind, "PhysicsScene" | "PhysicsCollisionGroup");
    if stranger {
        builder.note(format!("{kind} is not supported"), name);
        return Ok(true);
    }
    for schema in prim.api_schemas().map_err(said)? {
        if is_physics(schema.as_str()) && !SCHEMAS.contains(&schema.as_str()) {
            builder.note(format!("{} is not supported", schema.as_str()), name);
        }
    }
    if kind == "GeomSubset" && !targets(prim, "material:binding:physics")?.is_empty() {
        builder.note("a material of a part of a mesh is not supported", name);
    }
    for property in prim.property_names().map_err(said)? {
        let property = property.as_str();
        if property.starts_with("material:binding:collection:physics") {
            builder.note("a material that is bound to a collection is not supported", name);
        }
        let ours = property.starts_with("physics:") || property.starts_with("physx");
        if !ours || PROPERTIES.contains(&property) {
            continue;
        }
        // What is off is as if it were not there.
        if !matches!(value(prim, property)?, Some(Value::Bool(false))) {
            builder.note(format!("`{property}` is not supported"), name);
        }
    }
    Ok(false)
}

fn is_physics(name: &str) -> bool {
    name.starts_with("Physics") || name.starts_with("Physx")
}
