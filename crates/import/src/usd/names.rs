//! Names that the library can walk up from.

/// Whether braces close what they opened, none within others: as in `/Stone{size=big}Chip`, the path of a prim in a variant.
///
/// The library takes the parent of a path that ends with a brace by looking for the one that opened it. Where there is none, the parent of such a path is
/// the path itself (`Path::parent` of openusd 0.6), and whoever goes up from it never arrives.
pub(super) fn braces_close(name: &[u8]) -> bool {
    let mut open = false;
    for byte in name {
        match (byte, open) {
            (b'{', false) => open = true,
            (b'}', true) => open = false,
            (b'{' | b'}', _) => return false,
            _ => {}
        }
    }
    !open
}

/// Says what is wrong with a name whose braces do not.
pub(super) fn refused(name: &str) -> String {
    let start: String = name.chars().take(60).collect();
    format!("the braces in {start:?} do not close one another, expected a name or a path")
}
