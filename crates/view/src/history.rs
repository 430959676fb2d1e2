//! What was seen of a simulation, so that one can look back.

use crate::wire::Moment;
use std::collections::VecDeque;
use std::sync::Arc;

/// Bytes of it at most; then the oldest moments go.
pub(crate) const MOST: usize = 512 << 20;

/// Moments one frame after the other, the newest last.
#[derive(Debug, Default)]
pub(crate) struct History {
    moments: VecDeque<Arc<Moment>>,
    bytes: usize,
}

impl History {
    /// Adds the moment of the next frame. What does not differ from the one before it is kept once.
    pub(crate) fn push(&mut self, moment: Moment, most: usize) -> Arc<Moment> {
        let before = self.moments.back();
        let mut moment = moment;
        if let Some(before) = before.filter(|before| before.records == moment.records) {
            moment.records = Arc::clone(&before.records);
        }
        self.bytes += moment.bytes(before.map(Arc::as_ref));
        let moment = Arc::new(moment);
        self.moments.push_back(Arc::clone(&moment));
        while self.bytes > most && self.moments.len() > 2 {
            let gone = self.moments.pop_front();
            // The records go with the last moment that has them.
            let lone = gone
                .as_ref()
                .zip(self.moments.front())
                .is_some_and(|(a, b)| !Arc::ptr_eq(&a.records, &b.records));
            let own = gone.map_or(0, |gone| {
                gone.bytes(if lone { None } else { self.moments.front().map(Arc::as_ref) })
            });
            self.bytes = self.bytes.saturating_sub(own);
        }
        moment
    }

    /// Puts another moment in the place of the newest, of the same frame.
    pub(crate) fn replace_last(&mut self, moment: Moment, most: usize) -> Arc<Moment> {
        if let Some(last) = self.moments.pop_back() {
            self.bytes = self.bytes.saturating_sub(last.bytes(self.moments.back().map(Arc::as_ref)));
        }
        self.push(moment, most)
    }

    /// The first and the last frame; none where there is nothing.
    pub(crate) fn frames(&self) -> Option<(u64, u64)> {
        Some((self.moments.front()?.frame, self.moments.back()?.frame))
    }

    /// The moment of a frame; the nearest that there is.
    pub(crate) fn at(&self, frame: u64) -> Option<&Arc<Moment>> {
        let (first, last) = self.frames()?;
        self.moments.get((frame.clamp(first, last) - first) as usize)
    }

    /// Bytes held.
    pub(crate) fn bytes(&self) -> usize {
        self.bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moment(frame: u64, value: u32) -> Moment {
        Moment {
            frame,
            time: 0.0,
            step: 1.0,
            records: Arc::new(vec![[value; 3]; 1000]),
            far: 0,
            scenery: Arc::default(),
        }
    }

    #[test]
    fn the_newest_moments_stay_within_the_bound() {
        let mut history = History::default();
        for frame in 0..100 {
            history.push(moment(frame, frame as u32), 200_000);
            assert!(history.bytes() <= 200_000);
        }
        let (first, last) = history.frames().unwrap();
        assert_eq!(last, 99);
        assert!((80..90).contains(&first), "{first}");
        assert_eq!(history.at(95).unwrap().records[0], [95; 3]);
        assert_eq!(history.at(3).unwrap().frame, first);
    }

    #[test]
    fn what_rests_takes_no_room() {
        let mut history = History::default();
        for frame in 0..1000 {
            history.push(moment(frame, 1), 1 << 20);
        }
        assert_eq!(history.frames(), Some((0, 999)));
        assert!(history.bytes() < 200_000, "{}", history.bytes());
        // With the first that differs all of them go, and their bytes with them.
        for frame in 1000..1200 {
            history.push(moment(frame, frame as u32), 1 << 20);
        }
        let held: usize = 1200 - history.frames().unwrap().0 as usize;
        assert!(history.bytes().abs_diff(held * 12_100) < held * 200, "{} for {held}", history.bytes());
    }
}
