//! Checksums of JSON files, within the files.
//!
//! A checksum is that of the content: of the text without spaces between its parts, and without the checksum itself. So a file stays
//! whole in one piece, whatever the moment at which a program is killed, and other programs need not know of it.

use serde_json::{Map, Value};
use xxhash_rust::xxh3::xxh3_64;

/// The checksum of a file's bytes: XXH3, 16 hexadecimal digits.
pub fn checksum(bytes: &[u8]) -> String {
    format!("{:016x}", xxh3_64(bytes))
}

/// The name of the checksum, 16 hexadecimal digits.
const NAME: &str = "checksum";

/// Puts the checksum of `object` into it.
pub(crate) fn seal(object: &mut Value, place: &[&str]) {
    if let Some(map) = find(object, place) {
        map.shift_remove(NAME);
    }
    let sum = sum(object);
    if let Some(map) = find(object, place) {
        map.insert(NAME.to_owned(), sum.into());
    }
}

/// Whether `object` is what it was when it was sealed. True of one that never was: older versions did not.
pub(crate) fn is_sound(mut object: Value, place: &[&str]) -> bool {
    let stored = find(&mut object, place).and_then(|map| map.shift_remove(NAME));
    stored.is_none_or(|stored| stored == sum(&object))
}

/// The object within `object` that holds the checksum.
fn find<'a>(object: &'a mut Value, place: &[&str]) -> Option<&'a mut Map<String, Value>> {
    place.iter().try_fold(object, |object, name| object.get_mut(name))?.as_object_mut()
}

fn sum(object: &Value) -> String {
    checksum(object.to_string().as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn spaces_change_nothing_and_all_else_is_found() {
        let mut object = json!({"shape": [3, 4], "attributes": {"units": "m"}});
        assert!(is_sound(object.clone(), &["attributes"]));
        seal(&mut object, &["attributes"]);
        let once = object.clone();
        seal(&mut object, &["attributes"]);
        assert_eq!(object, once);
        let pretty = serde_json::to_string_pretty(&object).unwrap();
        assert!(is_sound(serde_json::from_str(&pretty).unwrap(), &["attributes"]));
        for (old, new) in [("3", "5"), ("units", "unite"), ("\"m\"", "\"k\"")] {
            let other = object.to_string().replacen(old, new, 1);
            assert!(!is_sound(serde_json::from_str(&other).unwrap(), &["attributes"]), "{other}");
        }
    }
}
