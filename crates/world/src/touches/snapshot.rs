//! Pairs to a snapshot and back.
//!
//! Everything a run has is written behind that of the run before. What is read is checked wherever a step relies on it: pairs are in order
//! and their rows are there, and every contact is one pair's.

use super::{Run, Touches, rows};
use crate::Kind;
use crate::bodies::Bodies;
use crate::recall::Recall;
use rockfall_collide::Cache;
use rockfall_math::snapshot::{Error, Get, Put, Reader, Stored, Writer, get_each, put_each};
use rockfall_solve::{Contacts, FIXED, Lane, row_of};

impl Stored for Recall {
    const TYPE: &'static str = "recall";

    fn put(column: &[Self], put: Put<'_>) -> Result<(), Error> {
        put_each(column, put, |&Recall { cache: Cache { word, kept }, mark }, bytes| {
            [word, kept, mark].iter().for_each(|word| bytes.extend_from_slice(&word.to_ne_bytes()));
        })
    }

    fn get(count: u64, get: Get<'_>) -> Result<Option<Vec<Self>>, Error> {
        get_each(count, 12, get, |bytes| {
            let (words, _) = bytes.as_chunks();
            let &[word, kept, mark] = words else { return None };
            let [word, kept, mark] = [word, kept, mark].map(u32::from_ne_bytes);
            Some(Recall { cache: Cache { word, kept }, mark })
        })
    }
}

impl Touches {
    /// Writes all pairs. Not between [`crate::pair`] and [`crate::touch`].
    pub(crate) fn save(&self, to: &mut Writer<'_>) -> Result<(), Error> {
        let Touches { runs } = self;
        // Between steps `befores` says nothing.
        let each = |Run { keys, befores: _, firsts, recalls, lanes }: &Run| {
            [keys.len(), firsts.len(), recalls.len(), lanes.len()]
        };
        let [keys, firsts, recalls, lanes] =
            runs.iter().map(each).fold([0; 4], |sums, lens| std::array::from_fn(|i| sums[i] + lens[i]));
        to.column("pairs.runs", &runs.iter().map(|run| run.keys.len() as u64).collect::<Vec<u64>>())?;
        to.pieces("pairs.keys", keys, runs.iter().map(|run| &run.keys[..]))?;
        to.pieces("pairs.firsts", firsts, runs.iter().map(|run| &run.firsts[..]))?;
        to.pieces("pairs.recalls", recalls, runs.iter().map(|run| &run.recalls[..]))?;
        to.pieces("pairs.lanes", lanes, runs.iter().map(|run| &run.lanes[..]))
    }

    /// Reads the pairs of these bodies.
    pub(crate) fn load(from: &mut Reader<'_>, bodies: &Bodies) -> Result<Self, Error> {
        let lengths: Vec<u64> = from.column("pairs.runs")?;
        let keys: Vec<u64> = from.column("pairs.keys")?;
        check_keys(&keys, bodies)?;
        let firsts: Vec<u32> = from.column_of("pairs.firsts", keys.len() + lengths.len())?;
        let recalls: Vec<Recall> = from.column_of("pairs.recalls", keys.len())?;
        let lanes: Vec<Lane> = from.column("pairs.lanes")?;
        let (mut keys, mut firsts, mut recalls, mut lanes) =
            (&keys[..], &firsts[..], &recalls[..], &lanes[..]);
        let mut runs = Vec::with_capacity(lengths.len());
        for length in lengths {
            let length = usize::try_from(length).ok().filter(|&length| length <= keys.len());
            let length = length.ok_or_else(|| Error::invalid("pairs.runs", "more pairs than there are"))?;
            let of_run = cut(&mut firsts, length + 1);
            let count = of_run[length] as usize;
            let sound = of_run[0] == 0 && of_run.is_sorted() && count <= lanes.len();
            Error::unless(sound, "pairs.firsts", "not in order, or more contacts than there are")?;
            runs.push(Run {
                keys: cut(&mut keys, length).to_vec(),
                befores: Vec::new(),
                firsts: of_run.to_vec(),
                recalls: cut(&mut recalls, length).to_vec(),
                lanes: cut(&mut lanes, count).to_vec(),
            });
        }
        Error::unless(keys.is_empty() && lanes.is_empty(), "pairs.runs", "fewer pairs than there are")?;
        Ok(Touches { runs })
    }

    /// Whether every contact is that of one pair, and of the right one.
    pub(crate) fn check_contacts(&self, contacts: &Contacts) -> Result<(), Error> {
        let sound = self.contacts().all(|(key, lane)| contacts.bodies_at(lane) == Some(rows(key)));
        Error::unless(sound, "pairs.lanes", "a contact that is not there, or of other bodies")?;
        let mut lanes: Vec<Lane> = self.contacts().map(|(_, lane)| lane).collect();
        lanes.sort_unstable();
        let each_once = lanes.is_sorted_by(|a, b| a < b) && lanes.len() == contacts.count();
        Error::unless(each_once, "pairs.lanes", "a contact of two pairs or of none")
    }
}

/// Whether pairs ascend, and are such as [`crate::pair`] finds.
fn check_keys(keys: &[u64], bodies: &Bodies) -> Result<(), Error> {
    let dynamic = |row: usize| bodies.kinds.get(row) == Some(&Kind::Dynamic);
    let sound = |&key: &u64| {
        let (a, marked) = rows(key);
        let (a, b) = (a as usize, row_of(marked));
        let fixed = marked & FIXED != 0;
        b < bodies.rows() && dynamic(a) && dynamic(b) != fixed && (fixed || bodies.ids[a] < bodies.ids[b])
    };
    let ascend = keys.is_sorted_by(|a, b| a < b);
    Error::unless(ascend && keys.iter().all(sound), "pairs.keys", "a pair that there can't be")
}

/// Takes the first `len` values away.
fn cut<'a, T>(rest: &mut &'a [T], len: usize) -> &'a [T] {
    let (here, behind) = rest.split_at(len);
    *rest = behind;
    here
}
