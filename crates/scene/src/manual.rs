//! The lists of keys in `docs/scene.md`, made from the tables of keys.

use crate::body::BODY;
use crate::cameras::{CAMERAS, KEY};
use crate::generators::GENERATORS;
use crate::import::IMPORT;
use crate::region::REGIONS;
use crate::root::{MATERIAL, OUTPUT, ROOT, WORLD};
use crate::rotation::AXIS_DEGREES;
use crate::shapes::{PART, SHAPES};
use crate::sizes::SIZES;
use crate::spec::{Fallback, Spec};
use crate::start::START;
use crate::terrain::TERRAIN;
use crate::visual::VISUAL;
use std::fmt::Write;

/// Every key of scene files in Markdown: type, default, meaning and unit, with examples. The second half of
/// `docs/scene.md` is this text.
pub fn keys() -> String {
    let mut out = String::new();
    section(&mut out, "## The file", &ROOT, false);
    section(&mut out, "## `[world]`", &WORLD, false);
    section(&mut out, "## `[output]`", &OUTPUT, false);
    section(&mut out, "## `[start]`", &START, false);
    section(&mut out, "## `[materials.NAME]`", &MATERIAL, false);
    heading(&mut out, "## `[shapes.NAME]`", "The key `kind` says what it is.");
    for spec in SHAPES.cases {
        section(&mut out, &format!("### `kind = \"{}\"`", spec.name), spec, true);
    }
    section(&mut out, "### A part of a compound", &PART, false);
    section(&mut out, "### The table `terrain`", &TERRAIN, false);
    section(&mut out, "### The table `visual`", &VISUAL, false);
    section(&mut out, "## `[[bodies]]`", &BODY, false);
    section(&mut out, "### A rotation as a table", &AXIS_DEGREES, false);
    section(&mut out, "## `[[imports]]`", &IMPORT, false);
    heading(&mut out, "## `[[generators]]`", "The key `kind` says what it makes.");
    for spec in GENERATORS.cases {
        section(&mut out, &format!("### `kind = \"{}\"`", spec.name), spec, true);
    }
    section(&mut out, "### The table `size`", &SIZES, false);
    heading(&mut out, "### The table `region`", "Where a fill may put bodies. Without `kind` it is a box.");
    for spec in REGIONS.cases {
        section(&mut out, &format!("#### Region `kind = \"{}\"`", spec.name), spec, true);
    }
    heading(&mut out, "## `[[cameras]]`", "The key `kind` says how it moves; without it, it stands still.");
    for spec in CAMERAS.cases {
        section(&mut out, &format!("### Camera `kind = \"{}\"`", spec.name), spec, true);
    }
    section(&mut out, "### A key of a camera", &KEY, false);
    out
}

// Writing to a String can't fail, so its results are not looked at below.

fn heading(out: &mut String, title: &str, about: &str) {
    let gap = if out.is_empty() { "" } else { "\n" };
    let _ = write!(out, "{gap}{title}\n\n{about}\n");
}

fn section(out: &mut String, title: &str, spec: &Spec, kind: bool) {
    heading(out, title, spec.about);
    let _ = write!(
        out,
        "\n```toml\n{}```\n\n| key | type | default | meaning |\n|---|---|---|---|\n",
        spec.example
    );
    if kind {
        let _ = writeln!(out, "| `kind` | `{}` | | |", spec.name);
    }
    for key in spec.keys() {
        let default = match key.fallback {
            Fallback::Required => "needed".to_owned(),
            Fallback::Absent => String::new(),
            Fallback::Default(text) => format!("`{}`", text.trim_matches('"')),
        };
        let _ = writeln!(out, "| `{}` | {} | {default} | {} |", key.name, type_of(key), key.about);
    }
}

fn type_of(key: &crate::spec::Key) -> String {
    use crate::spec::Ty;
    match key.ty {
        // The general words would list the keys of the table, which have a section of their own.
        Ty::Table(_) | Ty::Kinds(_) => "a table".to_owned(),
        ty => ty.expected(),
    }
}

#[cfg(test)]
mod tests {
    use crate::Scene;
    use crate::generators::GENERATORS;
    use crate::shapes::SHAPES;

    #[test]
    fn every_example_of_the_manual_is_right() {
        let shapes: String = SHAPES.cases.iter().map(|c| c.example).collect();
        let generators: String = GENERATORS.cases.iter().map(|c| c.example).collect();
        let others =
            [&super::WORLD, &super::OUTPUT, &super::MATERIAL, &super::BODY].map(|s| s.example).concat();
        let text = format!("{others}{shapes}{generators}");
        if let Err(error) = Scene::parse(&text, "manual", ".") {
            panic!("{}", error.render(false));
        }
        let nested =
            [&super::SIZES, super::REGIONS.cases[0], super::REGIONS.cases[1], super::REGIONS.cases[2]];
        for spec in nested {
            let fill = "[[generators]]\nkind = \"fill\"\nshape = \"ball\"\ncount = 5\n";
            let region =
                if spec.name == "size" { "region = { min = [0, 0, 0], max = [9, 9, 9] }\n" } else { "" };
            let text = format!("{shapes}{fill}{region}{}", spec.example);
            if let Err(error) = Scene::parse(&text, spec.name, ".") {
                panic!("{}", error.render(false));
            }
        }
        let part = format!(
            "{shapes}[shapes.x]\nkind = \"compound\"\n{}[[bodies]]\nshape = \"x\"\n",
            super::PART.example
        );
        assert!(Scene::parse(&part, "part", ".").is_ok());
        let visual = format!("{}[[bodies]]\nshape = \"crate\"\n", super::VISUAL.example);
        assert!(Scene::parse(&visual, "visual", ".").is_ok());
        let terrain =
            format!("[shapes.x]\nkind = \"mesh\"\n{}[[bodies]]\nshape = \"x\"\n", super::TERRAIN.example);
        assert!(Scene::parse(&terrain, "terrain", ".").is_ok());
        let turned = format!("{shapes}[[bodies]]\nshape = \"ball\"\n{}", super::AXIS_DEGREES.example);
        assert!(Scene::parse(&turned, "rotation", ".").is_ok());
        let hammer = format!("{shapes}[[bodies]]\nname = \"hammer\"\nshape = \"ball\"\n");
        let cameras: String = super::CAMERAS.cases.iter().map(|c| c.example).collect();
        assert!(Scene::parse(&format!("{hammer}{cameras}"), "cameras", ".").is_ok());
        assert!(Scene::parse(super::ROOT.example, "scene", ".").is_ok());
        // Right but for the run, which is not there.
        let start = Scene::parse(super::START.example, "start", ".").unwrap_err();
        assert!(
            start.problems().len() == 1 && start.to_string().contains("runs/fill-1 is not a run"),
            "{start}"
        );
    }
}
