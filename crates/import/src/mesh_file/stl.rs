//! Stereolithography files, text and binary.

use super::TriangleSoup;
use rockfall_math::Vec3;
use std::io::Cursor;

/// Bytes before the first triangle of a binary file, and of each triangle.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;

/// The triangles of all solids. Normals are passed over: they follow from the order of the corners.
pub(super) fn parse(bytes: &[u8]) -> Result<TriangleSoup, String> {
    let expected = binary_length(bytes);
    // Many binary files begin with the word "solid" as well, so that the length decides first.
    let mut content = if expected != Some(bytes.len()) && is_text(bytes) {
        Cursor::new(tidy(bytes)?.into_bytes())
    } else {
        match expected {
            None => {
                return Err("it is neither text that begins with `solid` nor long enough to be binary".into());
            }
            Some(expected) if bytes.len() < expected => {
                let count = (expected - HEADER) / TRIANGLE;
                let length = bytes.len();
                return Err(format!("{count} triangles take {expected} bytes, but there are only {length}"));
            }
            Some(_) => {
                // The library goes by this word.
                let mut binary = bytes.to_vec();
                binary[..5].fill(b' ');
                Cursor::new(binary)
            }
        }
    };
    let mesh = stl_io::read_stl(&mut content).map_err(|e| e.to_string())?;
    Ok(TriangleSoup {
        vertices: mesh.vertices.iter().map(|v| Vec3::from_array(v.0)).collect(),
        triangles: mesh.faces.iter().map(|f| f.vertices.map(|c| c as u32)).collect(),
    })
}

/// What the header of a binary file says about its length, bytes.
fn binary_length(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEADER - 4..HEADER)?.first_chunk()?;
    Some(HEADER + TRIANGLE * u32::from_le_bytes(*count) as usize)
}

fn is_text(bytes: &[u8]) -> bool {
    bytes.trim_ascii_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
}

/// One solid in small letters, with zeros for normals: programs write several solids into a file, leave out
/// their names, and give "nan" as the normal of a triangle without area, none of which the library takes.
/// Words are checked here because it names no line; their order is left to it.
fn tidy(bytes: &[u8]) -> Result<String, String> {
    let text = String::from_utf8_lossy(bytes).to_ascii_lowercase();
    let first_word = |line: &str| line.split_whitespace().next().map(str::to_owned);
    let last = text.lines().rev().find_map(first_word);
    if !matches!(last.as_deref(), Some("endsolid" | "end")) {
        return Err("the file is cut off: it does not end with `endsolid`".into());
    }
    let mut tidied = String::with_capacity(text.len());
    tidied.push_str("solid s\n");
    for (i, line) in text.lines().enumerate() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            [] | ["solid" | "endsolid" | "end", ..] => continue,
            ["facet", ..] => tidied.push_str("facet normal 0 0 0"),
            ["vertex", x, y, z] if [x, y, z].iter().all(|n| n.parse::<f32>().is_ok_and(f32::is_finite)) => {
                tidied.push_str(line);
            }
            ["vertex", ..] => {
                return Err(format!("line {}: expected `vertex` and three finite numbers", i + 1));
            }
            ["outer" | "endloop" | "endfacet", ..] => tidied.push_str(line),
            [word, ..] => {
                return Err(format!("line {}: `{}` has no meaning here", i + 1, word.escape_debug()));
            }
        }
        tidied.push('\n');
    }
    tidied.push_str("endsolid s\n");
    Ok(tidied)
}
