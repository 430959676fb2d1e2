//! What a caller can get wrong is an error that tells what, and leaves no file behind.

use rockfall_usd::{Array, Attribute, Error, Layer, Prim, Relationship, Value, Writer};
use std::fs;
use std::io::ErrorKind;

/// The error of a layer with one prim.
fn refused(prim: Prim) -> String {
    with_samples(prim, |_| Ok(()))
}

fn with_samples(prim: Prim, samples: impl Fn(&mut Writer) -> Result<(), Error>) -> String {
    let folder = tempfile::tempdir().unwrap();
    let mut writer = Writer::create(&folder.path().join("bad.usdc")).unwrap();
    let layer = Layer { prims: vec![prim], ..Layer::default() };
    let error = match samples(&mut writer) {
        Ok(()) => writer.finish(&layer).unwrap_err(),
        Err(error) => {
            drop(writer);
            error
        }
    };
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "nothing is left");
    error.to_string()
}

#[test]
fn names_paths_and_types_are_checked() {
    let prim = || Prim::def("Mesh", "Ball");
    assert_eq!(
        refused(Prim::def("Mesh", "1st")),
        "`1st` can't be the name of a prim: letters, digits and underscores, not a digit first"
    );
    assert_eq!(
        refused(prim().with(Attribute::sampled("int", "a b"))),
        "`a b` can't be the name of a property: letters, digits and underscores, not a digit first, in parts with \
         colons between them"
    );
    assert_eq!(refused(prim().child(prim()).child(prim())), "/Ball/Ball is there twice");
    let size = || Attribute::new("double", "size", Value::Double(1.0));
    assert_eq!(refused(prim().with(size()).with(size())), "/Ball.size is there twice");
    assert_eq!(
        refused(prim().with(Relationship::new("to", vec!["Ball".to_owned()]))),
        "`Ball` is no path: expected one like /World/Ball or /World/Ball.radius"
    );
    assert_eq!(
        refused(prim().with(Attribute::new("float", "size", Value::Double(1.0)))),
        "/Ball.size is of the type `float`, and a value of it is not"
    );
    assert_eq!(
        refused(prim().with(Attribute::sampled("colour", "tint"))),
        "/Ball.tint is of the type `colour`, which is not known here"
    );
    assert_eq!(
        refused(prim().meta("comment", Value::String("a\0b".to_owned()))),
        "a text with a zero character can't be written: \"a\\0b\""
    );
}

#[test]
fn samples_are_checked() {
    let points = || Prim::def("Points", "P").with(Attribute::sampled("point3f[]", "points"));
    let floats = Array::Float3(vec![[0.0; 3]]);
    let at = |path: &'static str, time: f64| {
        let floats = &floats;
        move |writer: &mut Writer| {
            writer.sample(path, 1.0, floats)?;
            writer.sample(path, time, floats)
        }
    };
    for time in [1.0, 0.5, f64::NAN, f64::INFINITY] {
        assert_eq!(
            with_samples(points(), at("/P.points", time)),
            format!("/P.points has a sample at {time} that does not come after the one before it")
        );
    }
    assert_eq!(
        with_samples(points(), at("/P.velocities", 2.0)),
        "/P.velocities has samples, but the layer has no such attribute"
    );
    let ints = |writer: &mut Writer| writer.sample("/P.points", 1.0, &Array::Int(vec![1]));
    assert_eq!(
        with_samples(points(), ints),
        "/P.points is of the type `point3f[]`, and a value of it is not"
    );
}

#[test]
fn a_folder_that_is_not_there_is_an_error_that_names_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("missing/scene.usdc");
    let Err(Error::Io { path: named, kind, .. }) = Writer::create(&path) else { panic!("another error") };
    assert_eq!((named, kind), (path, ErrorKind::NotFound));
}
