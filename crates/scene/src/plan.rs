//! The plan of a scene: all shapes cooked, all bodies in their places, before there is a world.

use crate::body::{self, Template};
use crate::error::Problem;
use crate::generators::{self, Pour};
use crate::import;
use crate::node::{Table, Value};
use crate::random::Random;
use crate::shapes::{self, Cook, bounding_ball, scaled, why_immovable};
use crate::sizes::Sizes;
use crate::start::Begun;
use crate::visual::{Color, Look, Visuals};
use rockfall::{Kind, Material, Shape};
use rockfall_decompose::{Decomposition, Misfit};
use rockfall_import::Content;
use rockfall_math::{Pose, Vec3};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::sync::Arc;

/// What a run knows of a body before it starts.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyRow {
    /// Its stable id in the world.
    pub id: u64,
    /// Its name, if it has one.
    pub name: Option<String>,
    /// Index of its shape among those of the scene, which is also the index of the world's
    /// [`ShapeId`](rockfall::ShapeId).
    pub shape: usize,
    /// The factor by which a generator scaled the shape that the scene describes; already applied to `shape`.
    pub scale: f32,
    /// Who moves it.
    pub kind: Kind,
    /// Whether it collides with nothing and tells who is in it.
    pub sensor: bool,
    /// Index of its material among those of the scene.
    pub material: usize,
    /// What it looks like.
    pub look: Look,
}

/// Everything that is needed to set up a world, and to pour more into it.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) shapes: Vec<Shape>,
    pub(crate) materials: Vec<Material>,
    /// The colour of each material, where it has one.
    pub(crate) colors: Vec<Option<Color>>,
    /// What is seen in place of shapes, in their frames.
    pub(crate) visuals: Vec<Shape>,
    pub(crate) templates: Vec<Template>,
    /// Bodies that are there from the start: template and place. They have the first rows.
    pub(crate) placed: Vec<(u32, Pose)>,
    /// Velocities of those that go on from another run, m/s and rad/s. They are the first ones of all.
    pub(crate) motions: Vec<(Vec3, Vec3)>,
    pub(crate) pours: Vec<Pour>,
    /// All bodies, also those that are poured later.
    pub(crate) rows: Vec<BodyRow>,
    /// Rows of the generators that have a name.
    pub(crate) made: Vec<(String, Range<usize>)>,
}

impl Plan {
    /// The template of the body in a row.
    pub(crate) fn template_of(&self, row: usize) -> u32 {
        let poured = || self.pours.iter().find(|pour| pour.rows.contains(&row)).map(|pour| pour.template);
        self.placed.get(row).map(|(template, _)| *template).or_else(poured).unwrap_or(0)
    }

    /// The row of a body that has no id yet; `look` is that of its shape.
    fn row(&self, template: u32, shape: u32, scale: f32, look: Look) -> BodyRow {
        let template = &self.templates[template as usize];
        let (kind, sensor, material) = (template.kind, template.sensor, template.material as usize);
        let look = Look { color: template.color.or(look.color), ..look };
        BodyRow { id: 0, name: None, shape: shape as usize, scale, kind, sensor, material, look }
    }
}

/// Which shapes and sizes a generator draws from.
pub(crate) struct Choices {
    /// Index of each family, and the number of its members.
    families: Vec<(usize, usize)>,
    scales: Vec<f32>,
}

/// Where a plan grows.
pub(crate) struct Yard<'a> {
    pub(crate) seed: u64,
    root: &'a Table,
    /// Shapes as described, cooked when they are first used, by their order in the file.
    families: BTreeMap<usize, Vec<Shape>>,
    /// Shapes in use by family, member and the bits of the scale.
    known: BTreeMap<(usize, usize, u32), u32>,
    /// The ball around each shape in use.
    balls: Vec<(Vec3, f32)>,
    /// What each shape in use looks like.
    looks: Vec<Look>,
    visuals: Visuals,
    pours: Vec<(Pour, Vec<(u32, f32)>)>,
    /// The pours of the generators that have a name.
    named_pours: Vec<(String, Range<usize>)>,
    plan: Plan,
}

/// Lays out the scene `root`, which starts with the bodies `begun`, with what it imports.
pub(crate) fn plan(
    root: &Table,
    imports: &[Arc<Content>],
    seed: u64,
    begun: Option<&Begun>,
) -> Result<Plan, Problem> {
    let materials: Vec<Material> =
        import::materials(root, imports).into_iter().map(|(_, material)| material).collect();
    let mut colors: Vec<Option<Color>> =
        root.named("materials").map(|(_, table)| table.color("color")).collect();
    // Those of imports have none.
    colors.resize(materials.len(), None);
    let mut yard = Yard {
        seed,
        root,
        families: BTreeMap::new(),
        known: BTreeMap::new(),
        balls: Vec::new(),
        looks: Vec::new(),
        visuals: Visuals::default(),
        pours: Vec::new(),
        named_pours: Vec::new(),
        plan: Plan {
            shapes: Vec::new(),
            materials,
            colors,
            visuals: Vec::new(),
            templates: Vec::new(),
            placed: Vec::new(),
            motions: Vec::new(),
            pours: Vec::new(),
            rows: Vec::new(),
            made: Vec::new(),
        },
    };
    let (mut own_ids, mut first_free) = (BTreeMap::new(), 1);
    if let Some(begun) = begun {
        yard.go_on(begun);
        own_ids.extend(yard.plan.rows.iter().map(|row| row.id).enumerate());
        first_free = begun.start.last_id.saturating_add(1);
    }
    for table in root.tables("bodies") {
        let family = yard.family(table, "shape")?;
        let shape = yard.sized(family, table.int("member") as usize, 1.0, table)?;
        let template = Template::body(table, yard.material(table))?;
        if let (Kind::Dynamic, Some(why)) = (template.kind, why_immovable(&yard.plan.shapes[shape as usize]))
        {
            let message = format!("`{}` is dynamic, but its shape is {why}", table.path);
            return Err(Problem::at(table.span_of("kind"), message)
                .expecting("`static` or `kinematic`, or a closed mesh"));
        }
        let template = yard.template(template);
        let pose = body::pose(table)?;
        if table.has("id") {
            own_ids.insert(yard.plan.rows.len(), table.int("id"));
        }
        yard.add(template, shape, 1.0, pose);
        if table.has("name") {
            yard.name(table.text("name"));
        }
        if let Some(visual) = table.table("visual") {
            yard.show(visual)?;
        }
    }
    import::place(root, imports, &mut yard)?;
    for (table, number) in root.tables("generators").zip(1..) {
        let label = match table.text("name") {
            "" => format!("generators.{number}"),
            name => format!("generators.{name}"),
        };
        let before = (yard.plan.rows.len(), yard.pours.len());
        (generators::kind_of(table).place)(table, &label, &mut yard)?;
        if !table.text("name").is_empty() {
            let name = || table.text("name").to_owned();
            yard.plan.made.push((name(), before.0..yard.plan.rows.len()));
            yard.named_pours.push((name(), before.1..yard.pours.len()));
        }
    }
    Ok(yard.finish(&own_ids, first_free))
}

/// How a mesh of the scene was cut into hulls.
#[derive(Clone, Debug, PartialEq)]
pub struct Cut {
    /// Name of the shape.
    pub shape: String,
    /// Number of hulls.
    pub hulls: usize,
    /// How far they are from the mesh.
    pub misfit: Misfit,
}

/// Cuts up the meshes of the scene `root`, in the order of the file.
pub(crate) fn cuts(root: &Table, seed: u64) -> Result<Vec<Cut>, Problem> {
    let none = BTreeMap::new();
    let context = Cook::new(seed, root, &none);
    let tables = root.named("shapes").filter(|(_, table)| shapes::is_decomposition(table));
    let cut = |(name, table): (&str, &Table)| {
        let Decomposition { compound, misfit } = shapes::cook_decomposition(table, &context)?;
        Ok(Cut { shape: name.to_owned(), hulls: compound.parts().len(), misfit })
    };
    tables.map(cut).collect()
}

impl Yard<'_> {
    /// Adds the bodies of another run, before all others.
    fn go_on(&mut self, begun: &Begun) {
        let Plan { shapes, materials, colors, templates, placed, motions, rows, .. } = &mut self.plan;
        self.visuals.shapes.extend_from_slice(&begun.visuals);
        // Their bodies have looks of their own.
        self.looks.resize(begun.shapes.len(), Look::default());
        self.balls.extend(begun.shapes.iter().map(|shape| bounding_ball(shape).unwrap_or_default()));
        shapes.extend_from_slice(&begun.shapes);
        materials.extend(begun.materials.iter().map(|former| former.material));
        colors.extend(begun.materials.iter().map(|former| former.color));
        templates.extend_from_slice(&begun.templates);
        for body in &begun.bodies {
            rows.push(body.row.clone());
            placed.push((body.template, body.pose));
            motions.push(body.motion);
        }
    }

    /// The material that `table` names.
    pub(crate) fn material(&self, table: &Table) -> u32 {
        let name = table.text("material");
        self.root.named("materials").position(|(n, _)| n == name).unwrap_or(0) as u32
    }

    /// Adds a template, unless it is the one that was added last.
    pub(crate) fn template(&mut self, template: Template) -> u32 {
        if self.plan.templates.last() != Some(&template) {
            self.plan.templates.push(template);
        }
        (self.plan.templates.len() - 1) as u32
    }

    /// The template of a generator of dynamic bodies.
    pub(crate) fn moving(&mut self, table: &Table) -> u32 {
        let template = Template::moving(table, self.material(table));
        self.template(template)
    }

    /// Cooks a shape that `table` names, if that has not been done.
    fn family(&mut self, table: &Table, key: &str) -> Result<usize, Problem> {
        self.family_named(table.text(key), table)
    }

    fn family_named(&mut self, name: &str, table: &Table) -> Result<usize, Problem> {
        let found = self.root.named("shapes").enumerate().find(|(_, (n, _))| *n == name);
        let Some((index, (_, shape))) = found else {
            return Err(Problem::at(table.span, format!("no shape is called `{name}`")));
        };
        if !self.families.contains_key(&index) {
            for part in shapes::parts_of(shape) {
                self.family(part, "shape")?;
            }
            let context = Cook::new(self.seed, self.root, &self.families);
            let shapes = (shapes::kind_of(shape).cook)(shape, &context)?;
            self.families.insert(index, shapes);
        }
        Ok(index)
    }

    /// The first shape of the family that a key names, as it is described.
    pub(crate) fn first_of(&mut self, table: &Table, key: &str) -> Result<Shape, Problem> {
        let family = self.family(table, key)?;
        self.member(family, 0, table)
    }

    fn member(&self, family: usize, member: usize, table: &Table) -> Result<Shape, Problem> {
        let shape = self.families.get(&family).and_then(|shapes| shapes.get(member));
        shape.cloned().ok_or_else(|| Problem::at(table.span, format!("`{}` uses no shape", table.path)))
    }

    /// Adds a shape that `table` needs.
    pub(crate) fn shape(&mut self, shape: Shape, table: &Table) -> Result<u32, Problem> {
        shape.validate().map_err(|why| Problem::at(table.span, format!("`{}`: {why}", table.path)))?;
        self.balls.push(bounding_ball(&shape).unwrap_or_default());
        self.looks.push(Look::default());
        self.plan.shapes.push(shape);
        Ok((self.plan.shapes.len() - 1) as u32)
    }

    /// The shape of the scene at a size.
    fn sized(&mut self, family: usize, member: usize, scale: f32, table: &Table) -> Result<u32, Problem> {
        let key = (family, member, scale.to_bits());
        if let Some(&shape) = self.known.get(&key) {
            return Ok(shape);
        }
        let shape = scaled(&self.member(family, member, table)?, scale).map_err(|why| {
            Problem::at(
                table.span_of("shape"),
                format!("`{}` at size {scale}: {why}", table.path_of("shape")),
            )
        })?;
        let shape = self.shape(shape, table)?;
        self.looks[shape as usize] = self.look(family, scale)?;
        self.known.insert(key, shape);
        Ok(shape)
    }

    /// What the shapes of a family look like at a size.
    fn look(&mut self, family: usize, scale: f32) -> Result<Look, Problem> {
        let Some((_, table)) = self.root.named("shapes").nth(family) else { return Ok(Look::default()) };
        let visual = table.table("visual").map(|visual| self.visuals.of(visual, scale)).transpose()?;
        Ok(Look { visual, color: table.color("color") })
    }

    /// What the keys `shape` and `size` of a generator offer.
    pub(crate) fn choices(&mut self, table: &Table) -> Result<Choices, Problem> {
        let names: Vec<String> = match table.node("shape").map(|n| &n.value) {
            Some(Value::List(list)) => list.iter().map(|n| n.value.text().to_owned()).collect(),
            _ => vec![table.text("shape").to_owned()],
        };
        let mut families = Vec::new();
        for name in names {
            let family = self.family_named(&name, table)?;
            if let Some(why) = self.families[&family].iter().find_map(why_immovable) {
                let message =
                    format!("`{}` makes dynamic bodies, but the shape `{name}` is {why}", table.path);
                return Err(Problem::at(table.span_of("shape"), message).expecting("a shape with an inside"));
            }
            families.push((family, self.families[&family].len()));
        }
        let scales = table.table("size").map_or_else(
            || vec![1.0],
            |size| {
                let sizes = Sizes::read(size, size.f64("min"), size.f64("max"));
                sizes.classes(size.int("classes") as usize).into_iter().map(|s| s as f32).collect()
            },
        );
        Ok(Choices { families, scales })
    }

    /// A shape and its scale, at random.
    pub(crate) fn draw(
        &mut self,
        choices: &Choices,
        table: &Table,
        random: &mut Random,
    ) -> Result<(u32, f32), Problem> {
        let (family, members) = choices.families[random.below(choices.families.len())];
        let member = random.below(members);
        let scale = choices.scales[random.below(choices.scales.len())];
        Ok((self.sized(family, member, scale, table)?, scale))
    }

    /// The ball around a shape: centre in the shape's frame, and radius.
    pub(crate) fn ball(&self, shape: u32) -> (Vec3, f32) {
        self.balls[shape as usize]
    }

    /// Adds a body that is there from the start.
    pub(crate) fn add(&mut self, template: u32, shape: u32, scale: f32, pose: Pose) {
        let row = self.plan.row(template, shape, scale, self.looks[shape as usize]);
        self.plan.placed.push((template, pose));
        self.plan.rows.push(row);
    }

    /// Gives the body that was added last a name.
    pub(crate) fn name(&mut self, name: &str) {
        if let Some(row) = self.plan.rows.last_mut() {
            row.name = Some(name.to_owned());
        }
    }

    /// Shows the body that was added last as a mesh.
    fn show(&mut self, visual: &Table) -> Result<(), Problem> {
        let visual = self.visuals.of(visual, 1.0)?;
        if let Some(row) = self.plan.rows.last_mut() {
            row.look.visual = Some(visual);
        }
        Ok(())
    }

    /// Adds bodies that come later: the shape and scale of each.
    pub(crate) fn pour(&mut self, pour: Pour, drawn: Vec<(u32, f32)>) {
        self.pours.push((pour, drawn));
    }

    /// Gives rows to what is poured, and ids to all: their own, or those from `first_free` on that are not taken.
    fn finish(self, own_ids: &BTreeMap<usize, u64>, first_free: u64) -> Plan {
        let Yard { mut plan, pours, named_pours, looks, visuals, .. } = self;
        plan.visuals = visuals.shapes;
        for (mut pour, drawn) in pours {
            let first = plan.rows.len();
            let rows: Vec<BodyRow> = drawn
                .into_iter()
                .map(|(shape, scale)| plan.row(pour.template, shape, scale, looks[shape as usize]))
                .collect();
            plan.rows.extend(rows);
            pour.rows = first..plan.rows.len();
            plan.pours.push(pour);
        }
        for (name, pours) in named_pours {
            let rows = plan.pours[pours].iter().map(|pour| (name.clone(), pour.rows.clone()));
            plan.made.extend(rows.collect::<Vec<_>>());
        }
        let taken: BTreeSet<u64> = own_ids.values().copied().collect();
        let mut free = (first_free..=u64::MAX).filter(|id| !taken.contains(id));
        for (index, row) in plan.rows.iter_mut().enumerate() {
            row.id = own_ids.get(&index).copied().or_else(|| free.next()).unwrap_or(0);
        }
        plan
    }
}
