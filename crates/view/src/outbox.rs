//! What is to be sent to one viewer: of everything that is shown the newest only, so that a slow one skips and nobody waits.

use crate::wire::{Colors, Moment};
use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Moments on their way that a viewer has not acknowledged.
const ON_THE_WAY: u32 = 2;

/// Answers that wait at most: who asks so much and reads nothing is no person.
const MOST_ANSWERS: usize = 256;

/// Bytes of control frames that wait at most.
const MOST_CONTROL: usize = 1 << 16;

/// Waiting for what a viewer sends, and what is sent to it.
#[derive(Debug, Default)]
pub(crate) struct Outbox {
    slots: Mutex<Slots>,
    bell: Condvar,
}

#[derive(Debug, Default)]
struct Slots {
    parcel: Parcel,
    sent: u32,
    acknowledged: u32,
}

/// What is sent next.
#[derive(Debug, Default)]
pub(crate) struct Parcel {
    /// Control frames, as they are.
    pub(crate) control: Vec<u8>,
    /// Answers, oldest first.
    pub(crate) answers: VecDeque<Arc<str>>,
    pub(crate) status: Option<Arc<str>>,
    pub(crate) picked: Option<Arc<str>>,
    pub(crate) moment: Option<(Arc<Moment>, u32)>,
    pub(crate) colors: Option<Arc<Colors>>,
    pub(crate) lines: Option<Arc<[u8]>>,
    /// Why this is the last one.
    pub(crate) last: Option<String>,
}

impl Outbox {
    fn slots(&self) -> MutexGuard<'_, Slots> {
        // Nobody panics while it is held.
        self.slots.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self, change: impl FnOnce(&mut Parcel)) {
        change(&mut self.slots().parcel);
        self.bell.notify_one();
    }

    pub(crate) fn show(&self, moment: &Arc<Moment>) {
        self.change(|parcel| parcel.moment = Some((Arc::clone(moment), 0)));
    }

    pub(crate) fn paint(&self, colors: &Arc<Colors>) {
        self.change(|parcel| parcel.colors = Some(Arc::clone(colors)));
    }

    pub(crate) fn mark(&self, lines: &Arc<[u8]>) {
        self.change(|parcel| parcel.lines = Some(Arc::clone(lines)));
    }

    pub(crate) fn status(&self, status: &Arc<str>) {
        self.change(|parcel| parcel.status = Some(Arc::clone(status)));
    }

    pub(crate) fn tell_of_body(&self, told: Arc<str>) {
        self.change(|parcel| parcel.picked = Some(told));
    }

    /// An answer that is not to be skipped.
    pub(crate) fn answer(&self, answer: Arc<str>) {
        self.change(|parcel| {
            if parcel.answers.len() < MOST_ANSWERS {
                parcel.answers.push_back(answer);
            } else {
                parcel.last = Some("it asks and does not listen".into());
            }
        });
    }

    /// Control frames of the listening side.
    pub(crate) fn control(&self, bytes: &[u8]) {
        self.change(|parcel| {
            if parcel.control.len() + bytes.len() <= MOST_CONTROL {
                parcel.control.extend_from_slice(bytes);
            } else {
                parcel.last = Some("it asks and does not listen".into());
            }
        });
    }

    /// The viewer has read the moment with this number.
    pub(crate) fn acknowledge(&self, number: u32) {
        let mut slots = self.slots();
        // A number that was never sent says nothing.
        if number <= slots.sent && number > slots.acknowledged {
            slots.acknowledged = number;
        }
        drop(slots);
        self.bell.notify_one();
    }

    /// Nothing is sent after what is there now, and the reason, if there is anything to say.
    pub(crate) fn close(&self, why: &str) {
        self.change(|parcel| parcel.last = Some(why.to_owned()));
    }

    /// Waits for something to send. Moments wait for the viewer to have read those before, all else does not.
    pub(crate) fn take(&self) -> Parcel {
        let mut slots = self.slots();
        loop {
            let room = slots.sent - slots.acknowledged < ON_THE_WAY;
            let parcel = &mut slots.parcel;
            let pressing = !parcel.control.is_empty()
                || !parcel.answers.is_empty()
                || parcel.status.is_some()
                || parcel.picked.is_some()
                || parcel.last.is_some();
            let shown = parcel.moment.is_some() || parcel.colors.is_some() || parcel.lines.is_some();
            if pressing || (room && shown) {
                let mut taken = std::mem::take(parcel);
                if !room {
                    parcel.moment = taken.moment.take();
                    parcel.colors = taken.colors.take();
                    parcel.lines = taken.lines.take();
                }
                if let Some((_, number)) = &mut taken.moment {
                    slots.sent += 1;
                    *number = slots.sent;
                }
                return taken;
            }
            let (next, _) = self
                .bell
                .wait_timeout(slots, Duration::from_secs(60))
                .unwrap_or_else(PoisonError::into_inner);
            slots = next;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moment(frame: u64) -> Arc<Moment> {
        Arc::new(Moment {
            frame,
            time: 0.0,
            step: 1.0,
            records: Arc::default(),
            far: 0,
            scenery: Arc::default(),
        })
    }

    #[test]
    fn a_viewer_that_reads_slowly_gets_the_newest_moment_and_none_of_those_between() {
        let outbox = Outbox::default();
        let mut shown = Vec::new();
        for frame in 0..100 {
            outbox.show(&moment(frame));
            if frame < 2 {
                shown.extend(outbox.take().moment.map(|(moment, number)| (moment.frame, number)));
            }
        }
        // Two are on their way: only words come now.
        outbox.status(&"a".into());
        outbox.status(&"b".into());
        let parcel = outbox.take();
        assert_eq!((parcel.status.as_deref(), parcel.moment.is_none()), (Some("b"), true));
        outbox.acknowledge(77);
        outbox.acknowledge(1);
        shown.extend(outbox.take().moment.map(|(moment, number)| (moment.frame, number)));
        assert_eq!(shown, [(0, 1), (1, 2), (99, 3)]);
    }

    #[test]
    fn who_asks_and_does_not_listen_is_shown_the_door() {
        let outbox = Outbox::default();
        (0..=MOST_ANSWERS).for_each(|_| outbox.answer("no".into()));
        let parcel = outbox.take();
        assert_eq!(parcel.answers.len(), MOST_ANSWERS);
        assert!(parcel.last.is_some());
    }
}
