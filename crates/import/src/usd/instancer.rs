//! `PointInstancer`: a body for each instance of a prototype that is a rigid body, our extension of UsdPhysics, which knows none.
//!
//! A prototype is read once for each scale that it has, and its bodies are put where the instances are.

use super::values::{integers, quaternions, radians, said, targets, vectors};
use super::walk::{MOST_BODIES, Walk};
use crate::affine::{Affine, Frame, unit};
use crate::build::spin;
use crate::content::{Body, Kind};
use openusd::sdf::Value;
use openusd::usd::Prim;
use rockfall_math::{DMat3, DQuat, DVec3, Pose, Vec3};
use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

/// What the arrays of an instancer say.
struct Instances {
    /// Indices of prototypes that are there.
    prototypes: Vec<usize>,
    positions: Vec<Vec3>,
    rotations: Vec<DQuat>,
    scales: Vec<Vec3>,
    velocities: Vec<Vec3>,
    spins: Vec<Vec3>,
    /// Names of the instances; they are numbered where there are none.
    ids: Vec<i64>,
    /// Those that are not there.
    absent: BTreeSet<i64>,
}

/// Adds the bodies of all instances; `place` takes the instancer to the world.
pub(super) fn read(
    walk: &mut Walk<'_>,
    prim: &Prim,
    place: &Affine,
    bodies: &mut Vec<Body>,
) -> Result<(), String> {
    let name = prim.path().as_str().to_owned();
    if walk.instancers.contains(&name) {
        return Err(format!("{name} is a prototype of its own"));
    }
    let prototypes: Vec<Prim> =
        targets(prim, "prototypes")?.into_iter().map(|path| prim.stage().prim(path)).collect();
    let instances = Instances::read(walk, prim, prototypes.len())?;
    let Some(frame) = place.frame() else {
        walk.builder.note("an instancer that is scaled to nothing is left out", &name);
        return Ok(());
    };
    // In the instancer's frame its scale comes last. One that is the same in all directions may as well come first, so that rotations don't matter.
    let stretch = frame.see(place).linear;
    let even = stretch == DMat3::from_diagonal(DVec3::splat(stretch.x_axis.x));
    walk.instancers.push(name.clone());
    let mut known: BTreeMap<(usize, [u64; 9]), Vec<Body>> = BTreeMap::new();
    for (k, &prototype) in instances.prototypes.iter().enumerate() {
        let id = instances.ids.get(k).copied().unwrap_or(k as i64);
        if instances.absent.contains(&id) {
            continue;
        }
        let at = |all: &[Vec3]| all.get(k).copied().unwrap_or_default().as_dvec3();
        let scale = instances.scales.get(k).map_or(DVec3::ONE, |s| s.as_dvec3());
        let rotation = unit(instances.rotations.get(k).copied().unwrap_or(DQuat::IDENTITY));
        // Where the instance is, and how its prototype is stretched there.
        let frame = frame.after(&Frame { position: stretch * at(&instances.positions), rotation });
        let turn = if even { DMat3::IDENTITY } else { DMat3::from_quat(rotation) };
        let linear = turn.transpose() * stretch * turn * DMat3::from_diagonal(scale);
        let key = (prototype, linear.to_cols_array().map(f64::to_bits));
        let root = &prototypes[prototype];
        if let Entry::Vacant(entry) = known.entry(key) {
            let mut made = Vec::new();
            walk.below(root, &Affine::linear(linear), &mut made)?;
            if made.is_empty() {
                walk.builder.note("a prototype in which there is no body is left out", root.path().as_str());
            }
            entry.insert(made);
        }
        let velocity = instances.velocities.get(k).map(|v| place.linear * v.as_dvec3());
        let spin = instances.spins.get(k).map(|w| spin(place, radians(w.as_dvec3())));
        for made in &known[&key] {
            let inside = made.name.strip_prefix(root.path().as_str()).unwrap_or(&made.name);
            let moves = made.kind != Kind::Static;
            bodies.push(Body {
                name: format!("{name}[{id}]{inside}"),
                pose: placed(&frame, &made.pose),
                velocity: velocity.filter(|_| moves).unwrap_or_else(|| frame.turn(made.velocity)),
                angular_velocity: spin.filter(|_| moves).unwrap_or_else(|| frame.turn(made.angular_velocity)),
                ..made.clone()
            });
        }
        if bodies.len() > MOST_BODIES {
            return Err(format!("it unfolds to more than {MOST_BODIES} bodies"));
        }
    }
    walk.instancers.pop();
    Ok(())
}

/// A pose in a frame.
fn placed(frame: &Frame, pose: &Pose) -> Pose {
    let [x, y, z, w] = pose.rotation.to_array().map(f64::from);
    let inner = Frame { position: pose.position, rotation: DQuat::from_xyzw(x, y, z, w) };
    crate::build::pose(&frame.after(&inner))
}

impl Instances {
    fn read(walk: &mut Walk<'_>, prim: &Prim, prototypes: usize) -> Result<Self, String> {
        let name = prim.path().as_str();
        let which = integers(prim, "protoIndices")?;
        let count = which.len();
        let wrong = |index: &i64| {
            format!("{name}: `protoIndices` has {index}, expected indices of {prototypes} prototypes")
        };
        let index = |i: &i64| usize::try_from(*i).ok().filter(|&i| i < prototypes).ok_or_else(|| wrong(i));
        let precise = quaternions(prim, "orientationsf")?;
        let instances = Instances {
            prototypes: which.iter().map(index).collect::<Result<_, String>>()?,
            positions: vectors(prim, "positions")?,
            rotations: if precise.is_empty() { quaternions(prim, "orientations")? } else { precise },
            scales: vectors(prim, "scales")?,
            velocities: vectors(prim, "velocities")?,
            spins: vectors(prim, "angularVelocities")?,
            ids: integers(prim, "ids")?,
            absent: BTreeSet::new(),
        };
        let lengths = [
            ("positions", instances.positions.len(), true),
            ("orientations", instances.rotations.len(), false),
            ("scales", instances.scales.len(), false),
            ("velocities", instances.velocities.len(), false),
            ("angularVelocities", instances.spins.len(), false),
            ("ids", instances.ids.len(), false),
        ];
        for (what, found, needed) in lengths {
            if found != count && (needed || found > 0) {
                return Err(format!("{name}: `{what}` has {found} values, expected {count}"));
            }
        }
        let all = [&instances.positions, &instances.scales, &instances.velocities, &instances.spins];
        if let Some(k) = all.iter().find_map(|list| list.iter().position(|v| !v.is_finite())) {
            return Err(format!("{name}: instance {k} has a place, scale or velocity that is not finite"));
        }
        let invisible = integers(prim, "invisibleIds")?;
        if !invisible.is_empty() {
            walk.builder.note(format!("{} invisible instances are left out", invisible.len()), name);
        }
        let inactive = inactive(prim)?;
        Ok(Instances { absent: invisible.into_iter().chain(inactive).collect(), ..instances })
    }
}

/// Instances that are switched off: metadata of the prim, by the strongest layer that has it.
fn inactive(prim: &Prim) -> Result<Vec<i64>, String> {
    for (layer, path) in prim.prim_stack().map_err(said)? {
        let Some(layer) = prim.stage().layer(&layer) else { continue };
        let field = layer.data().try_field(&path, "inactiveIds").map_err(said)?;
        if let Some(Value::Int64ListOp(list)) = field.as_deref() {
            return Ok(list.clone().flatten());
        }
    }
    Ok(Vec::new())
}
