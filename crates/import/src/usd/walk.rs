//! The way through a stage, from the top down: which prims are bodies, and which colliders belong to them.

use super::collider::{Meshes, form};
use super::filter::Filters;
use super::material::Materials;
use super::units::Units;
use super::values::{flag, number, said, vector};
use super::{body, instancer, known, xform};
use crate::affine::Affine;
use crate::build::{Builder, Collider, Draft};
use crate::content::{Body, Content, Kind, Weight};
use openusd::usd::{Prim, PrimStatus, Stage};

/// Prims in prims; what is deeper is no scene but a mistake.
const DEEPEST: usize = 500;
/// Prims of a stage, those of instances counted one by one. References in references can make very many out of a small file.
const MOST_PRIMS: usize = 1 << 24;
/// Bodies of a stage; instancers in prototypes of instancers can make very many out of a small file.
pub(super) const MOST_BODIES: usize = 1 << 26;

/// What is gathered on the way.
pub(super) struct Walk<'a> {
    stage: &'a Stage,
    pub(super) units: Units,
    pub(super) builder: Builder,
    meshes: Meshes,
    materials: Materials,
    filters: Filters,
    /// How many of type PhysicsScene there are.
    scenes: usize,
    prims: usize,
    /// Instancers that the way leads through.
    pub(super) instancers: Vec<String>,
}

/// Where the way has come to.
#[derive(Clone, Copy)]
struct Here<'p> {
    /// What the prim lies in, to the world.
    parent: &'p Affine,
    /// The world as the stage has it: where a prim lies that resets its stack.
    root: &'p Affine,
    depth: usize,
}

impl<'a> Walk<'a> {
    pub(super) fn new(stage: &'a Stage, units: Units, builder: Builder) -> Self {
        Walk {
            stage,
            units,
            builder,
            meshes: Meshes::default(),
            materials: Materials::default(),
            filters: Filters::default(),
            scenes: 0,
            prims: 0,
            instancers: Vec::new(),
        }
    }

    /// Bodies of the whole stage. Their groups are numbers for [`Walk::finish`] until then.
    pub(super) fn whole(&mut self, place: &Affine) -> Result<Vec<Body>, String> {
        let root = self.units.root(place);
        let mut bodies = Vec::new();
        for name in self.stage.root_prims().map_err(said)? {
            let prim = self.stage.prim(format!("/{}", name.as_str()).as_str());
            self.below(&prim, &root, &mut bodies)?;
        }
        Ok(bodies)
    }

    /// Bodies of a prim and all below it, `root` being what it lies in.
    pub(super) fn below(&mut self, prim: &Prim, root: &Affine, bodies: &mut Vec<Body>) -> Result<(), String> {
        self.visit(prim, Here { parent: root, root, depth: 0 }, None, bodies)
    }

    /// Puts the groups of filters in their places.
    pub(super) fn finish(mut self, mut bodies: Vec<Body>) -> Result<Content, String> {
        if self.scenes > 1 {
            self.builder.note("there is more than one PhysicsScene: gravity is that of the first", "");
        }
        let bits = self.filters.bits(&mut self.builder);
        for body in &mut bodies {
            (body.group, body.mask) = bits[body.group as usize];
        }
        Ok(self.builder.finish(bodies))
    }

    /// Looks at a prim and all below it; `owner` is the rigid body that it belongs to.
    fn visit(
        &mut self,
        prim: &Prim,
        here: Here<'_>,
        mut owner: Option<&mut Draft>,
        bodies: &mut Vec<Body>,
    ) -> Result<(), String> {
        let name = prim.path().as_str();
        self.prims += 1;
        if here.depth > DEEPEST {
            return Err(format!("{name} is more than {DEEPEST} prims deep"));
        }
        if self.prims > MOST_PRIMS || bodies.len() > MOST_BODIES {
            return Err(format!("it unfolds to more than {MOST_PRIMS} prims, or {MOST_BODIES} bodies"));
        }
        let status = self.stage.prim_status(prim.path().clone()).map_err(said)?;
        // Prototypes of instancers are often hidden from the stage as classes, or below prims that are not defined.
        let shown = status.contains(PrimStatus::DEFINED) && !status.contains(PrimStatus::ABSTRACT);
        if !status.contains(PrimStatus::ACTIVE | PrimStatus::LOADED) || (!shown && self.instancers.is_empty())
        {
            return Ok(());
        }
        let kind = prim.type_name().map_err(said)?;
        let kind = kind.as_ref().map_or("", |kind| kind.as_str());
        match kind {
            "PhysicsScene" => self.scene(prim)?,
            "PhysicsCollisionGroup" => self.filters.group(prim, &mut self.builder)?,
            _ => {}
        }
        if known::unsupported(prim, &mut self.builder)? {
            return Ok(());
        }
        let local = xform::local(prim)?;
        if local.animated {
            self.builder.note("a prim that moves in time stands where it is at first", name);
        }
        if let Some(operation) = &local.unknown {
            self.builder.note(format!("`{operation}` is not supported"), name);
        }
        let parent = if local.resets { here.root } else { here.parent };
        let place = parent.after(&local.map);
        let below = Here { parent: &place, root: here.root, depth: here.depth + 1 };
        if kind == "PointInstancer" {
            if let Some(owner) = owner {
                self.builder.note("an instancer in a rigid body makes bodies of its own", &owner.name);
            }
            return instancer::read(self, prim, &place, bodies);
        }
        let has = |schema: &str| prim.has_api_schema(schema).map_err(said);
        if has("PhysicsFilteredPairsAPI")? {
            self.filters.pairs(prim)?;
        }
        if has("PhysicsRigidBodyAPI")? && flag(prim, "physics:rigidBodyEnabled", true)? {
            if let Some(owner) = owner.as_deref()
                && !local.resets
            {
                self.builder.note("a rigid body in another one is a body of its own", &owner.name);
            }
            let mut draft = body::draft(prim, &place, parent, &self.units, &mut self.builder)?;
            self.collider(prim, &place, &mut Some(&mut draft), bodies)?;
            for child in prim.children().map_err(said)? {
                self.visit(&child, below, Some(&mut draft), bodies)?;
            }
            self.add(draft, bodies);
            return Ok(());
        }
        self.collider(prim, &place, &mut owner, bodies)?;
        if has("PhysicsMassAPI")? && !has("PhysicsCollisionAPI")? {
            self.builder.note("a mass of what is neither a body nor a collider is left out", name);
        }
        for child in prim.children().map_err(said)? {
            self.visit(&child, below, owner.as_deref_mut(), bodies)?;
        }
        Ok(())
    }

    /// Adds a prim that is a collider to its body, or as a body that nobody moves.
    fn collider(
        &mut self,
        prim: &Prim,
        place: &Affine,
        owner: &mut Option<&mut Draft>,
        bodies: &mut Vec<Body>,
    ) -> Result<(), String> {
        let is_collider = prim.has_api_schema("PhysicsCollisionAPI").map_err(said)?;
        if !is_collider || !flag(prim, "physics:collisionEnabled", true)? {
            return Ok(());
        }
        let Some((form, inner)) = form(prim, &mut self.meshes, &mut self.builder)? else { return Ok(()) };
        let material = self.materials.of(prim, &self.units, &mut self.builder)?;
        let name = prim.path().as_str().to_owned();
        // The mass of a prim that is body and collider is the body's.
        let own = owner.as_ref().is_some_and(|draft| draft.name == name);
        let weight = if own { None } else { body::weight(prim, &self.units)? };
        // Of the densities that there are that of the collider comes first, then that of its body, then that of its material.
        let density =
            owner.as_ref().and_then(|draft| draft.density).or(material.and_then(|(_, density)| density));
        let weight = weight.or(density.map(|d| Weight::Density(d as f32)));
        let place = place.after(&inner);
        let material = material.map(|(material, _)| material);
        let collider = Collider { name, form, place, material, weight };
        match owner {
            Some(draft) => draft.colliders.push(collider),
            None => {
                let mut draft = Draft::new(collider.name.clone(), Kind::Static, place);
                draft.colliders.push(collider);
                self.add(draft, bodies);
            }
        }
        Ok(())
    }

    fn add(&mut self, mut draft: Draft, bodies: &mut Vec<Body>) {
        let colliders = draft.colliders.iter().map(|collider| collider.name.as_str());
        draft.group = self.filters.body(&draft.name, colliders);
        bodies.extend(self.builder.body(&draft));
    }

    /// Gravity: downwards and that of the earth where the stage does not say.
    fn scene(&mut self, prim: &Prim) -> Result<(), String> {
        self.scenes += 1;
        let direction = vector(prim, "physics:gravityDirection")?.unwrap_or_default();
        let magnitude = number(prim, "physics:gravityMagnitude")?.unwrap_or(-1.0);
        let direction = direction.try_normalize().unwrap_or(-self.units.up);
        // Without a unit of the stage's: what it would be in metres.
        let metres = if magnitude < 0.0 { 9.81 } else { magnitude * self.units.metre };
        let gravity = self.units.turn * direction * metres;
        if !gravity.is_finite() {
            return Err(format!("{}: its gravity is not finite", prim.path().as_str()));
        }
        self.builder.gravity(gravity);
        Ok(())
    }
}
