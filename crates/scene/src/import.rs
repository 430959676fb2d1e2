//! Scenes of other programs as parts of a scene: read while it is loaded, cooked and placed with its other bodies.

mod cook;
mod mass;

use crate::body::Template;
use crate::error::Problem;
use crate::load;
use crate::node::{Node, Table, Value};
use crate::plan::Yard;
use crate::root::material;
use crate::rotation;
use crate::spec::{ANY, POSITIVE, Spec, Ty, key, optional, required};
use rockfall::{Kind, Material, Mix};
use rockfall_import::{Body, Content, Place};
use rockfall_math::{DVec3, Pose, Vec3};
use std::path::Path;
use std::sync::Arc;

pub(crate) static IMPORT: Spec = Spec {
    name: "import",
    about: "A scene of another program: an OpenUSD stage with UsdPhysics, or a glTF file. [Bringing scenes in](import.md) tells what of it \
            is taken. Its bodies come after `[[bodies]]` and before those of generators.",
    example: r#"[[imports]]
file = "quarry.usdz"
position = [0, 0, 2]
"#,
    groups: &[&[
        required(
            "file",
            Ty::Text,
            "A .usd, .usda, .usdc, .usdz, .gltf or .glb file, its path from the scene file.",
        ),
        key("position", Ty::Numbers(&[3], ANY), "[0, 0, 0]", "Where its origin is, m."),
        key(
            "rotation",
            Ty::Rotation,
            "[0, 0, 0]",
            "How it is turned; forms as for bodies. z is up before that, whatever the file says.",
        ),
        key(
            "scale",
            Ty::Number(POSITIVE),
            "1",
            "Multiplies its lengths; the file's own unit is taken care of.",
        ),
        optional(
            "material",
            Ty::Material,
            "Name of the material of bodies that have none in the file; `default`, with the density of the file's format, where not given.",
        ),
        optional(
            "checksum",
            Ty::Text,
            "XXH3 of the file, 16 hexadecimal digits; a file with another one is refused. A run fills it in. Files that this one refers to are not part of it.",
        ),
    ]],
};

/// The text of a scene that is a file of another program alone; none for scene files.
pub(crate) fn scene_of(path: &Path) -> Option<String> {
    let name = rockfall_import::is_scene(path).then(|| path.file_name())??.to_str()?.to_owned();
    Some(format!("[[imports]]\nfile = {}\n", toml::Value::String(name)))
}

/// Reads all files that the scene `root` imports, fills in their checksums, and takes gravity from them where the scene has none of its own.
pub(crate) fn read_all(root: &mut Table, problems: &mut Vec<Problem>) -> Vec<Arc<Content>> {
    let mut contents = Vec::new();
    let imports = root.entries.iter_mut().find(|(key, _)| *key == "imports");
    let Some((_, Node { value: Value::List(tables), .. })) = imports else { return contents };
    for node in tables {
        let Value::Table(table) = &mut node.value else { continue };
        match read(table) {
            Ok(content) => {
                table.set("checksum", Value::Text(spell(content.checksum)));
                contents.push(Arc::new(content));
            }
            Err(problem) => problems.push(problem),
        }
    }
    let given = root.table("world").and_then(|world| world.node("gravity")).is_some_and(|node| node.given);
    if let Some(gravity) = contents.iter().find_map(|content| content.gravity)
        && !given
    {
        load::edit(root, "world", |world| {
            let number = |x| Node { span: world.span, given: true, value: Value::Number(x) };
            world.set("gravity", Value::List(gravity.to_array().map(number).to_vec()));
        });
    }
    contents
}

fn read(table: &Table) -> Result<Content, Problem> {
    let rotation = rotation::read(table, "rotation")?;
    let place =
        Place { pose: Pose { position: table.dvec3("position"), rotation }, scale: table.f64("scale") };
    let content = rockfall_import::read(Path::new(table.text("file")), &place)
        .map_err(|error| Problem::at(table.span_of("file"), error.to_string()))?;
    let (known, found) = (table.text("checksum"), spell(content.checksum));
    if table.has("checksum") && known != found {
        let message = format!("{} has the checksum {found}: it was changed", table.text("file"));
        return Err(Problem::at(table.span_of("checksum"), message).expecting(known));
    }
    Ok(content)
}

fn spell(checksum: u64) -> String {
    format!("{checksum:016x}")
}

/// The name of the file that a table imports.
fn file(table: &Table) -> &str {
    Path::new(table.text("file")).file_name().and_then(|name| name.to_str()).unwrap_or_default()
}

/// What users have to know of the files.
pub(crate) fn notes(root: &Table, imports: &[Arc<Content>]) -> Vec<String> {
    let all = root.tables("imports").zip(imports);
    all.flat_map(|(table, content)| content.notes.iter().map(|note| format!("{}: {note}", file(table))))
        .collect()
}

/// Rough size in memory of the shapes of a file, bytes.
pub(crate) fn memory(content: &Content) -> u64 {
    content.geometries.iter().map(cook::memory).sum()
}

/// All materials of a scene with their names: those that it describes, then those of what it imports. The last of each import is for bodies that
/// have none.
pub(crate) fn materials(root: &Table, imports: &[Arc<Content>]) -> Vec<(String, Material)> {
    let own = root.named("materials").map(|(name, table)| (name.to_owned(), material(table)));
    let mut all: Vec<(String, Material)> = own.collect();
    for (table, content) in root.tables("imports").zip(imports) {
        let fallback = fallback(root, table, content);
        for m in &content.materials {
            let material = Material {
                density: m.density.unwrap_or(fallback.density),
                restitution: m.restitution,
                friction: m.friction,
                friction_mix: mix(m.friction_mix),
                restitution_mix: mix(m.restitution_mix),
                ..Material::default()
            };
            all.push((format!("{}:{}", file(table), m.name), material));
        }
        all.push((format!("{}:", file(table)), fallback));
    }
    all
}

/// What bodies without a material are made of.
fn fallback(root: &Table, table: &Table, content: &Content) -> Material {
    let name = if table.has("material") { table.text("material") } else { "default" };
    let found = root.named("materials").find(|(n, _)| *n == name);
    let found = found.map_or_else(Material::default, |(_, table)| material(table));
    match content.density {
        Some(density) if !table.has("material") => Material { density, ..found },
        _ => found,
    }
}

fn mix(mix: rockfall_import::Mix) -> Mix {
    match mix {
        rockfall_import::Mix::Average => Mix::Average,
        rockfall_import::Mix::Minimum => Mix::Minimum,
        rockfall_import::Mix::Product => Mix::Product,
        rockfall_import::Mix::Maximum => Mix::Maximum,
    }
}

/// Cooks the shapes of all imports and places their bodies.
pub(crate) fn place(root: &Table, imports: &[Arc<Content>], yard: &mut Yard<'_>) -> Result<(), Problem> {
    let all = materials(root, imports);
    let mut first = root.named("materials").count();
    for (table, content) in root.tables("imports").zip(imports) {
        let last = first + content.materials.len();
        let shapes = cook::shapes(content, table)?;
        let mut known = Vec::with_capacity(shapes.len());
        for (index, cooked) in shapes.iter().enumerate() {
            let named = |problem: Problem| cook::name(problem, content, index as u32);
            known.push(yard.shape(cooked.shape.clone(), table).map_err(named)?);
        }
        for body in &content.bodies {
            let material = body.material.map_or(last, |m| first + m as usize);
            let cooked = &shapes[body.shape as usize];
            let density = all[material].1.density;
            let mass = mass::of(body, &content.shapes[body.shape as usize], cooked, density);
            let template = yard.template(Template { mass, ..template(body, material as u32) });
            yard.add(template, known[body.shape as usize], 1.0, body.pose);
            yard.name(&body.name);
        }
        first = last + 1;
    }
    Ok(())
}

fn template(body: &Body, material: u32) -> Template {
    let single = |v: DVec3| -> Vec3 { v.as_vec3() };
    Template {
        kind: match body.kind {
            rockfall_import::Kind::Dynamic => Kind::Dynamic,
            rockfall_import::Kind::Kinematic => Kind::Kinematic,
            rockfall_import::Kind::Static => Kind::Static,
        },
        sensor: body.sensor,
        material,
        group: body.group,
        mask: body.mask,
        velocity: single(body.velocity),
        angular_velocity: single(body.angular_velocity),
        gravity_scale: body.gravity_scale,
        linear_damping: body.linear_damping,
        angular_damping: body.angular_damping,
        ..Template::default()
    }
}
