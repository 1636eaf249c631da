//! JSON pointers.

use crate::text::start_of;

/// The maximum length of a key, in characters.
const MAX_KEY: usize = 64;

/// A JSON pointer (RFC 6901). Very long keys are shortened.
pub fn pointer<K: AsRef<str>>(keys: &[K]) -> String {
    let keys = keys.iter().map(AsRef::as_ref);
    let mut pointer = String::with_capacity(keys.clone().map(|key| 1 + key.len()).sum());
    for key in keys {
        pointer.push('/');
        for character in start_of(key, MAX_KEY).chars() {
            match character {
                '~' => pointer.push_str("~0"),
                '/' => pointer.push_str("~1"),
                other => pointer.push(other),
            }
        }
    }
    pointer
}
