//! What is newest, into the outboxes of all viewers.

use super::{Director, Viewer};
use crate::wire::{ABSENT, Colors};
use crate::{details, told};
use rockfall_picture::{ColorBy, Overlay};
use serde_json::json;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Words are sent at most so often, and at least so often: a viewer that hears nothing for longer knows that it is cut off.
pub(super) const STATUS: Duration = Duration::from_millis(60);
const HEARTBEAT: Duration = Duration::from_secs(1);

/// What is worked out for viewers takes at most one in so many parts of the time.
const SHARE: u32 = 4;

/// Lines of overlays as a message, and what is to be said of them.
type Marked = Result<(Arc<[u8]>, Option<String>), String>;

impl Director {
    pub(super) fn publish(&mut self) {
        if self.stale {
            self.stale = false;
            let range = self.source.range();
            self.shown = self.shown.clamp(range.first, range.last);
            match self.source.moment(self.shown) {
                Ok(moment) => {
                    self.viewers.values().for_each(|viewer| viewer.outbox.show(&moment));
                    self.moment = Some(moment);
                    (self.details_stale, self.status_stale) = (true, true);
                }
                Err(error) => {
                    self.playing = false;
                    self.tell_all(&error);
                }
            }
        }
        if self.details_stale && Instant::now() >= self.details_due {
            let start = Instant::now();
            self.details_stale = false;
            self.details();
            self.details_due = Instant::now() + SHARE * start.elapsed();
        }
        let since = self.status_sent.elapsed();
        if (self.status_stale && since >= STATUS) || since >= HEARTBEAT {
            (self.status_stale, self.status_sent) = (false, Instant::now());
            let status: Arc<str> = self.status().to_string().into();
            self.viewers.values().for_each(|viewer| viewer.outbox.status(&status));
        }
    }

    /// Colours, overlays and what is told of bodies, for those who want them.
    fn details(&mut self) {
        let Some(moment) = self.moment.clone() else { return };
        let there = moment.records.iter().filter(|record| **record != ABSENT).count();
        let key = |color: ColorBy| {
            let frame = if color.changes() { moment.frame as usize } else { 0 };
            (color, there, frame)
        };
        let wants = |viewer: &Viewer| {
            viewer.painted != Some(key(viewer.color)) || !viewer.marks.is_empty() || viewer.pick.is_some()
        };
        let nothing: Arc<[u8]> = crate::wire::lines(&[]).into();
        for viewer in self.viewers.values_mut().filter(|viewer| viewer.marked && viewer.marks.is_empty()) {
            viewer.marked = false;
            viewer.outbox.mark(&nothing);
        }
        if !self.viewers.values().any(wants) {
            return;
        }
        let sight = self.source.sight(moment.frame);
        // What stays the same is known also of what has been.
        let newest = if sight.is_err() { Some(self.source.sight(self.source.range().last)) } else { None };
        let mut painted: BTreeMap<ColorBy, Result<Arc<Colors>, String>> = BTreeMap::new();
        let mut marked: BTreeMap<Vec<Overlay>, Marked> = BTreeMap::new();
        let (source, scenery) = (&self.source, &moment.scenery);
        for viewer in self.viewers.values_mut() {
            let outbox = &viewer.outbox;
            let complain = |what: &str, why: &str| {
                outbox.answer(json!({"is": "unknown", "what": what, "why": why}).to_string().into());
            };
            if viewer.painted != Some(key(viewer.color)) {
                let made = painted.entry(viewer.color).or_insert_with(|| {
                    let sight = newest.as_ref().filter(|_| !viewer.color.changes()).unwrap_or(&sight);
                    let sight = sight.as_ref().map_err(ToString::to_string)?;
                    details::colors(sight, viewer.color, scenery)
                        .map(Arc::new)
                        .map_err(|error| error.to_string())
                });
                match made {
                    Ok(colors) => outbox.paint(colors),
                    Err(why) => complain("color", why),
                }
                viewer.painted = Some(key(viewer.color));
            }
            if !viewer.marks.is_empty() {
                let made = marked.entry(viewer.marks.clone()).or_insert_with(|| {
                    let sight = sight.as_ref().map_err(ToString::to_string)?;
                    let made = details::overlays(sight, &viewer.marks, scenery);
                    made.map(|(bytes, note)| (bytes.into(), note)).map_err(|error| error.to_string())
                });
                match made {
                    Ok((bytes, note)) => {
                        outbox.mark(bytes);
                        if let Some(note) = note {
                            complain("overlays", note);
                        }
                    }
                    Err(why) => {
                        outbox.mark(&nothing);
                        complain("overlays", why);
                    }
                }
                viewer.marked = true;
            }
            if let Some(row) = viewer.pick {
                let value = match &sight {
                    Ok(sight) => told::told(source, sight, scenery, row),
                    Err(error) => match &newest {
                        Some(Ok(newest)) => told::told_of_past(source, newest, &moment, row),
                        _ => json!({"is": "picked", "row": row, "why": error.to_string()}),
                    },
                };
                outbox.tell_of_body(value.to_string().into());
            }
        }
    }
}
