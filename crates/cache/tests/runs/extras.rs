//! Contacts, events and columns come back as they were written.

use crate::synthetic::{
    self, columns, contacts, events, everything, fill, full_frame, rolling_frame, start_with,
};
use rockfall_cache::{
    Column, Contacts, Contents, Error, Event, RunReader, TRAJECTORY, Values, WantedContacts, WantedEvents,
};

/// Bits, so that NaN equals itself.
fn text(values: &Values) -> String {
    format!("{values:?}")
}

#[test]
fn everything_comes_back_in_any_order() {
    let folder = tempfile::tempdir().unwrap();
    // Chunks of many frames; and more contacts than a chunk has, with bodies in several chunks side by side.
    for (bodies, frames) in [(7, 300), (20_000, 19)] {
        let path = folder.path().join(bodies.to_string());
        synthetic::write_everything(&path, bodies, frames).unwrap();
        let run = RunReader::open(&path).unwrap();
        assert_eq!(run.wanted_contacts().unwrap(), everything().contacts);
        assert_eq!(run.columns().unwrap(), everything().columns);
        let (found, told) = (run.contacts().unwrap().unwrap(), run.events().unwrap().unwrap());
        let sum =
            |of: fn(usize, u64) -> usize| (0..frames).map(|frame| of(bodies, frame) as u64).sum::<u64>();
        assert_eq!(found.total(), sum(|bodies, frame| contacts(bodies, frame).len()));
        assert_eq!(told.total(), sum(|_, frame| events(frame).len()));
        let readers: Vec<_> =
            run.columns().unwrap().iter().map(|column| run.column(column).unwrap()).collect();
        for frame in (0..frames).rev().chain([0, frames / 2, 1]) {
            assert!(found.at(frame).unwrap() == contacts(bodies, frame), "frame {frame}");
            assert_eq!(told.at(frame).unwrap(), events(frame));
            for (reader, values) in readers.iter().zip(columns(bodies, frame)) {
                assert!(text(&reader.at(frame).unwrap()) == text(&values), "frame {frame}");
            }
        }
        assert!(matches!(found.at(frames), Err(Error::NoFrame { .. })));
        assert!(told.at(frames).is_err() && readers[0].at(frames).is_err());
    }
    let lean = folder.path().join("lean");
    synthetic::write(&lean, 5, 3).unwrap();
    let run = RunReader::open(&lean).unwrap();
    assert!(run.contacts().unwrap().is_none() && run.events().unwrap().is_none());
    assert!(run.columns().unwrap().is_empty());
}

/// What runs of older versions lack, and those that do not want it.
#[test]
fn friction_and_impulses_may_be_missing() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run");
    let without = Contents {
        contacts: everything().contacts.map(|wanted| WantedContacts { friction: false, ..wanted }),
        events: everything().events.map(|wanted| WantedEvents { hits: None, ..wanted }),
        ..everything()
    };
    let writer = start_with(&path, 7, without.clone()).unwrap();
    fill(writer, &path, 7, 0..9, full_frame).unwrap();
    assert!(!path.join(TRAJECTORY).join("contacts/friction").exists());
    assert!(!path.join(TRAJECTORY).join("events/impulse").exists());
    let run = RunReader::open(&path).unwrap();
    assert_eq!((run.wanted_contacts().unwrap(), run.has_hits().unwrap()), (without.contacts, false));
    let (found, told) = (run.contacts().unwrap().unwrap(), run.events().unwrap().unwrap());
    for frame in 0..9 {
        assert_eq!(found.at(frame).unwrap(), Contacts { frictions: Vec::new(), ..contacts(7, frame) });
        let silent = events(frame).into_iter().map(|event| Event { impulse: 0.0, ..event });
        assert!(told.at(frame).unwrap().into_iter().eq(silent));
    }
}

#[test]
fn columns_that_are_not_what_was_said_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let taken = Column { name: "position".into(), ..everything().columns.remove(0) };
    let contents = Contents { columns: vec![taken], ..everything() };
    let refused = start_with(&folder.path().join("taken"), 3, contents).unwrap_err();
    assert!(refused.to_string().contains("the column `position` can't be written"), "{refused}");
    // A frame without them.
    let path = folder.path().join("without");
    let writer = start_with(&path, 3, everything()).unwrap();
    let failed = fill(writer, &path, 3, 0..1, rolling_frame).unwrap_err();
    assert_eq!(
        failed.to_string(),
        "the column `heat` can't be written: a frame has nothing, expected 3 of float32"
    );
}
