//! LZ4 blocks as the format frames them: a byte that counts pieces, 0 for a single one without further ado; of several, each has its length before it.

/// The most that LZ4 takes in one piece, bytes.
const PIECE: usize = 0x7e00_0000;

/// Compresses `data`, of up to 127 pieces.
pub(crate) fn compress(data: &[u8]) -> Vec<u8> {
    in_pieces(data, PIECE)
}

fn in_pieces(data: &[u8], most: usize) -> Vec<u8> {
    let block = lz4_flex::block::compress;
    if data.len() <= most {
        return [&[0], &block(data)[..]].concat();
    }
    let mut out = vec![data.len().div_ceil(most) as u8];
    for piece in data.chunks(most) {
        let packed = block(piece);
        out.extend((packed.len() as u32).to_le_bytes());
        out.extend(packed);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use lz4_flex::block::decompress;

    fn data() -> Vec<u8> {
        (0..1000u32).flat_map(|k| (k % 37 * k).to_le_bytes()).collect()
    }

    #[test]
    fn one_piece_has_a_zero_before_it() {
        let packed = compress(&data());
        assert_eq!(packed[0], 0);
        assert_eq!(decompress(&packed[1..], 4000).unwrap(), data());
    }

    #[test]
    fn pieces_have_their_lengths_before_them() {
        let packed = in_pieces(&data(), 1500);
        assert_eq!(packed[0], 3);
        let (mut rest, mut out) = (&packed[1..], Vec::new());
        while let Some((length, after)) = rest.split_first_chunk::<4>() {
            let (piece, after) = after.split_at(u32::from_le_bytes(*length) as usize);
            out.extend(decompress(piece, 1500).unwrap());
            rest = after;
        }
        assert_eq!(out, data());
    }
}
