//! From colliders and the bodies that they belong to, to bodies with shapes that they share.

use crate::affine::{Affine, Frame, settle};
use crate::content::{Body, Content, Geometry, Kind, Mass, Material, Note, Part, Weight};
use crate::form::Form;
use crate::mesh_file::TriangleSoup;
use rockfall_math::hash::combine;
use rockfall_math::{DMat3, DQuat, DVec3, Mat3, Pose, Quat, Vec3};
use std::collections::BTreeMap;

/// A collider that belongs to a body.
#[derive(Debug)]
pub(crate) struct Collider {
    /// Where it is in the file.
    pub(crate) name: String,
    pub(crate) form: Form,
    /// To the world.
    pub(crate) place: Affine,
    /// Index of its material.
    pub(crate) material: Option<u32>,
    pub(crate) weight: Option<Weight>,
}

/// A body before its colliders are put together.
#[derive(Debug)]
pub(crate) struct Draft {
    pub(crate) name: String,
    pub(crate) kind: Kind,
    /// Whether it only tells who is in it.
    pub(crate) sensor: bool,
    /// To the world.
    pub(crate) frame: Affine,
    pub(crate) colliders: Vec<Collider>,
    pub(crate) velocity: DVec3,
    pub(crate) angular_velocity: DVec3,
    pub(crate) gravity_scale: f32,
    pub(crate) damping: [f32; 2],
    pub(crate) group: u32,
    pub(crate) mask: u32,
    pub(crate) mass: Option<f64>,
    /// Of colliders that have none of their own, kg/m³.
    pub(crate) density: Option<f64>,
    /// In the body's own frame and unit of length.
    pub(crate) center: Option<DVec3>,
    /// Along the axes of the body's frame, kg m².
    pub(crate) inertia: Option<DMat3>,
}

impl Draft {
    pub(crate) fn new(name: String, kind: Kind, frame: Affine) -> Self {
        Draft {
            name,
            kind,
            sensor: false,
            frame,
            colliders: Vec::new(),
            velocity: DVec3::ZERO,
            angular_velocity: DVec3::ZERO,
            gravity_scale: 1.0,
            damping: [0.0; 2],
            group: 1,
            mask: u32::MAX,
            mass: None,
            density: None,
            center: None,
            inertia: None,
        }
    }
}

/// Where content grows: what is alike is there once.
#[derive(Debug, Default)]
pub(crate) struct Builder {
    content: Content,
    /// Indices of geometries and shapes by a hash of what they are.
    geometries: BTreeMap<u64, Vec<u32>>,
    shapes: BTreeMap<u64, Vec<u32>>,
    notes: BTreeMap<String, usize>,
}

impl Builder {
    /// Says something of the file, `place` in it being where.
    pub(crate) fn note(&mut self, what: impl Into<String>, place: &str) {
        let what = what.into();
        let notes = &mut self.content.notes;
        let index = *self.notes.entry(what.clone()).or_insert(notes.len());
        match notes.get_mut(index) {
            Some(note) => note.count += 1,
            None => notes.push(Note { what, first: place.to_owned(), count: 1 }),
        }
    }

    pub(crate) fn material(&mut self, material: Material) -> u32 {
        let all = &mut self.content.materials;
        let known = all.iter().position(|other| *other == material);
        known.unwrap_or_else(|| {
            all.push(material);
            all.len() - 1
        }) as u32
    }

    pub(crate) fn gravity(&mut self, gravity: DVec3) {
        self.content.gravity.get_or_insert(gravity);
    }

    pub(crate) fn finish(mut self, bodies: Vec<Body>) -> Content {
        self.content.bodies = bodies;
        self.content
    }

    /// The body of a draft; none, with a note, where nothing is left of it.
    pub(crate) fn body(&mut self, draft: &Draft) -> Option<Body> {
        let Some(frame) = draft.frame.frame() else {
            self.note(
                "a body that is scaled to nothing, or whose place is not finite, is left out",
                &draft.name,
            );
            return None;
        };
        let mut parts = Vec::new();
        let mut endless = None;
        for collider in &draft.colliders {
            let baked = match collider.form.bake(&frame.see(&collider.place)) {
                Ok(baked) => baked,
                Err(why) => {
                    self.note(format!("a collider is left out: {why}"), &collider.name);
                    continue;
                }
            };
            if let Some(what) = baked.inexact {
                self.note(format!("a form that is {what}"), &collider.name);
            }
            if baked.geometry == Geometry::HalfSpace {
                if draft.kind == Kind::Dynamic {
                    self.note("a plane on a body that forces move is left out", &collider.name);
                    continue;
                }
                endless = Some(parts.len());
            }
            let geometry = self.movable(baked.geometry, draft.kind, &collider.name);
            let geometry = self.geometry(geometry);
            parts.push((geometry, baked.place, collider));
        }
        if let (Some(plane), true) = (endless, parts.len() > 1) {
            self.note("a plane among other colliders of a body is left out", &parts[plane].2.name);
            parts.retain(|(geometry, _, _)| {
                self.content.geometries[*geometry as usize] != Geometry::HalfSpace
            });
        }
        if parts.is_empty() {
            self.note("a body without colliders is left out", &draft.name);
            return None;
        }
        Some(self.assemble(draft, frame, &parts))
    }

    /// Puts baked parts together; there is at least one.
    fn assemble(&mut self, draft: &Draft, frame: Frame, parts: &[(u32, Frame, &Collider)]) -> Body {
        let material = parts[0].2.material;
        if parts.iter().any(|(_, _, collider)| collider.material != material) {
            self.note("a body of several materials has that of its first collider", &draft.name);
        }
        // A shape of one part has that part's frame.
        let own = if let [(_, place, _)] = parts { *place } else { Frame::IDENTITY };
        let (frame, back) = (frame.after(&own), DMat3::from_quat(own.rotation).transpose());
        let weight = |c: &Collider| if draft.kind == Kind::Dynamic { c.weight } else { None };
        let part = |(geometry, place, collider): &(u32, Frame, &Collider)| Part {
            geometry: *geometry,
            pose: if parts.len() == 1 { Pose::default() } else { pose(place) },
            weight: weight(collider),
        };
        let shape = self.shape(parts.iter().map(part).collect());
        // Lengths of the body's own frame in metres.
        let stretch = draft.frame;
        let center = draft.center.map(|c| {
            let world = stretch.point(c) - frame.position;
            (DMat3::from_quat(frame.rotation).transpose() * world).as_vec3()
        });
        let inertia = draft.inertia.map(|m| {
            let turned = back * m * back.transpose();
            Mat3::from_cols_array(&turned.to_cols_array().map(|x| x as f32))
        });
        Body {
            name: draft.name.clone(),
            kind: draft.kind,
            sensor: draft.sensor,
            shape,
            material,
            pose: pose(&frame),
            velocity: draft.velocity,
            angular_velocity: draft.angular_velocity,
            gravity_scale: draft.gravity_scale,
            linear_damping: draft.damping[0],
            angular_damping: draft.damping[1],
            group: draft.group,
            mask: draft.mask,
            mass: match draft.kind {
                Kind::Dynamic => Mass { mass: draft.mass.map(|m| m as f32), center, inertia },
                _ => Mass::default(),
            },
        }
    }

    /// A surface has no inside, so that forces can't move it: then its hull stands for it.
    fn movable(&mut self, geometry: Geometry, kind: Kind, name: &str) -> Geometry {
        match geometry {
            Geometry::Mesh(soup) if kind == Kind::Dynamic => {
                self.note("a triangle mesh on a body that forces move is taken as its convex hull", name);
                Geometry::Hull(soup.vertices)
            }
            other => other,
        }
    }

    fn geometry(&mut self, geometry: Geometry) -> u32 {
        let known = self.geometries.entry(geometry_hash(&geometry)).or_default();
        let all = &mut self.content.geometries;
        known.iter().copied().find(|&i| all[i as usize] == geometry).unwrap_or_else(|| {
            all.push(geometry);
            known.push((all.len() - 1) as u32);
            (all.len() - 1) as u32
        })
    }

    fn shape(&mut self, parts: Vec<Part>) -> u32 {
        let words = parts.iter().map(|part| u64::from(part.geometry));
        let known = self.shapes.entry(words.fold(0, combine)).or_default();
        let all = &mut self.content.shapes;
        known.iter().copied().find(|&i| all[i as usize] == parts).unwrap_or_else(|| {
            all.push(parts);
            known.push((all.len() - 1) as u32);
            (all.len() - 1) as u32
        })
    }
}

/// An angular velocity in rad/s where `map` takes it; mirrors turn the other way round.
pub(crate) fn spin(map: &Affine, radians: DVec3) -> DVec3 {
    let Some(inverse) = map.inverse() else { return DVec3::ZERO };
    let turned = inverse.linear.transpose() * radians * map.linear.determinant();
    let length = turned.length();
    if length > 0.0 { turned * (radians.length() / length) } else { DVec3::ZERO }
}

/// A frame in the precision of bodies.
pub(crate) fn pose(frame: &Frame) -> Pose {
    let q: DQuat = settle(frame.rotation);
    let [x, y, z, w] = q.to_array().map(|x| x as f32);
    Pose { position: frame.position, rotation: Quat::from_xyzw(x, y, z, w) }
}

fn geometry_hash(geometry: &Geometry) -> u64 {
    let points = |kind: u64, points: &[Vec3]| {
        let words = points.iter().flat_map(|p| p.to_array()).map(|x| u64::from(x.to_bits()));
        words.fold(kind, combine)
    };
    let soup = |kind: u64, soup: &TriangleSoup| {
        let corners = soup.triangles.as_flattened().iter().map(|&i| u64::from(i));
        corners.fold(points(kind, &soup.vertices), combine)
    };
    match geometry {
        Geometry::Sphere { radius } => points(1, &[Vec3::splat(*radius)]),
        Geometry::Box { half } => points(2, &[*half]),
        Geometry::Ellipsoid { half } => points(3, &[*half]),
        Geometry::Capsule { half_length, radius } => points(4, &[Vec3::new(*half_length, *radius, 0.0)]),
        Geometry::Cone { half_length, lower, upper } => points(5, &[Vec3::new(*half_length, *lower, *upper)]),
        Geometry::HalfSpace => 6,
        Geometry::Hull(corners) => points(7, corners),
        Geometry::Mesh(mesh) => soup(8, mesh),
        Geometry::Decomposition { soup: mesh, .. } => soup(9, mesh),
        Geometry::Field { soup: mesh, .. } => soup(10, mesh),
    }
}
