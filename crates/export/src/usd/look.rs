//! Colours and materials.

use super::names::Names;
use super::stage::LOOKS;
use crate::{Inventory, color};
use rockfall::Kind;
use rockfall_usd::{Array, Attribute, Prim, Relationship, Value};
use std::collections::BTreeMap;

/// How dull stone is.
const ROUGHNESS: f32 = 0.8;

/// A look: a material of the scene, and whether its bodies are static, which have a paler colour.
pub(super) type Key = (u32, bool);

/// The look of a body.
pub(super) fn of(inventory: &Inventory, row: u32) -> Key {
    (inventory.material_of[row as usize], inventory.kinds[row as usize] == Kind::Static)
}

/// All looks that are in use.
pub(super) struct Looks {
    names: BTreeMap<Key, String>,
}

impl Looks {
    pub(super) fn of(inventory: &Inventory) -> Self {
        let (mut looks, mut names) = (BTreeMap::new(), Names::default());
        for row in 0..inventory.kinds.len() as u32 {
            let key = of(inventory, row);
            looks.entry(key).or_insert_with(|| {
                let name = &inventory.materials[key.0 as usize];
                names.choose(&if key.1 { format!("{name}_static") } else { name.clone() })
            });
        }
        Looks { names: looks }
    }

    /// Gives a mesh the colour and the material of a look.
    pub(super) fn dress(&self, mesh: Prim, key: Key) -> Prim {
        let binding = format!("{LOOKS}/{}", self.names[&key]);
        let colors = Value::Array(Array::Float3(vec![rgb(key)]));
        let color = Attribute::new("color3f[]", "primvars:displayColor", colors);
        mesh.meta("apiSchemas", super::stage::schemas(&["MaterialBindingAPI"]))
            .with(color.meta("interpolation", Value::Token("constant".into())))
            .with(Relationship::new("material:binding", vec![binding]))
    }

    /// The materials.
    pub(super) fn scope(&self) -> Prim {
        let material = |(key, name): (&Key, &String)| {
            let shader = Prim::def("Shader", "Surface")
                .with(Attribute::uniform("token", "info:id", Value::Token("UsdPreviewSurface".into())))
                .with(Attribute::new("color3f", "inputs:diffuseColor", Value::Float3(rgb(*key))))
                .with(Attribute::new("float", "inputs:roughness", Value::Float(ROUGHNESS)))
                .with(Attribute::sampled("token", "outputs:surface"));
            let surface = format!("{LOOKS}/{name}/Surface.outputs:surface");
            Prim::def("Material", name.clone())
                .with(Attribute::connected("token", "outputs:surface", surface))
                .child(shader)
        };
        let scope = Prim::def("Scope", "Looks");
        Prim { children: self.names.iter().map(material).collect(), ..scope }
    }
}

fn rgb((material, is_static): Key) -> [f32; 3] {
    color(material, if is_static { Kind::Static } else { Kind::Dynamic })
}
