//! Colours and materials.

use super::names::Names;
use super::stage::LOOKS;
use crate::Inventory;
use rockfall::Kind;
use rockfall_scene::Color;
use rockfall_usd::{Array, Attribute, Prim, Relationship, Value};
use std::collections::BTreeMap;

/// How dull stone is.
const ROUGHNESS: f32 = 0.8;

/// A look: a material of the scene, whether its bodies are static, which may have a paler colour, and a colour of their own.
pub(super) type Key = (u32, bool, Option<Color>);

/// The look of a body.
pub(super) fn of(inventory: &Inventory, row: u32) -> Key {
    let row = row as usize;
    (inventory.material_of[row], inventory.kinds[row] == Kind::Static, inventory.color_of[row])
}

/// The name of a mesh in a look.
pub(super) fn prototype(shape: u32, look: Key) -> String {
    format!("Shape_{shape}_{}{}", look.0, suffix(look.2))
}

/// What tells looks of one material apart.
fn suffix(color: Option<Color>) -> String {
    color.map(|[r, g, b]| format!("_{r:02x}{g:02x}{b:02x}")).unwrap_or_default()
}

/// All looks that are in use, with their names and colours.
pub(super) struct Looks {
    known: BTreeMap<Key, (String, [f32; 3])>,
}

impl Looks {
    pub(super) fn of(inventory: &Inventory) -> Self {
        let (mut looks, mut names) = (BTreeMap::new(), Names::default());
        for row in 0..inventory.kinds.len() as u32 {
            let key = of(inventory, row);
            looks.entry(key).or_insert_with(|| {
                let (material, is_static, own) = key;
                let (name, kind) = (&inventory.materials[material as usize], inventory.kinds[row as usize]);
                let tail = if is_static { "_static" } else { "" };
                let name = names.choose(&format!("{name}{tail}{}", suffix(own)));
                (name, inventory.color(own, material, kind))
            });
        }
        Looks { known: looks }
    }

    /// Gives a mesh the colour and the material of a look.
    pub(super) fn dress(&self, mesh: Prim, key: Key) -> Prim {
        let (name, rgb) = &self.known[&key];
        let binding = format!("{LOOKS}/{name}");
        let colors = Value::Array(Array::Float3(vec![*rgb]));
        let color = Attribute::new("color3f[]", "primvars:displayColor", colors);
        mesh.meta("apiSchemas", super::stage::schemas(&["MaterialBindingAPI"]))
            .with(color.meta("interpolation", Value::Token("constant".into())))
            .with(Relationship::new("material:binding", vec![binding]))
    }

    /// The materials.
    pub(super) fn scope(&self) -> Prim {
        let material = |(name, rgb): &(String, [f32; 3])| {
            let shader = Prim::def("Shader", "Surface")
                .with(Attribute::uniform("token", "info:id", Value::Token("UsdPreviewSurface".into())))
                .with(Attribute::new("color3f", "inputs:diffuseColor", Value::Float3(*rgb)))
                .with(Attribute::new("float", "inputs:roughness", Value::Float(ROUGHNESS)))
                .with(Attribute::sampled("token", "outputs:surface"));
            let surface = format!("{LOOKS}/{name}/Surface.outputs:surface");
            Prim::def("Material", name.clone())
                .with(Attribute::connected("token", "outputs:surface", surface))
                .child(shader)
        };
        let scope = Prim::def("Scope", "Looks");
        Prim { children: self.known.values().map(material).collect(), ..scope }
    }
}
