//! The keys of `[[cameras]]`, and the cameras that they describe. They change nothing of a simulation.

use crate::error::Problem;
use crate::node::Table;
use crate::spec::{ANY, Key, Kinds, NOT_NEGATIVE, POSITIVE, Range, Spec, Ty, key, optional, required};
use rockfall_math::DVec3;

const FOV: Range = Range { min: 1.0, max: 150.0 };
const DEGREES: Range = Range { min: -89.0, max: 89.0 };

/// What every camera has.
const LENS: &[Key] = &[
    required("name", Ty::Text, "By which pictures ask for it."),
    key("fov", Ty::Number(FOV), "35", "Vertical field of view, degrees."),
    key(
        "aperture",
        Ty::Number(NOT_NEGATIVE),
        "0",
        "Diameter of the lens, m: what is not in focus is blurred. All is sharp with 0.",
    ),
    optional(
        "focus",
        Ty::Number(POSITIVE),
        "Distance at which things are sharp, m. That of the target where not given.",
    ),
];

static FIXED_KEYS: Spec = Spec {
    name: "fixed",
    about: "It stands still.",
    example: r#"[[cameras]]
name = "valley"
kind = "fixed"
position = [20, -60, 25]
target = [0, 0, 5]
"#,
    groups: &[
        LENS,
        &[
            required("position", Ty::Numbers(&[3], ANY), "Where it is, m."),
            required("target", Ty::Numbers(&[3], ANY), "What is in the middle of its picture, m."),
        ],
    ],
};

static ORBIT_KEYS: Spec = Spec {
    name: "orbit",
    about: "It goes around something.",
    example: r#"[[cameras]]
name = "around"
kind = "orbit"
target = [0, 0, 1]
distance = 12
speed = 20
"#,
    groups: &[
        LENS,
        &[
            key("target", Ty::Numbers(&[3], ANY), "[0, 0, 0]", "What it goes around, m."),
            required("distance", Ty::Number(POSITIVE), "How far away it is, m."),
            key("elevation", Ty::Number(DEGREES), "25", "How high above the horizon of the target, degrees."),
            key("azimuth", Ty::Number(ANY), "-60", "Where it begins, degrees about z from the x axis."),
            key(
                "speed",
                Ty::Number(ANY),
                "15",
                "Degrees per second of simulated time, counter-clockwise seen from above.",
            ),
        ],
    ],
};

static FOLLOW_KEYS: Spec = Spec {
    name: "follow",
    about: "It goes with a body, and does not turn with it.",
    example: r#"[[cameras]]
name = "beside"
kind = "follow"
body = "hammer"
offset = [4, -8, 3]
"#,
    groups: &[
        LENS,
        &[
            required("body", Ty::Text, "Name of one of `[[bodies]]`."),
            key(
                "offset",
                Ty::Numbers(&[3], ANY),
                "[6, -9, 4]",
                "Where it is, seen from the origin of the body's shape, m.",
            ),
        ],
    ],
};

static KEYS_KEYS: Spec = Spec {
    name: "keys",
    about: "It goes from place to place, on a smooth way through all of them.",
    example: r#"[[cameras]]
name = "flight"
kind = "keys"
keys = [
    { time = 0, position = [30, -40, 20], target = [0, 0, 5] },
    { time = 4, position = [10, -20, 6], target = [0, 0, 1] },
]
"#,
    groups: &[
        LENS,
        &[required("keys", Ty::List(&Ty::Table(&KEY)), "At least one, each later than the one before.")],
    ],
};

/// A place of a camera at a time.
pub(crate) static KEY: Spec = Spec {
    name: "key",
    about: "Where a camera is at a time.",
    example: r#"keys = [{ time = 2.5, position = [10, -20, 6], target = [0, 0, 1] }]
"#,
    groups: &[&[
        required("time", Ty::Number(NOT_NEGATIVE), "Simulated time, s."),
        required("position", Ty::Numbers(&[3], ANY), "Where it is, m."),
        required("target", Ty::Numbers(&[3], ANY), "What is in the middle of its picture, m."),
    ]],
};

pub(crate) static CAMERAS: Kinds = Kinds {
    name: "camera",
    default: Some("fixed"),
    cases: &[&FIXED_KEYS, &ORBIT_KEYS, &FOLLOW_KEYS, &KEYS_KEYS],
};

/// A camera of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneCamera {
    /// Its name, which no other one has.
    pub name: String,
    /// Vertical field of view, degrees.
    pub fov: f32,
    /// Diameter of the lens, metres; 0 where all is sharp.
    pub aperture: f64,
    /// Distance at which things are sharp, metres; that of the target where `None`.
    pub focus: Option<f64>,
    /// How it moves.
    pub course: Course,
}

/// How a camera moves. Places are in the world's frame, metres.
#[derive(Clone, Debug, PartialEq)]
pub enum Course {
    /// Not at all.
    Fixed {
        /// Where it is.
        position: DVec3,
        /// What is in the middle of its picture.
        target: DVec3,
    },
    /// Around something.
    Orbit {
        /// What it goes around.
        target: DVec3,
        /// How far away it is, metres.
        distance: f64,
        /// Above the horizon of the target, radians.
        elevation: f64,
        /// About z from the x axis at time 0, radians.
        azimuth: f64,
        /// Radians per second, counter-clockwise from above.
        speed: f64,
    },
    /// With a body.
    Follow {
        /// Its name.
        body: String,
        /// From the origin of its shape.
        offset: DVec3,
    },
    /// From place to place: time in seconds, ascending, place and target. At least one.
    Keys(Vec<(f64, DVec3, DVec3)>),
}

/// The cameras of the scene `root`, in the order of the file.
pub(crate) fn cameras(root: &Table) -> Vec<SceneCamera> {
    root.tables("cameras").map(camera).collect()
}

fn camera(table: &Table) -> SceneCamera {
    let course = match table.spec.name {
        "orbit" => Course::Orbit {
            target: table.dvec3("target"),
            distance: table.f64("distance"),
            elevation: table.f64("elevation").to_radians(),
            azimuth: table.f64("azimuth").to_radians(),
            speed: table.f64("speed").to_radians(),
        },
        "follow" => Course::Follow { body: table.text("body").to_owned(), offset: table.dvec3("offset") },
        "keys" => {
            let key = |table: &Table| (table.f64("time"), table.dvec3("position"), table.dvec3("target"));
            Course::Keys(table.tables("keys").map(key).collect())
        }
        _ => Course::Fixed { position: table.dvec3("position"), target: table.dvec3("target") },
    };
    SceneCamera {
        name: table.text("name").to_owned(),
        fov: table.f32("fov"),
        aperture: table.f64("aperture"),
        focus: table.has("focus").then(|| table.f64("focus")),
        course,
    }
}

/// What the types of the keys can't say.
pub(crate) fn check(root: &Table, problems: &mut Vec<Problem>) {
    let mut names: Vec<&str> = Vec::new();
    for table in root.tables("cameras") {
        let name = table.text("name");
        if names.contains(&name) {
            let message = format!("two cameras have the same name `{name}`");
            problems.push(Problem::at(table.span_of("name"), message).expecting("another name"));
        }
        names.push(name);
        let nowhere = |place: DVec3, target: DVec3| (place - target).length_squared() < 1e-12;
        let stuck = |key: &str, of: &Table| {
            let message = format!("`{}` is where the camera is", of.path_of(key));
            Problem::at(of.span_of(key), message).expecting("another place")
        };
        match camera(table).course {
            Course::Fixed { position, target } if nowhere(position, target) => {
                problems.push(stuck("target", table))
            }
            Course::Follow { offset, .. } if nowhere(offset, DVec3::ZERO) => {
                let message = format!("`{}` has no length", table.path_of("offset"));
                problems.push(Problem::at(table.span_of("offset"), message).expecting("a way from the body"));
            }
            Course::Follow { body, .. } => {
                let bodies: Vec<&str> = root
                    .tables("bodies")
                    .map(|body| body.text("name"))
                    .filter(|name| !name.is_empty())
                    .collect();
                if !bodies.contains(&body.as_str()) {
                    let problem = Problem::at(table.span_of("body"), format!("no body is called `{body}`"));
                    problems.push(problem.expecting("the name of one of `[[bodies]]`").near(&body, bodies));
                }
            }
            Course::Keys(keys) if keys.is_empty() => {
                let message = format!("`{}` is empty", table.path_of("keys"));
                problems.push(Problem::at(table.span_of("keys"), message).expecting("at least one key"));
            }
            Course::Keys(keys) => {
                for (pair, key) in keys.windows(2).zip(table.tables("keys").skip(1)) {
                    if pair[1].0 <= pair[0].0 {
                        let message = format!("`{}` is not later than the key before", key.path_of("time"));
                        problems
                            .push(Problem::at(key.span_of("time"), message).expecting("times that ascend"));
                    }
                }
                let bad =
                    table.tables("keys").find(|key| nowhere(key.dvec3("position"), key.dvec3("target")));
                problems.extend(bad.map(|key| stuck("target", key)));
            }
            Course::Fixed { .. } | Course::Orbit { .. } => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Scene;

    const SCENE: &str =
        "[shapes.ball]\nkind = \"sphere\"\nradius = 1\n[[bodies]]\nname = \"hammer\"\nshape = \"ball\"\n";

    #[test]
    fn every_kind_is_read_and_reads_back_from_the_filled_scene() {
        let examples: String = CAMERAS.cases.iter().map(|case| case.example).collect();
        let scene =
            Scene::parse(&format!("{SCENE}{examples}"), "cameras", ".").unwrap_or_else(|e| panic!("{e}"));
        let cameras = scene.cameras();
        let names: Vec<&str> = cameras.iter().map(|camera| camera.name.as_str()).collect();
        assert_eq!(names, ["valley", "around", "beside", "flight"]);
        assert!(
            matches!(&cameras[1].course, Course::Orbit { speed, .. } if (speed - 20_f64.to_radians()).abs() < 1e-12)
        );
        assert!(matches!(&cameras[3].course, Course::Keys(keys) if keys.len() == 2 && keys[1].0 == 4.0));
        assert_eq!((cameras[0].fov, cameras[0].aperture, cameras[0].focus), (35.0, 0.0, None));
        let again = Scene::parse(&scene.to_toml_filled(), "filled", ".").unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(again.cameras(), cameras);
    }

    #[test]
    fn cameras_that_make_no_sense_are_refused() {
        for (camera, expected) in [
            ("name = \"a\"\nposition = [1, 2, 3]\ntarget = [1, 2, 3]", "is where the camera is"),
            ("name = \"a\"\nkind = \"follow\"\nbody = \"hamer\"", "no body is called `hamer`"),
            ("name = \"a\"\nkind = \"follow\"\nbody = \"hammer\"\noffset = [0, 0, 0]", "has no length"),
            ("name = \"a\"\nkind = \"keys\"\nkeys = []", "is empty"),
            (
                "name = \"a\"\nkind = \"keys\"\nkeys = [{ time = 1, position = [1, 0, 0], target = [0, 0, 0] }, \
                 { time = 1, position = [1, 0, 0], target = [0, 0, 0] }]",
                "is not later than the key before",
            ),
            ("name = \"a\"\nkind = \"orbit\"", "`cameras.1.distance` is missing"),
            (
                "name = \"a\"\nkind = \"orbit\"\ndistance = 1\n[[cameras]]\nname = \"a\"\nkind = \"orbit\"\ndistance = 1",
                "two cameras have the same name `a`",
            ),
        ] {
            let text = format!("{SCENE}[[cameras]]\n{camera}\n");
            let error = Scene::parse(&text, "cameras", ".").expect_err(camera).to_string();
            assert!(error.contains(expected), "{error}");
        }
    }
}
