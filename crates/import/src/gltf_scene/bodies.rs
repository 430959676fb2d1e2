//! Bodies of a file with physics: nodes with motion, the colliders at and below them, and colliders that belong to no body.

use super::extension::{Geometry, Motion, Physics};
use super::{DEEPEST, local, name, shared};
use crate::affine::{Affine, unit};
use crate::build::{Builder, Collider, Draft, spin};
use crate::content::{Body, Content, Kind};
use crate::form::{Approximation, Form};
use crate::mesh_file::TriangleSoup;
use crate::mesh_file::gltf::{File, Size, roots};
use ::gltf::Node;
use rockfall_math::DMat3;
use std::collections::BTreeMap;
use std::sync::Arc;

/// kg/m³ of bodies without a mass; the extension leaves it open.
const DENSITY: f32 = 1000.0;

/// Bits of groups; the first is for colliders without a filter.
const FILTERS: usize = 31;

struct Walk<'a> {
    file: &'a File,
    physics: &'a Physics,
    builder: Builder,
    /// Triangles of meshes, and what they come to.
    soups: BTreeMap<usize, Arc<TriangleSoup>>,
    size: Size,
    seen: Vec<bool>,
    bodies: Vec<Body>,
}

pub(super) fn read(
    file: &File,
    physics: &Physics,
    root: &Affine,
    builder: Builder,
) -> Result<Content, String> {
    let mut walk = Walk {
        file,
        physics,
        builder,
        soups: BTreeMap::new(),
        size: Size::default(),
        seen: vec![false; file.document.nodes().len()],
        bodies: Vec::new(),
    };
    if physics.filters.len() > FILTERS {
        walk.builder.note(format!("only {FILTERS} collision filters are kept"), "");
    }
    // Last first.
    for node in roots(&file.document).iter().rev() {
        walk.visit(node, root, None, 0)?;
    }
    let mut content = walk.builder.finish(walk.bodies);
    content.density = Some(DENSITY);
    Ok(content)
}

impl Walk<'_> {
    fn visit(
        &mut self,
        node: &Node<'_>,
        parent: &Affine,
        mut owner: Option<&mut Draft>,
        depth: usize,
    ) -> Result<(), String> {
        if std::mem::replace(&mut self.seen[node.index()], true) {
            return Err(shared(node));
        }
        if depth > DEEPEST {
            return Err(format!("node {} is more than {DEEPEST} nodes deep", node.index()));
        }
        let place = parent.after(&local(node));
        let physical = self.physics.nodes.get(node.index()).cloned().unwrap_or_default();
        if let Some(geometry) = &physical.trigger {
            self.trigger(node, geometry, &place, owner.is_some() || physical.motion.is_some())?;
        }
        if physical.joint {
            self.builder.note("a joint is not supported", &name(node));
        }
        if let Some(motion) = &physical.motion {
            if owner.is_some() {
                self.builder.note("a body in another one is a body of its own", &name(node));
            }
            let mut draft = self.draft(node, motion, &place);
            self.collider(node, physical.collider.as_ref(), &place, Some(&mut draft))?;
            for child in node.children() {
                self.visit(&child, &place, Some(&mut draft), depth + 1)?;
            }
            self.bodies.extend(self.builder.body(&draft));
            return Ok(());
        }
        self.collider(node, physical.collider.as_ref(), &place, owner.as_deref_mut())?;
        for child in node.children() {
            self.visit(&child, &place, owner.as_deref_mut(), depth + 1)?;
        }
        Ok(())
    }

    /// A body without its colliders.
    fn draft(&mut self, node: &Node<'_>, motion: &Motion, place: &Affine) -> Draft {
        let kind = if motion.kinematic { Kind::Kinematic } else { Kind::Dynamic };
        let mut draft = Draft::new(name(node), kind, *place);
        if motion.endless {
            self.builder.note(
                "a moment of inertia of 0, which stands for one without end, is not supported",
                &draft.name,
            );
        }
        draft.velocity = place.linear * motion.velocity;
        draft.angular_velocity = spin(place, motion.spin);
        draft.gravity_scale = motion.gravity as f32;
        draft.mass = motion.mass;
        draft.center = motion.center;
        draft.inertia = motion.inertia.map(|(moments, axes)| {
            let turn = DMat3::from_quat(unit(axes));
            turn * DMat3::from_diagonal(moments) * turn.transpose()
        });
        draft
    }

    fn collider(
        &mut self,
        node: &Node<'_>,
        geometry: Option<&Geometry>,
        place: &Affine,
        owner: Option<&mut Draft>,
    ) -> Result<(), String> {
        let Some(geometry) = geometry else { return Ok(()) };
        let Some((form, turn)) = self.form(node, geometry)? else { return Ok(()) };
        let material = match geometry.material {
            None => None,
            Some(index) => {
                let found = self.physics.materials.get(index);
                let missing = || format!("node {}: there is no physics material {index}", node.index());
                Some(self.builder.material(found.ok_or_else(missing)?.clone()))
            }
        };
        let place = place.after(&Affine::linear(turn));
        let collider = Collider { name: name(node), form, place, material, weight: None };
        let bits = self.bits(geometry.filter);
        match owner {
            Some(draft) => {
                if !draft.colliders.is_empty() && (draft.group, draft.mask) != bits {
                    self.builder.note(
                        "a body whose colliders have several filters has that of the first",
                        &draft.name,
                    );
                } else {
                    (draft.group, draft.mask) = bits;
                }
                draft.colliders.push(collider);
            }
            None => {
                let mut draft = Draft::new(collider.name.clone(), Kind::Static, collider.place);
                (draft.group, draft.mask) = bits;
                draft.colliders.push(collider);
                self.bodies.extend(self.builder.body(&draft));
            }
        }
        Ok(())
    }

    /// A sensor that stands where it is; one that goes with a body is noted.
    fn trigger(
        &mut self,
        node: &Node<'_>,
        geometry: &Geometry,
        place: &Affine,
        owned: bool,
    ) -> Result<(), String> {
        if owned {
            self.builder.note("a trigger that moves with a body is not supported", &name(node));
            return Ok(());
        }
        let Some((form, turn)) = self.form(node, geometry)? else { return Ok(()) };
        let form = match form {
            Form::Mesh { soup, as_what: Approximation::Triangles } => {
                self.builder.note("a triangle mesh of a trigger is taken as its convex hull", &name(node));
                Form::Mesh { soup, as_what: Approximation::Hull }
            }
            other => other,
        };
        let place = place.after(&Affine::linear(turn));
        let mut draft = Draft::new(name(node), Kind::Static, place);
        (draft.group, draft.mask) = self.bits(geometry.filter);
        draft.sensor = true;
        draft.colliders.push(Collider { name: name(node), form, place, material: None, weight: None });
        self.bodies.extend(self.builder.body(&draft));
        Ok(())
    }

    /// Group and mask of a filter.
    fn bits(&self, filter: Option<usize>) -> (u32, u32) {
        let kept = |index: &usize| *index < self.physics.filters.len().min(FILTERS);
        let Some(index) = filter.filter(kept) else { return (1, u32::MAX) };
        let own = &self.physics.filters[index];
        let others = self.physics.filters.iter().take(FILTERS).enumerate();
        let apart = others.filter(|(_, other)| !own.meets(other)).fold(0, |bits, (k, _)| bits | 2_u32 << k);
        (2 << index, !apart)
    }

    /// The form of a collider and how it is turned in its node.
    fn form(&mut self, node: &Node<'_>, geometry: &Geometry) -> Result<Option<(Form, DMat3)>, String> {
        let wrong = |what: String| format!("node {}: {what}", node.index());
        if let Some(index) = geometry.shape {
            let shape = self.physics.shapes.get(index);
            let shape = shape.ok_or_else(|| wrong(format!("there is no implicit shape {index}")))?;
            if shape.is_none() {
                self.builder.note(
                    "a shape of an unknown kind, or a capsule with ends of two sizes, is left out",
                    &name(node),
                );
            }
            return Ok(shape.clone());
        }
        let mesh = match (geometry.mesh, geometry.node) {
            (Some(index), _) => self.file.document.meshes().nth(index),
            (None, Some(index)) => self.file.document.nodes().nth(index).and_then(|node| node.mesh()),
            (None, None) => None,
        };
        let mesh = mesh.ok_or_else(|| wrong("its collider has neither a shape nor a mesh".into()))?;
        let soup = match self.soups.get(&mesh.index()) {
            Some(soup) => soup.clone(),
            None => {
                let soup = Arc::new(self.file.soup(&mesh, &mut self.size)?);
                self.soups.insert(mesh.index(), soup.clone());
                soup
            }
        };
        if soup.triangles.is_empty() {
            self.builder.note("a mesh without triangles is left out", &name(node));
            return Ok(None);
        }
        let as_what = if geometry.hull { Approximation::Hull } else { Approximation::Triangles };
        Ok(Some((Form::Mesh { soup, as_what }, DMat3::IDENTITY)))
    }
}
