//! The table `[start]`: a frame of another run, whose bodies are there before all others.
//!
//! The scene of that run is laid out once more; who was there at the frame is put where it was. A run that begins so keeps a copy of what it began
//! with beside its `scene.toml` ([`START`](rockfall_cache::START)), which is taken instead of the other run wherever a scene is read from there. So
//! a run can go on, be shown and be run again when the one before it is gone.

use crate::body::Template;
use crate::error::Problem;
use crate::import;
use crate::node::Table;
use crate::plan::{BodyRow, Plan};
use crate::scene::Scene;
use crate::spec::{Spec, Ty, key, optional, required};
use crate::visual::{Color, Look};
use rockfall::{Kind, Material, Shape};
use rockfall_cache::{Error, Start, VelocityOf};
use rockfall_import::Content;
use rockfall_math::{Pose, Vec3, rotation::rotate};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

const KINDS: &[&str] = &["dynamic", "kinematic", "static"];

pub(crate) static START: Spec = Spec {
    name: "start",
    about: "A frame of another run to begin with: its bodies, where they were and as fast as they were.",
    example: r#"[start]
run = "runs/fill-1"
without = ["gate"]
"#,
    groups: &[&[
        required("run", Ty::Text, "The folder of the run, its path from the scene file."),
        optional(
            "frame",
            Ty::Int(0, 1_000_000_000),
            "Number of the frame, 0 being the start of that run. The last one on disk where not given.",
        ),
        key(
            "without",
            Ty::Texts,
            "[]",
            "Names of bodies that are left out, and of generators whose bodies all are.",
        ),
        key(
            "kinds",
            Ty::Choices(KINDS),
            "[\"dynamic\", \"kinematic\", \"static\"]",
            "Bodies of other kinds are left out.",
        ),
        key(
            "materials",
            Ty::Choice(&["run", "scene"]),
            "\"run\"",
            "Where the names of their materials mean something: in the run, or in this scene, which then has to have them.",
        ),
        key("velocities", Ty::Bool, "true", "Whether they go on as fast as they were, or from rest."),
    ]],
};

/// Where what a scene starts with is looked for.
#[derive(Debug)]
pub(crate) enum Lookup {
    /// As a copy in this folder, and else in the run that the scene names.
    Beside(PathBuf),
    /// It is known: what the run began with whose scene this is.
    Known(Option<Box<Start>>),
}

/// The bodies of a frame of a run, ready to be laid out.
#[derive(Debug)]
pub(crate) struct Begun {
    pub(crate) start: Start,
    /// Those in use.
    pub(crate) shapes: Vec<Shape>,
    /// What is seen in place of them.
    pub(crate) visuals: Vec<Shape>,
    /// Those of the run that are in use, behind those of the scene.
    pub(crate) materials: Vec<FormerMaterial>,
    pub(crate) templates: Vec<Template>,
    pub(crate) bodies: Vec<Former>,
}

/// A material of the run.
#[derive(Clone, Debug)]
pub(crate) struct FormerMaterial {
    pub(crate) name: String,
    pub(crate) material: Material,
    pub(crate) color: Option<Color>,
}

/// A body of the run. Its numbers of shape, material and template are those of [`Begun`], but that materials of the scene come first.
#[derive(Clone, Debug)]
pub(crate) struct Former {
    pub(crate) row: BodyRow,
    pub(crate) template: u32,
    pub(crate) pose: Pose,
    /// Of the centre of mass, m/s, and rad/s.
    pub(crate) motion: (Vec3, Vec3),
}

impl Begun {
    /// What there is to know of a frame that is not there to the bit.
    pub(crate) fn note(&self) -> Option<String> {
        let Start { run, state, .. } = &self.start;
        (state.velocity_of == VelocityOf::ShapeFrame).then(|| {
            format!(
                "it starts with frame {} of {}, whose velocities are means over a step, since the run has no others of it",
                state.frame,
                run.display()
            )
        })
    }

    /// Reads what the table `[start]` of the scene `root` wants, which has imports.
    pub(crate) fn read(
        table: &Table,
        root: &Table,
        imports: &[Arc<Content>],
        lookup: Lookup,
    ) -> Result<Self, Problem> {
        let start = find(table, lookup)?;
        let name = format!("{}/{}", start.run.display(), rockfall_cache::SCENE);
        let known = Lookup::Known(start.start.clone());
        let scene = Scene::parse_with(&start.scene, &name, &start.run, known);
        let plan = scene.and_then(|scene| Ok((scene.plan_within(None)?, scene.materials())));
        let (plan, names) = plan.map_err(|error| {
            Problem::at(table.span_of("run"), format!("the scene of the run can't be laid out: {error}"))
        })?;
        let mut begun = Begun {
            start,
            shapes: Vec::new(),
            visuals: Vec::new(),
            materials: Vec::new(),
            templates: plan.templates.clone(),
            bodies: Vec::new(),
        };
        begun.take(table, root, import::materials(root, imports).len(), &plan, &names)?;
        begun.differs_from(root)?;
        Ok(begun)
    }

    /// Takes over the bodies that are wanted. Their materials are numbered from `first` on.
    fn take(
        &mut self,
        table: &Table,
        root: &Table,
        first: usize,
        plan: &Plan,
        names: &[String],
    ) -> Result<(), Problem> {
        let without = left_out(table, plan)?;
        let words = table.list("kinds");
        let wanted = |kind: Kind| {
            let word = match kind {
                Kind::Dynamic => KINDS[0],
                Kind::Kinematic => KINDS[1],
                Kind::Static => KINDS[2],
            };
            words.iter().any(|node| node.value.text() == word)
        };
        let rows: BTreeMap<u64, usize> = plan.rows.iter().enumerate().map(|(k, row)| (row.id, k)).collect();
        let (mut shapes, mut visuals, mut materials) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        let centers: Vec<Vec3> = plan.shapes.iter().map(center).collect();
        let state = &self.start.state;
        for ((&id, &pose), &motion) in state.ids.iter().zip(&state.poses).zip(&state.velocities) {
            let Some(&k) = rows.get(&id) else {
                let message = format!("the run has a body {id} that its scene does not have");
                return Err(Problem::at(table.span_of("run"), message).expecting("the scene that was run"));
            };
            let row = &plan.rows[k];
            if !wanted(row.kind) || without.contains(&k) {
                continue;
            }
            let shape = *shapes.entry(row.shape).or_insert_with(|| {
                self.shapes.push(plan.shapes[row.shape].clone());
                self.shapes.len() - 1
            });
            let visual = row.look.visual.map(|visual| {
                *visuals.entry(visual).or_insert_with(|| {
                    self.visuals.push(plan.visuals[visual as usize].clone());
                    self.visuals.len() as u32 - 1
                })
            });
            let material = match materials.get(&row.material) {
                Some(&material) => material,
                None => {
                    let name = &names[row.material];
                    let mut own = root.named("materials");
                    let material = if table.text("materials") == "scene" {
                        let found = own.position(|(n, _)| n == name);
                        let missing = || {
                            let message = format!("the run has bodies of a material `{name}`");
                            let known = root.named("materials").map(|(n, _)| n);
                            Problem::at(table.span_of("materials"), message)
                                .expecting(format!("`[materials.{name}]`"))
                                .near(name, known)
                        };
                        found.ok_or_else(missing)?
                    } else {
                        let (material, color) = (plan.materials[row.material], plan.colors[row.material]);
                        self.materials.push(FormerMaterial { name: name.clone(), material, color });
                        first + self.materials.len() - 1
                    };
                    materials.insert(row.material, material);
                    material
                }
            };
            let template = plan.template_of(k);
            self.templates[template as usize].material = material as u32;
            let motion = match state.velocity_of {
                _ if !table.bool("velocities") => (Vec3::ZERO, Vec3::ZERO),
                VelocityOf::ShapeFrame if row.kind == Kind::Dynamic => {
                    let own = plan.templates[template as usize].mass.and_then(|mass| mass.center);
                    let arm = rotate(pose.rotation, own.unwrap_or(centers[row.shape]));
                    (motion.0 + motion.1.cross(arm), motion.1)
                }
                _ => motion,
            };
            self.bodies.push(Former {
                row: BodyRow { shape, material, look: Look { visual, ..row.look }, ..row.clone() },
                template,
                pose,
                motion,
            });
        }
        Ok(())
    }

    /// No body of the scene `root` may have the id or the name of one of these.
    fn differs_from(&self, root: &Table) -> Result<(), Problem> {
        let ids: BTreeSet<u64> = self.bodies.iter().map(|body| body.row.id).collect();
        let names: BTreeSet<&str> = self.bodies.iter().filter_map(|body| body.row.name.as_deref()).collect();
        for table in root.tables("bodies") {
            for (key, taken) in [
                ("id", table.has("id") && ids.contains(&table.int("id"))),
                ("name", table.has("name") && names.contains(table.text("name"))),
            ] {
                if taken {
                    let message =
                        format!("`{}` is that of a body of the run in `[start]`", table.path_of(key));
                    return Err(Problem::at(table.span_of(key), message).expecting(format!("another {key}")));
                }
            }
        }
        Ok(())
    }
}

/// The frame that is wanted.
fn find(table: &Table, lookup: Lookup) -> Result<Start, Problem> {
    let run = Path::new(table.text("run"));
    let frame = table.has("frame").then(|| table.int("frame"));
    let failed = |error: Error| {
        let key = if matches!(error, Error::NoFrame { .. }) { "frame" } else { "run" };
        let expected = match &error {
            Error::NoFrame { frames, .. } => format!("a frame before {frames}"),
            _ => "the folder of a run that can be read".to_owned(),
        };
        Problem::at(table.span_of(key), error.to_string()).expecting(expected)
    };
    let wanted = |start: &Start| start.run == run && frame.is_none_or(|frame| frame == start.state.frame);
    match lookup {
        Lookup::Known(start) => match start {
            Some(start) if wanted(&start) => Ok(*start),
            _ => {
                let message = format!("`{}` is missing beside it", rockfall_cache::START);
                Err(Problem::at(table.span_of("run"), message).expecting("what the run began with"))
            }
        },
        Lookup::Beside(folder) => {
            match Start::read(&folder.join(rockfall_cache::START)).map_err(failed)?.filter(wanted) {
                Some(copy) => Ok(copy),
                None => Start::of_run(run, frame).map_err(failed),
            }
        }
    }
}

/// Rows of the bodies that `without` names.
fn left_out(table: &Table, plan: &Plan) -> Result<BTreeSet<usize>, Problem> {
    let mut out = BTreeSet::new();
    for node in table.list("without") {
        let name = node.value.text();
        let mut found = false;
        for (k, _) in plan.rows.iter().enumerate().filter(|(_, row)| row.name.as_deref() == Some(name)) {
            (found, _) = (true, out.insert(k));
        }
        for (_, rows) in plan.made.iter().filter(|(maker, _)| maker == name) {
            found = true;
            out.extend(rows.clone());
        }
        if !found {
            let known = plan.rows.iter().filter_map(|row| row.name.as_deref());
            let known = known.chain(plan.made.iter().map(|(maker, _)| maker.as_str()));
            let message = format!("the run has no body and no generator that is called `{name}`");
            return Err(Problem::at(node.span, message)
                .expecting("a name of the run's scene")
                .near(name, known));
        }
    }
    Ok(out)
}

/// The centre of mass of a shape, in its frame.
pub(crate) fn center(shape: &Shape) -> Vec3 {
    shape.mass_properties(1.0).map_or(Vec3::ZERO, |mass| mass.center)
}
