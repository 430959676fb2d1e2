//! The poses of bodies over time, turned from frame by frame to body by body.
//!
//! They go to their places in a nameless file on the side, some frames at a time, so that memory does not grow with the run.

use crate::Moment;
use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;

/// Poses that wait to be written together, about.
const TOGETHER: usize = 1 << 19;

/// Positions of all bodies, each for all frames, then rotations likewise.
pub(super) struct Tracks<'a> {
    file: File,
    rows: &'a [u32],
    frames: usize,
    waiting: Vec<Moment>,
    /// Frames in the file.
    written: usize,
    bodies: Vec<Track>,
}

/// What is known of a body over time.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Track {
    /// Its first pose, position and rotation; `None` until it comes.
    pub(super) first: Option<Pose>,
    last: Option<Pose>,
    /// When it comes and goes, by the index of the frame: whether it is there from then on. It is not there before.
    pub(super) changes: Vec<(usize, bool)>,
}

type Pose = ([f32; 3], [f32; 4]);

/// Bytes of a position and of a rotation.
pub(super) const POSITION: u64 = size_of::<[f32; 3]>() as u64;
pub(super) const ROTATION: u64 = size_of::<[f32; 4]>() as u64;

impl<'a> Tracks<'a> {
    /// For the bodies `rows`, ascending, at so many frames; the file has no name in `folder`, and goes when it is closed.
    pub(super) fn new(folder: &Path, rows: &'a [u32], frames: usize) -> io::Result<Self> {
        let file = tempfile::tempfile_in(folder)?;
        let bodies = vec![Track::default(); rows.len()];
        Ok(Tracks { file, rows, frames, waiting: Vec::new(), written: 0, bodies })
    }

    /// Where the positions of a body start, and its rotations.
    pub(super) fn places(&self, body: usize) -> (u64, u64) {
        let (frames, bodies, body) = (self.frames as u64, self.rows.len() as u64, body as u64);
        (POSITION * frames * body, POSITION * frames * bodies + ROTATION * frames * body)
    }

    /// Adds the next frame.
    pub(super) fn add(&mut self, moment: Moment) -> io::Result<()> {
        self.waiting.push(moment);
        if self.waiting.len() * self.rows.len() >= TOGETHER { self.flush() } else { Ok(()) }
    }

    /// All tracks, and the file from its start.
    pub(super) fn finish(mut self) -> io::Result<(Vec<Track>, File)> {
        self.flush()?;
        self.file.set_len((POSITION + ROTATION) * (self.frames * self.rows.len()) as u64)?;
        self.file.seek(SeekFrom::Start(0))?;
        Ok((self.bodies, self.file))
    }

    fn flush(&mut self) -> io::Result<()> {
        let moments = std::mem::take(&mut self.waiting);
        // Where each moment's next body is.
        let mut next = vec![0; moments.len()];
        let (mut positions, mut rotations) = (Vec::new(), Vec::new());
        for (body, &row) in self.rows.iter().enumerate() {
            let track = &mut self.bodies[body];
            let known = track.first.is_some();
            for ((index, moment), next) in (self.written..).zip(&moments).zip(&mut next) {
                let there = moment.rows.get(*next) == Some(&row);
                if there {
                    track.see((moment.positions[*next], moment.rotations[*next]));
                    *next += 1;
                }
                if there != track.changes.last().is_some_and(|&(_, there)| there) {
                    track.changes.push((index, there));
                }
                let (position, rotation) = track.last.unwrap_or_default();
                positions.push(position);
                rotations.push(rotation);
            }
            let mut start = self.written;
            if let (false, Some((position, rotation)), Some(&(came, _))) =
                (known, track.first, track.changes.first())
            {
                // Until it comes it waits where it will be.
                let late = came - self.written;
                positions[..late].fill(position);
                rotations[..late].fill(rotation);
                positions.splice(0..0, std::iter::repeat_n(position, self.written));
                rotations.splice(0..0, std::iter::repeat_n(rotation, self.written));
                start = 0;
            }
            let (of_positions, of_rotations) = self.places(body);
            self.put(of_positions + POSITION * start as u64, bytemuck::cast_slice(&positions))?;
            self.put(of_rotations + ROTATION * start as u64, bytemuck::cast_slice(&rotations))?;
            positions.clear();
            rotations.clear();
        }
        self.written += moments.len();
        Ok(())
    }

    fn put(&mut self, at: u64, bytes: &[u8]) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(at))?;
        self.file.write_all(bytes)
    }
}

impl Track {
    /// The next pose. Of the two quaternions of its rotation the one nearer to the last is kept, so that nobody who interpolates goes the long way.
    fn see(&mut self, (position, mut rotation): Pose) {
        if let Some((_, last)) = self.last {
            let same = last.iter().zip(&rotation).map(|(a, b)| a * b).sum::<f32>() >= 0.0;
            rotation = if same { rotation } else { rotation.map(|x| -x) };
        }
        self.first.get_or_insert((position, rotation));
        self.last = Some((position, rotation));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    /// The bodies that are there at each frame, by row; a position tells row and frame.
    fn moment(frame: usize, rows: &[u32]) -> Moment {
        let position = |row: &u32| [*row as f32, frame as f32, 0.0];
        // Every other frame with the other sign.
        let sign = if frame.is_multiple_of(2) { 1.0 } else { -1.0 };
        Moment {
            rows: rows.to_vec(),
            positions: rows.iter().map(position).collect(),
            rotations: vec![[0.0, 0.0, 0.0, sign]; rows.len()],
            ..Moment::default()
        }
    }

    #[test]
    fn bodies_wait_before_they_come_and_stay_after_they_went() {
        let rows = [2, 5, 7, 9];
        let mut tracks = Tracks::new(&std::env::temp_dir(), &rows, 6).unwrap();
        for (frame, there) in [&[2][..], &[2], &[2, 5], &[5, 7], &[2, 5, 7], &[2, 7]].iter().enumerate() {
            tracks.add(moment(frame, there)).unwrap();
            // However frames are put together.
            if frame == 1 || frame == 2 {
                tracks.flush().unwrap();
            }
        }
        let places: Vec<(u64, u64)> = (0..4).map(|body| tracks.places(body)).collect();
        let (bodies, mut file) = tracks.finish().unwrap();
        let changes = [&[(0, true), (3, false), (4, true)][..], &[(2, true), (5, false)], &[(3, true)], &[]];
        for (body, changes) in changes.iter().enumerate() {
            assert_eq!(bodies[body].changes, *changes);
        }
        assert!(bodies[3].first.is_none());
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).unwrap();
        let floats: Vec<f32> = bytemuck::pod_collect_to_vec(&bytes);
        let frames_of = |body: usize| -> Vec<f32> {
            let start = places[body].0 as usize / 4;
            (0..6).map(|frame| floats[start + 3 * frame + 1]).collect()
        };
        assert_eq!(frames_of(0), [0.0, 1.0, 2.0, 2.0, 4.0, 5.0]);
        assert_eq!(frames_of(1), [2.0, 2.0, 2.0, 3.0, 4.0, 4.0]);
        assert_eq!(frames_of(2), [3.0, 3.0, 3.0, 3.0, 4.0, 5.0]);
        // All of one sign.
        let start = places[0].1 as usize / 4;
        assert!((0..6).all(|frame| floats[start + 4 * frame + 3] == floats[start + 3]));
    }
}
