//! The keys of a scene file and of its tables `[world]`, `[output]` and `[materials.NAME]`, and how they are read.

use crate::body::BODY;
use crate::cameras::CAMERAS;
use crate::error::Problem;
use crate::generators::GENERATORS;
use crate::import::IMPORT;
use crate::node::Table;
use crate::shapes::SHAPES;
use crate::spec::{ANY, Kinds, NOT_NEGATIVE, POSITIVE, Range, SHARE, Spec, Ty, key, optional};
use crate::start::START;
use rockfall::{Integrator, Material, Mix, Quality, Settings, Solver};

/// A scene file.
pub(crate) static ROOT: Spec = Spec {
    name: "scene",
    about: "A scene file.",
    example: r#"[shapes.ball]
kind = "sphere"
radius = 0.5

[[bodies]]
shape = "ball"
position = [0, 0, 10]
"#,
    groups: &[&[
        key(
            "include",
            Ty::Texts,
            "[]",
            "Scene files to read before this one, relative to it. Their materials, shapes, bodies and generators come \
             first; a key of `[world]`, `[output]` or `[start]` that is set here wins over theirs. A file that is included twice is read \
             once.",
        ),
        key("world", Ty::Table(&WORLD), "{}", "What holds for the whole scene."),
        key("output", Ty::Table(&OUTPUT), "{}", "What a run writes of each body at each frame."),
        optional("start", Ty::Table(&START), "A frame of another run to begin with."),
        key(
            "materials",
            Ty::Named(&Ty::Table(&MATERIAL)),
            "{}",
            "Materials by name. A scene that defines no `default` has one with all defaults.",
        ),
        key(
            "shapes",
            Ty::Named(&Ty::Kinds(SHAPE_KINDS)),
            "{}",
            "Shapes by name, shared by any number of bodies.",
        ),
        key("bodies", Ty::List(&Ty::Table(&BODY)), "[]", "Bodies, one by one."),
        key("imports", Ty::List(&Ty::Table(&IMPORT)), "[]", "Scenes of other programs."),
        key("generators", Ty::List(&Ty::Kinds(GENERATOR_KINDS)), "[]", "Bodies in bulk."),
        key(
            "cameras",
            Ty::List(&Ty::Kinds(CAMERA_KINDS)),
            "[]",
            "Cameras for pictures. Where there is none, a picture finds a place from which what moves is to be seen.",
        ),
    ]],
};

static SHAPE_KINDS: &Kinds = &SHAPES;
static GENERATOR_KINDS: &Kinds = &GENERATORS;
static CAMERA_KINDS: &Kinds = &CAMERAS;

pub(crate) const SOLVERS: &[&str] = &["soft-step", "impulse", "reflect"];
const QUALITIES: &[&str] = &["draft", "default", "fine"];
pub(crate) const INTEGRATORS: &[&str] = &["second-order", "semi-implicit"];
const RATE: Range = Range { min: 1.0, max: 100_000.0 };

pub(crate) static WORLD: Spec = Spec {
    name: "world",
    about: "What holds for the whole scene.",
    example: r#"[world]
gravity = [0, 0, -3.71] # Mars
duration = 10
substeps = 8
"#,
    groups: &[&[
        key(
            "gravity",
            Ty::Numbers(&[3], ANY),
            "[0, 0, -9.81]",
            "m/s². z is up. Where it is not given, that of the first of `[[imports]]` which has one.",
        ),
        key("rate", Ty::Number(RATE), "60", "Frames per second of simulated time."),
        key(
            "quality",
            Ty::Choice(QUALITIES),
            "\"default\"",
            "Accuracy against speed: what `substeps`, `contact_hertz`, `bounce_sweeps` and `integrator` are where they are not given. `draft`: 2, 60, 1, \
             semi-implicit; `default`: 4, 60, 1, semi-implicit; `fine`: 8, 120, 64, second-order.",
        ),
        optional("substeps", Ty::Int(1, 1000), "Sub-steps in a frame; 4 at default quality."),
        key(
            "solver",
            Ty::Choice(SOLVERS),
            "\"soft-step\"",
            "How contacts are answered: `soft-step` carries large piles; `impulse` and `reflect` are the two responses \
             of the report.",
        ),
        optional(
            "integrator",
            Ty::Choice(INTEGRATORS),
            "`soft-step`: how bodies in free flight move. `second-order` is exact under gravity; `semi-implicit` Euler is ½ g h off for each second, \
             h the length of a sub-step.",
        ),
        optional("duration", Ty::Number(POSITIVE), "Simulated time, s; another way to say `frames`."),
        optional("frames", Ty::Int(1, 1_000_000_000), "Frames to simulate. 300 where neither is given."),
        key("seed", Ty::Int(0, u64::MAX), "1", "All random numbers of the scene come from it."),
        optional(
            "contact_hertz",
            Ty::Number(POSITIVE),
            "`soft-step`: natural frequency of the position correction, Hz; never used above a quarter of the rate of the sub-steps.",
        ),
        key(
            "contact_damping",
            Ty::Number(NOT_NEGATIVE),
            "0.5",
            "`soft-step`: damping ratio of the position correction; 1 is critical, larger is slower.",
        ),
        key("push_speed", Ty::Number(POSITIVE), "3", "Overlaps are pushed apart at most this fast, m/s."),
        key(
            "restitution_threshold",
            Ty::Number(NOT_NEGATIVE),
            "1",
            "Contacts that close more slowly than this don't bounce, m/s.",
        ),
        optional(
            "bounce_sweeps",
            Ty::Int(1, 10_000),
            "`soft-step`: sweeps of restitution, at most. One does for bodies that hit one by one; heaps of elastic bodies want more.",
        ),
        key("sleeping", Ty::Bool, "true", "Bodies at rest fall asleep and cost nothing."),
        key(
            "sleep_speed",
            Ty::Number(NOT_NEGATIVE),
            "0.05",
            "A body is at rest when no point of it is faster, m/s.",
        ),
        key(
            "sleep_time",
            Ty::Number(NOT_NEGATIVE),
            "0.5",
            "A group of touching bodies sleeps after so long at rest, s.",
        ),
        key("continuous", Ty::Bool, "true", "Fast bodies are stopped at what they would pass through."),
    ]],
};

/// Bounds that [`Output`] can have, m.
const POSITION_ERROR: Range = Range { min: 1e-6, max: 1000.0 };
/// The same in degrees: what two bytes a number resolve, and an angle beyond which nothing is recognised.
const ROTATION_ERROR: Range = Range { min: 0.0075, max: 20.0 };

pub(crate) static OUTPUT: Spec = Spec {
    name: "output",
    about: "What a run writes of each body at each frame. It changes nothing of the simulation, and nothing of its hash.",
    example: r#"[output]
position_error = 0.0001 # a tenth of a millimetre
rotation_error = 0.1
"#,
    groups: &[&[
        optional(
            "position_error",
            Ty::Number(POSITION_ERROR),
            "Positions on disk may be off by so much, m, and take less space. As they are, in single precision, where not given.",
        ),
        optional(
            "rotation_error",
            Ty::Number(ROTATION_ERROR),
            "Rotations on disk may be off by so much, degrees. As they are, in single precision, where not given.",
        ),
        key("velocities", Ty::Bool, "false", "Velocities are written as well, in single precision."),
        key(
            "contacts",
            Ty::Bool,
            "false",
            "Contacts are written as well: points at which surfaces touch or overlap, or which carry a load.",
        ),
        key("contacts_every", Ty::Int(1, 1_000_000_000), "1", "Those of every so many frames alone."),
        key("contacts_force", Ty::Number(NOT_NEGATIVE), "0", "Only those that press at least this much, N."),
        key(
            "events",
            Ty::Choice(EVENTS),
            "\"sensors\"",
            "`sensors`: who comes into sensors and leaves them, where the scene has any; `all`: also which bodies begin to touch and cease.",
        ),
        optional(
            "hits",
            Ty::Number(NOT_NEGATIVE),
            "Which bodies press each other by more than this in a step, N s, is written among the events. What rests presses by its weight times the \
             length of a step.",
        ),
        key(
            "columns",
            Ty::Choices(COLUMNS),
            "[]",
            "More of each body at each frame: `speed` of the centre of mass, m/s; `kinetic_energy`, J; `contact_count`, points at which it touches \
             others; `contact_force`, the sum of the normal forces on it, N; `asleep`, 1 or 0.",
        ),
    ]],
};

const EVENTS: &[&str] = &["none", "sensors", "all"];
const COLUMNS: &[&str] = &["speed", "kinetic_energy", "contact_count", "contact_force", "asleep"];

/// What a run writes of each body at each frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Output {
    /// Positions may be off by so much, metres; as they are where `None`.
    pub position_error: Option<f64>,
    /// Rotations may be off by so much, degrees; as they are where `None`.
    pub rotation_error: Option<f64>,
    /// Velocities are written as well.
    pub velocities: bool,
    /// Contacts are, of every so many frames and from so much force on, N; none where `None`.
    pub contacts: Option<(u64, f64)>,
    /// Events of sensors are.
    pub sensors: bool,
    /// So is which bodies begin to touch and cease.
    pub touches: bool,
    /// So is which bodies press each other by more than this in a step, N s.
    pub hits: Option<f64>,
    /// Further columns, by the words of scene files.
    pub columns: Vec<String>,
}

/// What `[output]` says.
pub(crate) fn output(table: &Table) -> Output {
    let given = |key| table.has(key).then(|| table.f64(key));
    Output {
        position_error: given("position_error"),
        rotation_error: given("rotation_error"),
        velocities: table.bool("velocities"),
        contacts: table.bool("contacts").then(|| (table.int("contacts_every"), table.f64("contacts_force"))),
        sensors: table.text("events") != "none",
        touches: table.text("events") == "all",
        hits: given("hits"),
        columns: table.list("columns").iter().map(|node| node.value.text().to_owned()).collect(),
    }
}

pub(crate) const MIXES: &[&str] = &["average", "geometric-mean", "minimum", "product", "maximum"];
const FRICTION: Range = Range { min: 0.0, max: 1000.0 };

pub(crate) static MATERIAL: Spec = Spec {
    name: "material",
    about: "What a surface is made of. The defaults are those of rock.",
    example: r#"[materials.ice]
density = 917
friction = 0.03
friction_mix = "minimum"
"#,
    groups: &[&[
        key("density", Ty::Number(POSITIVE), "2600", "kg/m³."),
        key(
            "restitution",
            Ty::Number(SHARE),
            "0",
            "0 stops dead, 1 bounces back to the start (the report's μ_N).",
        ),
        key("friction", Ty::Number(FRICTION), "0.6", "Coulomb's coefficient (the report's μ_T)."),
        key(
            "rolling_friction",
            Ty::Number(NOT_NEGATIVE),
            "0",
            "Lever arm of the torque against rolling, m: the torque is at most this times the normal force.",
        ),
        key(
            "twisting_friction",
            Ty::Number(NOT_NEGATIVE),
            "0",
            "Lever arm of the torque against spinning on the spot, m.",
        ),
        key(
            "friction_mix",
            Ty::Choice(MIXES),
            "\"geometric-mean\"",
            "How the friction of two materials becomes one. Of two different rules the later in this list wins.",
        ),
        key("restitution_mix", Ty::Choice(MIXES), "\"maximum\"", "The same for restitution."),
        optional("color", Ty::Color, "Of bodies that have none of their own, nor by their shape."),
    ]],
};

/// The settings of `[world]`, with as many threads and lanes as the machine has.
pub(crate) fn settings(world: &Table) -> Settings {
    let base = Settings::of(match world.text("quality") {
        "draft" => Quality::Draft,
        "fine" => Quality::Fine,
        _ => Quality::Default,
    });
    let whole = |key, otherwise: u32| if world.has(key) { world.int(key) as u32 } else { otherwise };
    Settings {
        gravity: world.vec3("gravity"),
        rate: world.f32("rate"),
        substeps: whole("substeps", base.substeps),
        bounce_sweeps: whole("bounce_sweeps", base.bounce_sweeps),
        solver: match world.text("solver") {
            "impulse" => Solver::Impulse,
            "reflect" => Solver::Reflect,
            _ => Solver::SoftStep,
        },
        integrator: match world.has("integrator").then(|| world.text("integrator")) {
            Some("second-order") => Integrator::SecondOrder,
            Some(_) => Integrator::SemiImplicit,
            None => base.integrator,
        },
        contact_hertz: match world.has("contact_hertz") {
            true => world.f32("contact_hertz"),
            false => base.contact_hertz,
        },
        contact_damping: world.f32("contact_damping"),
        push_speed: world.f32("push_speed"),
        restitution_threshold: world.f32("restitution_threshold"),
        sleeping: world.bool("sleeping"),
        sleep_speed: world.f32("sleep_speed"),
        sleep_time: world.f32("sleep_time"),
        continuous: world.bool("continuous"),
        ..base
    }
}

/// The word for a solver.
pub(crate) fn solver_word(solver: Solver) -> &'static str {
    match solver {
        Solver::SoftStep => "soft-step",
        Solver::Impulse => "impulse",
        Solver::Reflect => "reflect",
    }
}

/// Frames to simulate, from `frames` or `duration`.
pub(crate) fn frames(world: &Table) -> Result<u64, Problem> {
    match (world.has("frames"), world.has("duration")) {
        (true, true) => {
            let span = world.span_of("duration");
            Err(Problem::at(span, "`world` has both `frames` and `duration`").expecting("one of them"))
        }
        (true, false) => Ok(world.int("frames")),
        (false, true) => {
            let frames = (world.f64("duration") * world.f64("rate")).round().max(1.0);
            if frames > 1e9 {
                let message = format!("`world.duration` makes {frames} frames");
                return Err(Problem::at(world.span_of("duration"), message).expecting("at most 1e9"));
            }
            Ok(frames as u64)
        }
        (false, false) => Ok(300),
    }
}

pub(crate) fn material(table: &Table) -> Material {
    let mix = |key| match table.text(key) {
        "average" => Mix::Average,
        "minimum" => Mix::Minimum,
        "product" => Mix::Product,
        "maximum" => Mix::Maximum,
        _ => Mix::GeometricMean,
    };
    Material {
        density: table.f32("density"),
        restitution: table.f32("restitution"),
        friction: table.f32("friction"),
        rolling_friction: table.f32("rolling_friction"),
        twisting_friction: table.f32("twisting_friction"),
        friction_mix: mix("friction_mix"),
        restitution_mix: mix("restitution_mix"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;

    #[test]
    fn defaults_are_those_of_the_library() {
        let text =
            "[materials.rock]\n[shapes.ball]\nkind = \"sphere\"\nradius = 1\n[[bodies]]\nshape = \"ball\"\n";
        let scene = Scene::parse(text, "x", ".").unwrap();
        assert_eq!(scene.settings, Settings::default());
        assert_eq!(scene.plan().unwrap().materials, [Material::default(), Material::default()]);
    }

    #[test]
    fn a_quality_is_what_is_not_given() {
        let parse = |text: &str| Scene::parse(text, "x", ".").unwrap_or_else(|error| panic!("{error}"));
        let body = "[shapes.ball]\nkind = \"sphere\"\nradius = 1\n[[bodies]]\nshape = \"ball\"\n";
        for (word, quality) in
            [("draft", Quality::Draft), ("default", Quality::Default), ("fine", Quality::Fine)]
        {
            let scene = parse(&format!("[world]\nquality = \"{word}\"\n{body}"));
            assert_eq!(scene.settings, Settings::of(quality));
            assert_eq!(parse(&scene.to_toml_filled()).settings, scene.settings);
        }
        let scene = parse(&format!("[world]\nquality = \"fine\"\nsubsteps = 5\ncontact_hertz = 30\n{body}"));
        let given = Settings { substeps: 5, contact_hertz: 30.0, ..Settings::of(Quality::Fine) };
        assert_eq!(scene.settings, given);
    }
}
