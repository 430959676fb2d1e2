//! Where bodies are.

use super::runs::changed;
use super::{ABSENT, Kind, Record, begin, pad, put, put_f32};
use crate::scenery::Scenery;
use std::sync::Arc;

/// Bytes before the runs.
pub const HEAD: usize = 32;

/// All bodies at one frame. It is made once, and shared by all viewers.
#[derive(Clone, Debug)]
pub struct Moment {
    /// Number of the frame.
    pub frame: u64,
    /// Simulated seconds.
    pub time: f64,
    /// Step of the grid, metres.
    pub step: f32,
    /// Of each row of the table.
    pub records: Arc<Vec<Record>>,
    /// Bodies that are too far away to be told.
    pub far: usize,
    pub(crate) scenery: Arc<Scenery>,
}

/// What a viewer has been sent.
#[derive(Debug, Default)]
pub struct Sent {
    step: f32,
    records: Vec<Record>,
}

impl Moment {
    /// The message number `number` for a viewer.
    pub fn message(&self, sent: &mut Sent, number: u32) -> Vec<u8> {
        let anew = sent.step != self.step || sent.records.len() > self.records.len();
        if anew {
            *sent = Sent { step: self.step, records: Vec::new() };
        }
        let mut records = Vec::new();
        let (runs, count) = changed(&self.records, &mut sent.records, ABSENT, |record| records.push(record));
        let mut out = begin(Kind::Moment, u8::from(anew), HEAD + runs.len() + 12 * records.len());
        put(&mut out, number);
        put(&mut out, self.frame as u32);
        put_f32(&mut out, &[self.step]);
        out.extend_from_slice(&self.time.to_le_bytes());
        put(&mut out, count);
        put(&mut out, runs.len() as u32);
        out.extend_from_slice(&runs);
        pad(&mut out);
        records.iter().flatten().for_each(|word| out.extend_from_slice(&word.to_le_bytes()));
        out
    }

    /// Bytes that it holds for itself, `before` being the one that came before it.
    pub(crate) fn bytes(&self, before: Option<&Moment>) -> usize {
        let shared = before.is_some_and(|before| Arc::ptr_eq(&before.records, &self.records));
        size_of::<Moment>() + if shared { 0 } else { self.records.len() * size_of::<Record>() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::Grid;
    use rockfall_math::hash::mix;
    use rockfall_math::{Quat, Vec3};

    fn moment(records: Vec<Record>, step: f32) -> Moment {
        Moment { frame: 7, time: 0.5, step, records: Arc::new(records), far: 0, scenery: Arc::default() }
    }

    /// At most 16 bytes for each body that moves, beside the head of the message; whoever moves, and whoever sleeps.
    #[test]
    fn a_moving_body_takes_sixteen_bytes_at_most_and_a_sleeping_one_none() {
        let grid = Grid::reaching(100.0);
        let n = 100_000_u64;
        for share in [1, 2, 3, 7, 100, 9_999, 60_000] {
            let at = |k: u64, t: f32| grid.record(Vec3::new((k % 50) as f32, 2.0, t), Quat::IDENTITY, false);
            let mut sent = Sent::default();
            moment((0..n).map(|k| at(k, 0.0)).collect(), grid.step).message(&mut sent, 1);
            // Scattered, so that no two of them stand side by side unless all move.
            let moves = |k: u64| mix(k).is_multiple_of(share);
            let next: Vec<Record> = (0..n).map(|k| at(k, if moves(k) { 1.0 } else { 0.0 })).collect();
            let moving = (0..n).filter(|&k| moves(k)).count();
            let bytes = moment(next.clone(), grid.step).message(&mut sent, 2).len() - HEAD;
            let each = bytes as f64 / moving.max(1) as f64;
            println!("{moving} of {n} move: {each:.2} bytes each");
            assert!(each <= 16.0, "{moving} of {n}: {each}");
            assert_eq!(moment(next, grid.step).message(&mut sent, 3).len(), HEAD);
        }
    }

    #[test]
    fn with_another_grid_all_is_told_anew() {
        let mut sent = Sent::default();
        let records = vec![[1, 2, 3], ABSENT, [4, 5, 6]];
        let first = moment(records.clone(), 0.5).message(&mut sent, 9);
        assert_eq!((first[0], first[1], first[4], first[8], first[24], first[28]), (1, 1, 9, 7, 2, 4));
        assert_eq!(first[32..36], [0, 1, 1, 1]);
        assert_eq!(first.len(), HEAD + 4 + 24);
        assert_eq!(moment(records.clone(), 0.5).message(&mut sent, 10)[1], 0);
        assert_eq!(
            moment(records, 1.0).message(&mut sent, 11)[1..],
            [
                &[1, 0, 0, 11][..],
                &moment(vec![[1, 2, 3], ABSENT, [4, 5, 6]], 1.0).message(&mut Sent::default(), 0)[5..]
            ]
            .concat()[..]
        );
    }
}
