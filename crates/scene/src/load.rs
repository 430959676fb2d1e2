//! From files to one checked tree: reading, includes, merging, and what concerns more than one table.

use crate::check::Checker;
use crate::error::{Problem, SceneError};
use crate::node::{Node, Table, Value};
use crate::root::{MATERIAL, ROOT};
use crate::shapes::Nesting;
use crate::source::{Source, Sources, Span};
use crate::spec::Ty;
use crate::{body, cameras, generators, import, nesting, root, shapes};
use rockfall_import::Content;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use toml::de::DeTable;

/// Scene files are written by people; what is larger is something else.
const LARGEST_FILE: u64 = 16 << 20;
/// Includes in includes in includes.
const DEEPEST: usize = 16;

/// Reads files that include one another.
#[derive(Default)]
pub(crate) struct Loader {
    pub(crate) sources: Sources,
    problems: Vec<Problem>,
    /// Files that are being read, outermost first: their true paths, and their names for people.
    chain: Vec<(PathBuf, String)>,
    /// True paths of the files that have been read.
    done: Vec<PathBuf>,
    /// Checked files, each after those that it includes.
    roots: Vec<Table>,
}

/// A scene that has been read: one tree of all files, their texts, and what files of other programs hold, in the order of `[[imports]]`.
pub(crate) struct Loaded {
    pub(crate) root: Table,
    pub(crate) sources: Sources,
    pub(crate) imports: Vec<Arc<Content>>,
}

impl Loader {
    /// Reads the file at `path` and all that it includes. `from` is where it is included.
    pub(crate) fn file(&mut self, path: &Path, from: Option<Span>) {
        let name = path.display().to_string();
        let problem = |message: String| match from {
            Some(span) => Problem::at(span, message),
            None => Problem::new(message),
        };
        let text = match import::scene_of(path).map_or_else(|| read(path), Ok) {
            Ok(text) => text,
            Err((message, expected)) => {
                self.problems.push(problem(format!("{name} {message}")).expecting(expected));
                return;
            }
        };
        // Two spellings of one path are one file.
        let truth = path.canonicalize().unwrap_or_else(|_| path.to_owned());
        if let Some(at) = self.chain.iter().position(|(p, _)| *p == truth) {
            let mut names: Vec<&str> = self.chain[at..].iter().map(|(_, n)| n.as_str()).collect();
            names.push(&name);
            let message = format!("files include one another: {}", names.join(" → "));
            self.problems.push(problem(message).expecting("includes that come to an end"));
            return;
        }
        if self.done.contains(&truth) {
            return;
        }
        if self.chain.len() >= DEEPEST {
            let message = format!("{name} is included more than {DEEPEST} files deep");
            self.problems.push(problem(message).expecting("fewer includes in includes"));
            return;
        }
        let base = path.parent().map_or_else(PathBuf::new, Path::to_owned);
        self.chain.push((truth.clone(), name.clone()));
        self.text(Source { name, text, base });
        self.chain.pop();
        self.done.push(truth);
    }

    /// Reads a text and all that it includes.
    pub(crate) fn text(&mut self, source: Source) {
        let (text, base) = (source.text.clone(), source.base.clone());
        let index = self.sources.add(source);
        if let Some(at) = nesting::too_deep(&text) {
            let span = Span { source: index, start: at as u32, end: at as u32 + 1 };
            let expected = format!("brackets at most {} deep", nesting::DEEPEST);
            self.problems.push(Problem::at(span, "too many brackets in brackets").expecting(expected));
            return;
        }
        let raw = match DeTable::parse(&text) {
            Ok(raw) => raw,
            Err(error) => {
                let bytes = error.span().unwrap_or(0..0);
                let span = Span { source: index, start: bytes.start as u32, end: bytes.end as u32 };
                self.problems.push(Problem::at(span, format!("not TOML: {}", error.message())));
                return;
            }
        };
        let whole = Span { source: index, start: 0, end: 0 };
        let mut checker = Checker { source: index, problems: &mut self.problems };
        let table = checker.table(&ROOT, raw.get_ref(), whole, "", false);
        let includes: Vec<(PathBuf, Span)> =
            table.list("include").iter().map(|n| (base.join(n.value.text()), n.span)).collect();
        for (path, span) in includes {
            self.file(&path, Some(span));
        }
        self.roots.push(table);
    }

    /// One tree of all files.
    pub(crate) fn finish(mut self) -> Result<Loaded, SceneError> {
        let roots = std::mem::take(&mut self.roots);
        let merged = merge(roots, &mut self.problems);
        if self.problems.is_empty() {
            let mut root = merged.unwrap_or_else(|| Table {
                spec: &ROOT,
                span: Span::default(),
                path: String::new(),
                entries: Vec::new(),
            });
            absolute_paths(&mut root, &self.sources);
            let imports = import::read_all(&mut root, &mut self.problems);
            complete(&mut root, &mut self.problems);
            if self.problems.is_empty() {
                return Ok(Loaded { root, sources: self.sources, imports });
            }
        }
        Err(SceneError::new(self.problems, &self.sources))
    }
}

/// The text of a scene file, or what is wrong with the file and what was expected.
fn read(path: &Path) -> Result<String, (String, &'static str)> {
    use std::io::{ErrorKind, Read};
    let failed = |error: std::io::Error| match error.kind() {
        ErrorKind::NotFound => ("does not exist".to_owned(), "a scene file"),
        ErrorKind::PermissionDenied => ("may not be read".to_owned(), "permission to read it"),
        _ => (format!("can't be read: {error}"), "a scene file"),
    };
    let file = std::fs::File::open(path).map_err(failed)?;
    if file.metadata().map_err(failed)?.is_dir() {
        return Err(("is a folder".to_owned(), "a scene file"));
    }
    let mut bytes = Vec::new();
    file.take(LARGEST_FILE + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > LARGEST_FILE {
        return Err(("is larger than 16 MiB".to_owned(), "a scene file; generators make bodies in bulk"));
    }
    String::from_utf8(bytes).map_err(|error| {
        let byte = error.utf8_error().valid_up_to() + 1;
        (format!("is not a text: byte {byte} is not UTF-8"), "a scene file in TOML")
    })
}

/// Later files add to earlier ones; keys of `[world]`, `[output]` and `[start]` that they give win.
fn merge(roots: Vec<Table>, problems: &mut Vec<Problem>) -> Option<Table> {
    let mut roots = roots.into_iter();
    let mut all = roots.next()?;
    for next in roots {
        all.span = next.span;
        for (key, node) in next.entries {
            let Some((_, mine)) = all.entries.iter_mut().find(|(k, _)| *k == key) else {
                all.insert(key, node);
                continue;
            };
            match (&mut mine.value, node.value) {
                (Value::Table(mine), Value::Table(theirs)) => merge_tables(mine, theirs),
                (Value::Named(mine), Value::Named(theirs)) => {
                    for (name, node) in theirs {
                        if mine.iter().any(|(n, _)| *n == name) {
                            let message = format!("`{key}.{name}` is defined in two files");
                            problems.push(Problem::at(node.span, message).expecting("another name"));
                        } else {
                            mine.push((name, node));
                        }
                    }
                }
                (Value::List(mine), Value::List(theirs)) => mine.extend(theirs),
                _ => {}
            }
        }
    }
    all.entries.iter_mut().filter(|(k, _)| *k == "include").for_each(|(_, n)| n.value = Value::List(vec![]));
    Some(all)
}

fn merge_tables(mine: &mut Table, theirs: Table) {
    mine.span = theirs.span;
    for (key, node) in theirs.entries.into_iter().filter(|(_, n)| n.given) {
        // These two say the same thing.
        match key {
            "frames" => mine.unset("duration"),
            "duration" => mine.unset("frames"),
            _ => {}
        }
        let span = node.span;
        mine.set(key, node.value);
        if let Some((_, node)) = mine.entries.iter_mut().find(|(k, _)| *k == key) {
            node.span = span;
        }
    }
}

/// Fills in what depends on other tables, and checks what the types of keys can't say.
fn complete(root: &mut Table, problems: &mut Vec<Problem>) {
    if let Some(world) = root.table("world") {
        match root::frames(world) {
            Ok(frames) => edit(root, "world", |world| {
                world.unset("duration");
                world.set("frames", Value::Int(frames));
            }),
            Err(problem) => problems.push(problem),
        }
    }
    let none = ["bodies", "imports", "generators"].iter().all(|key| root.list(key).is_empty());
    if none && !root.has("start") {
        let problem = Problem::at(root.span, "the scene has no bodies");
        problems.push(problem.expecting("`[[bodies]]`, `[[imports]]`, `[[generators]]` or `[start]`"));
    }
    add_default_material(root);
    references(root, problems);
    let (nesting, problem) = Nesting::read(root);
    problems.extend(problem);
    for (_, table) in root.named("shapes") {
        problems.extend((shapes::kind_of(table).check)(table).err());
        problems.extend(table.table("visual").and_then(|visual| body::pose(visual).err()));
    }
    for table in root.tables("generators") {
        problems.extend(generators::check(table, root, &nesting).err());
    }
    for table in root.tables("bodies") {
        problems.extend(body::Template::body(table, 0).err());
        problems.extend(body::pose(table).err());
        problems.extend(table.table("visual").and_then(|visual| body::pose(visual).err()));
    }
    kinds_of_bodies(root, &nesting, problems);
    cameras::check(root, problems);
    unique(root, "id", problems);
    unique(root, "name", problems);
}

/// Makes the paths of files and of the run in `[start]` independent of the folder, so that a scene equals its filled text.
fn absolute_paths(root: &mut Table, sources: &Sources) {
    for (key, node) in &mut root.entries {
        let (tables, path): (Vec<&mut Node>, _) = match (*key, &mut node.value) {
            ("shapes", Value::Named(shapes)) => (shapes.iter_mut().map(|(_, shape)| shape).collect(), "file"),
            ("bodies" | "imports", Value::List(tables)) => (tables.iter_mut().collect(), "file"),
            ("start", _) => (vec![node], "run"),
            _ => continue,
        };
        for node in tables {
            let Value::Table(table) = &mut node.value else { continue };
            for (key, node) in &mut table.entries {
                match &mut node.value {
                    Value::Text(_) if *key == path => absolute(node, sources),
                    Value::Table(visual) if *key == "visual" => {
                        let file = visual.entries.iter_mut().find(|(key, _)| *key == "file");
                        file.into_iter().for_each(|(_, node)| absolute(node, sources));
                    }
                    _ => {}
                }
            }
        }
    }
}

/// Makes a path that was read from its file's folder one that starts at the root.
fn absolute(node: &mut Node, sources: &Sources) {
    let path = sources.get(node.span).base.join(node.value.text());
    let path = std::path::absolute(&path).unwrap_or(path);
    node.value = Value::Text(path.display().to_string());
}

/// Changes one of the scene's tables: `world`, `output` or `start`.
pub(crate) fn edit(root: &mut Table, name: &str, edit: impl FnOnce(&mut Table)) {
    let table = root.entries.iter_mut().find(|(k, _)| *k == name);
    if let Some((_, Node { value: Value::Table(table), .. })) = table {
        edit(table);
    }
}

fn add_default_material(root: &mut Table) {
    let span = root.span;
    let materials = root.entries.iter_mut().find(|(k, _)| *k == "materials");
    let Some((_, Node { value: Value::Named(materials), .. })) = materials else { return };
    if materials.iter().all(|(name, _)| name != "default") {
        let mut ignored = Vec::new();
        let mut checker = Checker { source: span.source, problems: &mut ignored };
        let table = checker.table(&MATERIAL, &DeTable::new(), span, "materials.default", false);
        let node = Node { span, given: false, value: Value::Table(table) };
        materials.push(("default".to_owned(), node));
    }
}

/// Names must name something.
fn references(root: &Table, problems: &mut Vec<Problem>) {
    let names = |key| root.named(key).map(|(name, _)| name).collect::<Vec<&str>>();
    let (shapes, materials) = (names("shapes"), names("materials"));
    let mut check = |what: &str, known: &[&str], node: &Node| {
        let name = node.value.text();
        if !known.contains(&name) {
            let problem = Problem::at(node.span, format!("no {what} is called `{name}`"));
            let expected = if known.is_empty() {
                format!("a {what} that is defined, and none is")
            } else {
                crate::spec::one_of(known.iter().copied())
            };
            problems.push(problem.expecting(expected).near(name, known.iter().copied()));
        }
    };
    visit(root, &mut |ty, node| match (ty, &node.value) {
        (Ty::Shape | Ty::Shapes, Value::List(list)) => {
            list.iter().for_each(|n| check("shape", &shapes, n));
        }
        (Ty::Shape | Ty::Shapes, _) => check("shape", &shapes, node),
        (Ty::Material, _) => check("material", &materials, node),
        _ => {}
    });
}

/// Calls `see` for every value of a table and of the tables in it.
fn visit<'a>(table: &'a Table, see: &mut impl FnMut(&Ty, &'a Node)) {
    for (name, node) in &table.entries {
        if let Some(key) = table.spec.key(name) {
            see(&key.ty, node);
        }
        let inner: Vec<&Node> = match &node.value {
            Value::Table(_) => vec![node],
            Value::List(list) => list.iter().collect(),
            Value::Named(named) => named.iter().map(|(_, n)| n).collect(),
            _ => Vec::new(),
        };
        inner.into_iter().filter_map(Node::table).for_each(|t| visit(t, see));
    }
}

/// Gives every body its kind and looks whether its shape allows it.
fn kinds_of_bodies(root: &mut Table, nesting: &Nesting, problems: &mut Vec<Problem>) {
    let shapes: BTreeMap<String, Table> =
        root.named("shapes").map(|(name, table)| (name.to_owned(), table.clone())).collect();
    let bodies = root.entries.iter_mut().find(|(k, _)| *k == "bodies");
    let Some((_, Node { value: Value::List(bodies), .. })) = bodies else { return };
    for node in bodies {
        let Value::Table(body) = &mut node.value else { continue };
        let Some(shape) = shapes.get(body.text("shape")) else { continue };
        let (kind, name) = (shapes::kind_of(shape), body.text("shape"));
        let (immovable, ground) = (nesting.is_immovable(name), nesting.is_ground(name));
        let (members, member) = ((kind.members)(shape), body.int("member"));
        if member >= members {
            let message = format!("`{}` is {member}", body.path_of("member"));
            let expected = format!("less than {members}, the number of shapes in `{}`", body.text("shape"));
            problems.push(Problem::at(body.span_of("member"), message).expecting(expected));
        }
        if !body.has("kind") {
            let word = if ground || body.bool("sensor") { "static" } else { "dynamic" };
            body.set("kind", Value::Text(word.to_owned()));
        } else if immovable && body.text("kind") == "dynamic" {
            let message = format!("`{}` is dynamic, but its shape is a {}", body.path, kind.spec.name);
            let problem = Problem::at(body.span_of("kind"), message);
            problems.push(problem.expecting("`static` or `kinematic`"));
        }
    }
}

/// No two bodies may share the value of `key`.
fn unique(root: &Table, key: &str, problems: &mut Vec<Problem>) {
    let mut seen = BTreeMap::new();
    for body in root.tables("bodies") {
        let Some(node) = body.node(key) else { continue };
        let word = match &node.value {
            Value::Int(i) => i.to_string(),
            value => value.text().to_owned(),
        };
        if let Some(first) = seen.insert(word.clone(), body.path.clone()) {
            let message = format!("`{}` and `{first}` have the same {key} `{word}`", body.path);
            problems.push(Problem::at(node.span, message).expecting(format!("another {key}")));
        }
    }
}
