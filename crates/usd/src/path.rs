//! Paths of prims and properties, and the tree as which a file holds them.
//!
//! A file has paths in depth-first order, each as the name that it adds to the path above it. Of the three lists that describe the tree, one
//! tells where a path comes in the numbering that the rest of the file uses, one which token its last name is, negative for a property, and one what follows:
//!
//! | jump | what follows |
//! |---|---|
//! | -2 | nothing below it and nothing beside it |
//! | -1 | the first path below it |
//! | 0 | the next path beside it |
//! | n | the first path below it, and n places on the next one beside it |

use crate::Error;

/// The path of the layer itself.
pub(crate) const ROOT: &str = "/";

/// Appends the name of a prim to the path of the one above it.
pub(crate) fn below(parent: &str, name: &str) -> Result<String, Error> {
    if !is_identifier(name) {
        return Err(Error::Name { what: "prim", name: name.to_owned() });
    }
    Ok(format!("{}/{name}", parent.trim_end_matches('/')))
}

/// Appends the name of a property to the path of its prim.
pub(crate) fn property(prim: &str, name: &str) -> Result<String, Error> {
    if !name.split(':').all(is_identifier) {
        return Err(Error::Name { what: "property", name: name.to_owned() });
    }
    Ok(format!("{prim}.{name}"))
}

/// Whether a path is absolute and made of names.
pub(crate) fn check(path: &str) -> Result<(), Error> {
    let (prim, property) = match path.split_once('.') {
        Some((prim, property)) => (prim, Some(property)),
        None => (path, None),
    };
    let prims = prim.strip_prefix('/').is_some_and(|names| names.split('/').all(is_identifier));
    match (prims && property.is_none_or(|name| name.split(':').all(is_identifier))) || path == ROOT {
        true => Ok(()),
        false => Err(Error::Path(path.to_owned())),
    }
}

fn is_identifier(name: &str) -> bool {
    let plain = |c: char| c == '_' || c.is_ascii_alphanumeric();
    name.chars().all(plain) && name.starts_with(|c: char| !c.is_ascii_digit())
}

/// The path above; of a path in the root that is the root, of the root nothing.
pub(crate) fn parent(path: &str) -> Option<&str> {
    match path.rfind(['/', '.'])? {
        0 if path == ROOT => None,
        0 => Some(ROOT),
        end => Some(&path[..end]),
    }
}

/// What a path adds to the one above it, and whether that is a property.
pub(crate) fn last_name(path: &str) -> (&str, bool) {
    let cut = path.rfind(['/', '.']).unwrap_or(0);
    (path.get(cut + 1..).unwrap_or_default(), path[cut..].starts_with('.'))
}

/// Sorts paths so that those below a path follow it: bytewise, because `.` and `/` come before all characters of names.
pub(crate) fn sort(paths: &mut [&str]) {
    paths.sort_unstable_by_key(|&path| if path == ROOT { "" } else { path });
}

/// What follows each path. They are sorted, and with each is the one above it.
pub(crate) fn jumps(paths: &[&str]) -> Vec<i64> {
    let mut jumps = vec![0; paths.len()];
    // The last path so far at each depth of the branch at hand.
    let mut branch: Vec<usize> = Vec::new();
    let depth = |path: &str| if path == ROOT { 0 } else { path.matches(['/', '.']).count() };
    for (k, path) in paths.iter().enumerate() {
        let depth = depth(path);
        let beside = branch.get(depth).copied();
        branch.truncate(depth);
        if let Some(before) = beside {
            jumps[before] = if before + 1 == k { 0 } else { (k - before) as i64 };
        }
        // Until one beside it is found.
        let has_below = paths.get(k + 1).is_some_and(|next| parent(next) == Some(path));
        jumps[k] = if has_below { -1 } else { -2 };
        branch.push(k);
    }
    jumps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_usd_does_not_allow_are_refused() {
        for name in ["", "1st", "a b", "a.b", "a/b", "ä", "a:b"] {
            assert_eq!(below("/", name), Err(Error::Name { what: "prim", name: name.to_owned() }));
        }
        for name in ["", "a:", ":a", "a:1", "a.b"] {
            assert_eq!(property("/A", name), Err(Error::Name { what: "property", name: name.to_owned() }));
        }
        assert_eq!(below("/", "A_1").unwrap(), "/A_1");
        assert_eq!(below("/A", "_2").unwrap(), "/A/_2");
        assert_eq!(property("/A", "xformOp:translate").unwrap(), "/A.xformOp:translate");
    }

    #[test]
    fn paths_are_absolute() {
        for path in ["/", "/A", "/A/b_2", "/A/B.c", "/A.primvars:displayColor"] {
            assert_eq!(check(path), Ok(()));
        }
        for path in ["", "A", "/A/", "//A", "/A.", "/.a", ".a", "/A.b/c", "/A.b.c", "../A"] {
            assert_eq!(check(path), Err(Error::Path(path.to_owned())));
        }
    }

    #[test]
    fn paths_come_apart() {
        assert_eq!((parent("/A/B.c"), last_name("/A/B.c")), (Some("/A/B"), ("c", true)));
        assert_eq!((parent("/A/B"), last_name("/A/B")), (Some("/A"), ("B", false)));
        assert_eq!((parent("/A"), last_name("/A")), (Some("/"), ("A", false)));
        assert_eq!((parent("/"), last_name("/")), (None, ("", false)));
    }

    #[test]
    fn the_tree_is_what_the_paths_say() {
        let mut paths = ["/B", "/A2", "/A/C/D", "/", "/A/C", "/A.x", "/A", "/A/E", "/A.x:y"];
        sort(&mut paths);
        assert_eq!(paths, ["/", "/A", "/A.x", "/A.x:y", "/A/C", "/A/C/D", "/A/E", "/A2", "/B"]);
        assert_eq!(jumps(&paths), [-1, 6, 0, 0, 2, -2, -2, 0, -2]);
    }
}
