//! Enums whose constants are bits, although the definition doesn't say so with `@flags`.

use std::collections::BTreeSet;

use super::enumeration::Enum;
use super::model::{Field, Message};

/// Words for bit fields, in comments and field names.
const WORDS: [&str; 8] = ["bitmask", "bitmasks", "bitmap", "bitfield", "bitset", "bitwise", "mask", "bits"];

/// True if the constants of an enum are bits. `owner` contains the constants.
pub fn are_bits(found: &Enum, owner: &Message) -> bool {
    found.is_flags || are_masks(found) || are_named_bits(found, owner)
}

/// True if the values are powers of two up to at least 8, and not consecutive numbers.
fn are_masks(found: &Enum) -> bool {
    let values: BTreeSet<i128> = found.members.iter().map(|member| member.value).collect();
    let powers = values.iter().filter(|value| **value > 0 && value.count_ones() == 1).count();
    let others = values.iter().filter(|value| **value != 0).count() - powers;
    powers >= 4 && [1, 2, 4].iter().all(|low| values.contains(low)) && others <= 1 && !values.contains(&3)
}

/// True if all names contain `BIT` or `MASK`.
fn are_named_bits(found: &Enum, owner: &Message) -> bool {
    let is_bit = |name: &str| name.split('_').any(|word| matches!(word, "BIT" | "MASK"));
    found.members.len() > 1
        && found.members.iter().all(|member| is_bit(&owner.constants[member.constant].name))
}

/// True if the description or the name of a field says that its value consists of bits.
pub fn mentions_bits(field: &Field) -> bool {
    let words = field.description.split(|c: char| !c.is_alphanumeric()).chain(field.name.split('_'));
    words.map(str::to_ascii_lowercase).any(|word| WORDS.contains(&word.as_str()))
}
