//! What the bodies of a run look like.

use crate::{Error, color, linear};
use rockfall::{Kind, Shape};
use rockfall_cache::{BodyTable, SCENE};
use rockfall_math::Vec3;
use rockfall_scene::{BodyRow, Color, Scene};
use std::path::Path;

/// Shapes and materials of a scene, and which of them each body of a run has. Columns have a row for each body of the run's table.
#[derive(Clone, Debug)]
pub struct Inventory {
    /// All shapes, at the size of their bodies, and behind them the meshes that are seen in place of some.
    pub shapes: Vec<Shape>,
    /// Names of all materials.
    pub materials: Vec<String>,
    /// The colour of each material, where it has one.
    pub colors: Vec<Option<Color>>,
    /// Who moves each body.
    pub kinds: Vec<Kind>,
    /// The shape of each body, an index into `shapes`.
    pub shape_of: Vec<u32>,
    /// What is seen of each body, an index into `shapes`: its shape, or the mesh that is shown in its place.
    pub shown_of: Vec<u32>,
    /// The colour of each body, where it or its shape has one; else that of its material counts.
    pub color_of: Vec<Option<Color>>,
    /// The material of each body, an index into `materials`.
    pub material_of: Vec<u32>,
    /// Whether each body is a sensor, which is nothing to look at.
    pub sensors: Vec<bool>,
    /// The centre of mass of each body in the frame of its shape, metres; zero of one that is not dynamic.
    pub centers: Vec<Vec3>,
}

impl Inventory {
    /// Lays out the scene in the folder of a run with these bodies.
    pub(crate) fn of(run: &Path, table: &BodyTable) -> Result<Self, Error> {
        let path = run.join(SCENE);
        let rockfall_scene::Inventory { mut shapes, visuals, materials, colors, bodies, centers } =
            Scene::load(&path)?.inventory()?;
        let mut bodies: Vec<(BodyRow, Vec3)> = bodies.into_iter().zip(centers).collect();
        bodies.sort_by_key(|(body, _)| body.id);
        let (bodies, centers): (Vec<BodyRow>, Vec<Vec3>) = bodies.into_iter().unzip();
        let other = |expected, found| Err(Error::OtherScene { path: path.clone(), expected, found });
        if bodies.len() != table.len() {
            return other(format!("{} bodies", table.len()), bodies.len().to_string());
        }
        let of_run = |row: usize| (table.ids[row], table.shapes[row] as usize, table.scales[row].to_bits());
        let of_scene = |body: &BodyRow| (body.id, body.shape, body.scale.to_bits());
        if let Some(row) = (0..bodies.len()).find(|&row| of_run(row) != of_scene(&bodies[row])) {
            let say = |id, shape, scale| format!("body {id} with shape {shape} at scale {scale}");
            let body = &bodies[row];
            return other(
                say(table.ids[row], table.shapes[row] as usize, table.scales[row]),
                say(body.id, body.shape, body.scale),
            );
        }
        let first_visual = shapes.len() as u32;
        shapes.extend(visuals);
        let shown =
            |body: &BodyRow| body.look.visual.map_or(body.shape as u32, |visual| first_visual + visual);
        Ok(Inventory {
            shapes,
            materials,
            colors,
            shown_of: bodies.iter().map(shown).collect(),
            color_of: bodies.iter().map(|body| body.look.color).collect(),
            kinds: bodies.iter().map(|body| body.kind).collect(),
            shape_of: bodies.iter().map(|body| body.shape as u32).collect(),
            material_of: bodies.iter().map(|body| body.material as u32).collect(),
            sensors: bodies.iter().map(|body| body.sensor).collect(),
            centers,
        })
    }

    /// The colour of bodies of a material that are moved by `kind`: their `own`, that of the material, or one for its number. Linear red, green and blue from
    /// 0 to 1.
    pub fn color(&self, own: Option<Color>, material: u32, kind: Kind) -> [f32; 3] {
        own.or(self.colors[material as usize]).map_or_else(|| color(material, kind), linear)
    }

    /// Rows of the bodies that nobody moves. Sensors are in neither list.
    pub fn fixed(&self) -> Vec<u32> {
        self.rows(|kind| kind == Kind::Static)
    }

    /// Rows of all other bodies.
    pub fn moving(&self) -> Vec<u32> {
        self.rows(|kind| kind != Kind::Static)
    }

    fn rows(&self, wanted: impl Fn(Kind) -> bool) -> Vec<u32> {
        let bodies = (0_u32..).zip(self.kinds.iter().zip(&self.sensors));
        bodies.filter(|(_, (kind, sensor))| wanted(**kind) && !**sensor).map(|(row, _)| row).collect()
    }
}
