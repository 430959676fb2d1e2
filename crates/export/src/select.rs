//! Which frames and which bodies.

use crate::Error;
use rockfall_cache::BodyTable;
use std::str::FromStr;

/// Frames of a run, by their numbers in it; frame 0 is the start.
///
/// # Examples
/// ```
/// use rockfall_export::Frames;
///
/// let frames = Frames { every: 2, ..("3..7".parse::<Frames>()?) };
/// assert_eq!(frames.among(10).unwrap(), [3, 5, 7]);
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frames {
    /// The first one; the start where `None`.
    pub first: Option<u64>,
    /// The last one, included; the last that there is where `None`.
    pub last: Option<u64>,
    /// Every so many of them from the first one on, at least 1.
    pub every: u64,
}

impl Default for Frames {
    fn default() -> Self {
        Frames { first: None, last: None, every: 1 }
    }
}

impl Frames {
    /// Their numbers in a run of `count` frames, ascending.
    ///
    /// # Errors
    /// [`Error::NoFrame`]: what was asked for and is not there is not left out.
    pub fn among(&self, count: u64) -> Result<Vec<u64>, Error> {
        let end = count.saturating_sub(1);
        let (first, last) = (self.first.unwrap_or(0), self.last.unwrap_or(end));
        match [first, last].into_iter().find(|&frame| frame > end) {
            Some(frame) => Err(Error::NoFrame { frame, last: end }),
            None => Ok((first..=last).step_by(self.every.max(1) as usize).collect()),
        }
    }
}

/// `7`, `3..7`, `3..` or `..7`, both ends included.
impl FromStr for Frames {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.parse::<u64>().ok();
        let end = |text: &str| if text.is_empty() { Some(None) } else { number(text).map(Some) };
        let parsed = match text.split_once("..") {
            None => number(text).map(|frame| (Some(frame), Some(frame))),
            Some((first, last)) => end(first).zip(end(last)),
        };
        match parsed {
            Some((Some(first), Some(last))) if first > last => {
                Err(format!("the first frame, {first}, is behind the last, {last}"))
            }
            Some((first, last)) => Ok(Frames { first, last, every: 1 }),
            None => Err("expected a frame such as 7, or frames such as 3..7, 3.. or ..7".into()),
        }
    }
}

/// Bodies by their ids.
///
/// # Examples
/// ```
/// use rockfall_export::Ids;
///
/// let some: Ids = "1,5,10..20".parse()?;
/// assert!(some != "1..20".parse()?);
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ids(Vec<(u64, u64)>);

impl Ids {
    /// Their rows in a run's table of bodies, ascending, each once.
    ///
    /// # Errors
    /// [`Error::NoBody`] for a number that is no body's, or a range in which there is none.
    pub fn rows(&self, table: &BodyTable) -> Result<Vec<u32>, Error> {
        let mut rows = Vec::new();
        for &(first, last) in &self.0 {
            let start = table.ids.partition_point(|&id| id < first);
            let end = table.ids.partition_point(|&id| id <= last);
            if start == end {
                let text = if first == last { first.to_string() } else { format!("from {first} to {last}") };
                return Err(Error::NoBody(text));
            }
            rows.extend(start as u32..end as u32);
        }
        rows.sort_unstable();
        rows.dedup();
        Ok(rows)
    }
}

/// Numbers and ranges, both ends included, with commas between: `1,5,10..20`.
impl FromStr for Ids {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let part = |part: &str| {
            let (first, last) = part.split_once("..").unwrap_or((part, part));
            let (first, last) = (first.trim().parse::<u64>().ok()?, last.trim().parse::<u64>().ok()?);
            (first <= last).then_some((first, last))
        };
        let parts: Option<Vec<_>> = text.split(',').map(part).collect();
        parts.map(Ids).ok_or_else(|| "expected ids such as 1,5,10..20".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_counted_with_both_ends_and_none_is_left_out() {
        let among = |text: &str, count| text.parse::<Frames>().unwrap().among(count);
        assert_eq!(among("7", 10).unwrap(), [7]);
        assert_eq!(among("..2", 10).unwrap(), [0, 1, 2]);
        assert_eq!(among("8..", 10).unwrap(), [8, 9]);
        assert_eq!(Frames { every: 4, ..Frames::default() }.among(10).unwrap(), [0, 4, 8]);
        for (text, wrong) in [("10", 10), ("3..12", 12), ("11..", 11)] {
            let error = among(text, 10).unwrap_err();
            assert!(matches!(error, Error::NoFrame { frame, last: 9 } if frame == wrong), "{error}");
        }
        for wrong in ["", "a", "-1", "5..3", "1...2", "1,2"] {
            assert!(wrong.parse::<Frames>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn bodies_are_found_by_id_and_a_missing_one_is_an_error() {
        let table = BodyTable { ids: vec![1, 3, 5, 7, 100], ..BodyTable::default() };
        let rows = |text: &str| text.parse::<Ids>().unwrap().rows(&table);
        assert_eq!(rows("100,3..6,5").unwrap(), [1, 2, 4]);
        assert_eq!(rows("2").unwrap_err().to_string().split(';').next(), Some("the run has no body 2"));
        assert!(rows("1,8..99").unwrap_err().to_string().starts_with("the run has no body from 8 to 99"));
        for wrong in ["", "1,", "5..3", "x", "1;2", "..4"] {
            assert!(wrong.parse::<Ids>().is_err(), "{wrong}");
        }
    }
}
