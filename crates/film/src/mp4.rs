//! The file: ISO base media (ISO/IEC 14496-12), fragmented, with AV1 in it (AOM, "AV1 Codec ISO Media File Format Binding", 1.2).
//!
//! Head (`ftyp`, `moov`), index (`sidx`), and a fragment (`moof`, `mdat`) for each group of pictures. A fragment is written as soon as its group is complete; so a
//! film that is broken off is whole up to there. The index has its room from the start, since the number of groups is known, and is filled in at the end.

use crate::encode::Sample;
use crate::{Format, TICKS};
use mp4_atom::{
    Atom, Av01, Av1c, Colr, Dinf, Dref, DrefEntry, Encode, Free, Ftyp, Hdlr, Mdhd, Mdia, Mehd, Mfhd, Minf,
    Moof, Moov, Mvex, Mvhd, SegmentReference, Sidx, Stbl, Stco, Stsd, Tfdt, Tfhd, Tkhd, Traf, Trak, Trex,
    Trun, TrunEntry, TrunSamples, Url, Visual, Vmhd, Zeroed,
};
use std::fs::File;
use std::io::{self, Seek, Write};

/// Flags of samples (14496-12, 8.8.3.1): one that depends on no other, and one that does and is no place to begin.
const KEY: u32 = 0x0200_0000;
const REST: u32 = 0x0101_0000;

/// Colours of the track (H.273): primaries of BT.709, the curve of sRGB, the matrix of BT.709, and less than the full range.
const COLORS: Colr = Colr::Nclx {
    colour_primaries: 1,
    transfer_characteristics: 13,
    matrix_coefficients: 1,
    full_range_flag: false,
};

/// Entries that an index can have.
const MOST: u64 = u16::MAX as u64;

/// Bytes of an index without entries, of an entry, and of the head of a box.
const INDEX: u64 = 32;
const ENTRY: u64 = 12;
const BOX: u64 = 8;

/// A film on its way to disk.
pub(crate) struct Writer {
    file: File,
    format: Format,
    level: u8,
    /// The stream's description of itself, from its first picture.
    config: Vec<u8>,
    /// Pictures of the group that is not complete yet.
    waiting: Vec<Sample>,
    /// Bytes and pictures of each fragment.
    fragments: Vec<(u32, u32)>,
    /// Pictures that are on disk.
    pub(crate) pictures: u64,
    /// Bytes that are on disk.
    pub(crate) bytes: u64,
}

impl Writer {
    pub(crate) fn new(file: File, format: Format, level: u8) -> Self {
        Writer {
            file,
            format,
            level,
            config: Vec::new(),
            waiting: Vec::new(),
            fragments: Vec::new(),
            pictures: 0,
            bytes: 0,
        }
    }

    /// Adds the next picture.
    pub(crate) fn push(&mut self, mut sample: Sample) -> io::Result<()> {
        let delimiter =
            unit(&sample.data).filter(|unit| unit.kind == TEMPORAL_DELIMITER).map_or(0, |unit| unit.end);
        // The file says by itself where a picture begins.
        sample.data.drain(..delimiter);
        if sample.key {
            self.fragment()?;
        }
        self.waiting.push(sample);
        Ok(())
    }

    /// Writes what waits and the index, and the length if it is another one than was expected.
    pub(crate) fn finish(&mut self) -> io::Result<()> {
        self.fragment()?;
        if self.pictures == 0 {
            return Ok(());
        }
        self.file.rewind()?;
        self.file.write_all(&self.head(self.pictures)?)?;
        let room = self.room();
        if room > 0 {
            self.file.write_all(&self.index(room)?)?;
        }
        self.file.flush()
    }

    /// Writes the pictures that wait as a fragment, before the first one also the head.
    fn fragment(&mut self) -> io::Result<()> {
        let Some(first) = self.waiting.first() else { return Ok(()) };
        if self.fragments.is_empty() {
            self.config = unit(&first.data)
                .filter(|unit| unit.kind == SEQUENCE_HEADER)
                .map_or_else(Vec::new, |unit| first.data[..unit.end].to_vec());
            let mut start = self.head(self.format.pictures)?;
            if let Some(size) = self.room().checked_sub(BOX) {
                put(&Free { zeroed: Zeroed::new(size as usize) }, &mut start)?;
            }
            self.file.write_all(&start)?;
            self.bytes = start.len() as u64;
        }
        let waiting = std::mem::take(&mut self.waiting);
        let mut bytes = Vec::new();
        // The place of the first picture in the fragment is known when the box before it has its size, which does not depend on it.
        for place in [0, 1] {
            let place = if place == 0 { 0 } else { bytes.len() as u64 + BOX };
            bytes.clear();
            put(&self.moof(&waiting, place)?, &mut bytes)?;
        }
        let data: usize = waiting.iter().map(|sample| sample.data.len()).sum();
        bytes.extend(fits::<u32>(data as u64 + BOX)?.to_be_bytes());
        bytes.extend(b"mdat");
        waiting.iter().for_each(|sample| bytes.extend_from_slice(&sample.data));
        // In one piece, so that what is broken off ends at a border.
        self.file.write_all(&bytes)?;
        self.fragments.push((fits(bytes.len() as u64)?, fits(waiting.len() as u64)?));
        self.pictures += waiting.len() as u64;
        self.bytes += bytes.len() as u64;
        Ok(())
    }

    fn moof(&self, samples: &[Sample], place: u64) -> io::Result<Moof> {
        let entry = |sample: &Sample| {
            let flags = Some(if sample.key { KEY } else { REST });
            Ok(TrunEntry { size: Some(fits(sample.data.len() as u64)?), flags, ..TrunEntry::default() })
        };
        let samples = samples.iter().map(entry).collect::<io::Result<Vec<TrunEntry>>>()?;
        let run = Trun { data_offset: Some(fits(place)?), samples: TrunSamples::Explicit(samples) };
        Ok(Moof {
            mfhd: Mfhd { sequence_number: fits(self.fragments.len() as u64 + 1)? },
            traf: vec![Traf {
                tfhd: Tfhd {
                    track_id: 1,
                    default_sample_duration: Some(TICKS),
                    default_base_is_moof: true,
                    ..Tfhd::default()
                },
                tfdt: Some(Tfdt { base_media_decode_time: self.pictures * u64::from(TICKS) }),
                trun: vec![run],
                ..Traf::default()
            }],
        })
    }

    /// `ftyp` and `moov`, of the same size for any number of pictures.
    fn head(&self, pictures: u64) -> io::Result<Vec<u8>> {
        let [width, height] = [self.format.width, self.format.height].map(|size| size as u16);
        let timescale = self.format.timescale();
        let codec = Av01 {
            visual: Visual { data_reference_index: 1, width, height, ..Visual::default() },
            av1c: Av1c {
                seq_level_idx_0: self.level,
                chroma_subsampling_x: true,
                chroma_subsampling_y: true,
                chroma_sample_position: 1,
                config_obus: self.config.clone(),
                ..Av1c::default()
            },
            colr: Some(COLORS),
            ..Av01::default()
        };
        let track = Trak {
            tkhd: Tkhd {
                track_id: 1,
                enabled: true,
                in_movie: true,
                width: width.into(),
                height: height.into(),
                ..Tkhd::default()
            },
            mdia: Mdia {
                mdhd: Mdhd { timescale, language: "und".into(), ..Mdhd::default() },
                hdlr: Hdlr { handler: b"vide".into(), name: "film".into() },
                minf: Minf {
                    vmhd: Some(Vmhd::default()),
                    dinf: Dinf { dref: Dref { entries: vec![DrefEntry::Url(Url::default())] } },
                    stbl: Stbl {
                        stsd: Stsd { codecs: vec![codec.into()] },
                        stco: Some(Stco::default()),
                        ..Stbl::default()
                    },
                    ..Minf::default()
                },
            },
            ..Trak::default()
        };
        let movie = Moov {
            mvhd: Mvhd { timescale, rate: 1.into(), next_track_id: 2, ..Mvhd::default() },
            trak: vec![track],
            mvex: Some(Mvex {
                mehd: Some(Mehd { fragment_duration: pictures * u64::from(TICKS) }),
                trex: vec![Trex {
                    track_id: 1,
                    default_sample_description_index: 1,
                    default_sample_duration: TICKS,
                    ..Trex::default()
                }],
            }),
            ..Moov::default()
        };
        let brands = [b"iso6", b"av01", b"mp41"].map(Into::into).to_vec();
        let mut head = Vec::new();
        put(&Ftyp { major_brand: b"iso6".into(), minor_version: 0, compatible_brands: brands }, &mut head)?;
        put(&movie, &mut head)?;
        Ok(head)
    }

    /// Bytes that are kept free for the index.
    fn room(&self) -> u64 {
        let groups = self.format.pictures.div_ceil(self.format.group());
        if groups <= MOST { INDEX + ENTRY * groups } else { 0 }
    }

    /// The index, and what it leaves free of its room.
    fn index(&self, room: u64) -> io::Result<Vec<u8>> {
        let reference = |&(size, pictures): &(u32, u32)| SegmentReference {
            reference_type: false,
            referenced_size: size,
            subsegment_duration: pictures * TICKS,
            starts_with_sap: true,
            sap_type: 1,
            sap_delta_time: 0,
        };
        // No more than were expected: the room is for those.
        let most = room.saturating_sub(INDEX) / ENTRY;
        let references: Vec<SegmentReference> =
            self.fragments.iter().take(most as usize).map(reference).collect();
        let left = room - INDEX - ENTRY * references.len() as u64;
        let index = Sidx {
            reference_id: 1,
            timescale: self.format.timescale(),
            earliest_presentation_time: 0,
            first_offset: left,
            references,
        };
        let mut bytes = Vec::new();
        put(&index, &mut bytes)?;
        if let Some(size) = left.checked_sub(BOX) {
            put(&Free { zeroed: Zeroed::new(size as usize) }, &mut bytes)?;
        }
        Ok(bytes)
    }
}

/// Kinds of a unit of the stream (AV1 specification, 6.2.2).
const SEQUENCE_HEADER: u8 = 1;
const TEMPORAL_DELIMITER: u8 = 2;

/// A unit at the start of a stream: its kind, and where it ends.
struct Unit {
    kind: u8,
    end: usize,
}

/// The first unit of a stream (AV1 specification, 5.3.2), if it tells its size, as units of the encoder do.
fn unit(data: &[u8]) -> Option<Unit> {
    let header = *data.first()?;
    let (kind, extended, sized) = (header >> 3 & 15, header & 4 != 0, header & 2 != 0);
    let mut at = 1 + usize::from(extended);
    let mut size = 0_usize;
    for shift in (0..8).map(|k| 7 * k) {
        let byte = *data.get(at)?;
        at += 1;
        size |= usize::from(byte & 127) << shift;
        if byte & 128 == 0 {
            break;
        }
    }
    let end = at.checked_add(size)?;
    (sized && end <= data.len()).then_some(Unit { kind, end })
}

fn put(what: &impl Atom, bytes: &mut Vec<u8>) -> io::Result<()> {
    what.encode(bytes).map_err(io::Error::other)
}

fn fits<T: TryFrom<u64>>(size: u64) -> io::Result<T> {
    T::try_from(size).map_err(|_| io::Error::other("half a second of the film is larger than 2 GB"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_tells_its_kind_and_size() {
        let found = |data: &[u8]| unit(data).map(|unit| (unit.kind, unit.end));
        assert_eq!(found(&[0x12, 0x00, 0x0a]), Some((TEMPORAL_DELIMITER, 2)));
        assert_eq!(found(&[0x0a, 0x02, 7, 7, 9]), Some((SEQUENCE_HEADER, 4)));
        let long = [&[0x0a, 0x80, 0x01][..], &[0; 128]].concat();
        assert_eq!(found(&long), Some((SEQUENCE_HEADER, 131)));
        // Cut off, without a size, and nothing.
        for broken in [&[0x0a, 0x05, 1][..], &[0x08, 1], &[0x0a, 0xff], &[]] {
            assert_eq!(found(broken), None);
        }
    }
}
