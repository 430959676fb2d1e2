//! How deep the brackets of a text go: the TOML parser calls itself for each, and a stack is finite.

/// Deeper than any scene needs.
pub(crate) const DEEPEST: usize = 64;

/// The byte where brackets first go deeper than [`DEEPEST`], strings and comments left out.
pub(crate) fn too_deep(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let (mut at, mut depth) = (0, 0usize);
    while at < bytes.len() {
        match bytes[at] {
            b'#' => at = line_end(bytes, at),
            quote @ (b'"' | b'\'') => at = string_end(bytes, at, quote),
            b'[' | b'{' => {
                depth += 1;
                if depth > DEEPEST {
                    return Some(at);
                }
                at += 1;
            }
            b']' | b'}' => {
                depth = depth.saturating_sub(1);
                at += 1;
            }
            _ => at += 1,
        }
    }
    None
}

fn line_end(bytes: &[u8], at: usize) -> usize {
    bytes[at..].iter().position(|&b| b == b'\n').map_or(bytes.len(), |n| at + n)
}

/// The byte after the string that begins at `at`; a string of one line ends with its line at the latest.
fn string_end(bytes: &[u8], at: usize, quote: u8) -> usize {
    let triple = [quote; 3];
    let long = bytes[at..].starts_with(&triple);
    let mut end = at + if long { 3 } else { 1 };
    while end < bytes.len() {
        match bytes[end] {
            b'\\' if quote == b'"' => end += 2,
            b'\n' if !long => return end,
            b if b == quote && !long => return end + 1,
            b if b == quote && bytes[end..].starts_with(&triple) => return end + 3,
            _ => end += 1,
        }
    }
    bytes.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brackets_count_outside_strings_and_comments_only() {
        let many = "[".repeat(1000);
        assert_eq!(too_deep(&many), Some(DEEPEST));
        let hidden = format!("# {many}\nx = \"\\\"{many}\"\ny = '{many}'\nz = \"\"\"\n\"{many}\"\"\"\n");
        assert_eq!(too_deep(&hidden), None);
        assert_eq!(too_deep(&format!("{hidden}{many}")), Some(hidden.len() + DEEPEST));
        assert_eq!(too_deep(&"[[1], [2]]\n".repeat(100)), None);
    }
}
