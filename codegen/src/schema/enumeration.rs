//! Enums and flags: which constants a field holds.

use std::collections::BTreeSet;

use uavspec_runtime::Scalar;

use super::id::MessageId;

/// Last words of constants that count or bound an enum and are no member of it. The list is explicit:
/// `MIN_SAT_COUNT` of a prefix `GPS` is a member, `COUNT` is not.
const SENTINELS: [&str; 5] = ["COUNT", "MAX", "LAST", "NUM", "ENUM_END"];

/// Endings that make a sentinel of a longer rest: `MAVLink` marks the end of each block of commands so.
const SENTINEL_ENDINGS: [&str; 2] = ["_LAST", "_ENUM_END"];

/// Constants that a field holds: one of them, or for flags any set of them. Enums are open: firmware
/// of tomorrow sends values that are unknown today.
#[derive(Clone, Debug, PartialEq)]
pub struct Enum {
    /// Starts of the names of its constants, in the order in which the annotation lists them.
    pub prefixes: Vec<String>,
    /// Type of the fields that hold it, which may differ from that of the constants.
    pub scalar: Scalar,
    /// Whether values are combined bit by bit.
    pub is_flags: bool,
    /// Its members, in declared order. Several may share a value: the first is its name, the others
    /// are aliases.
    pub members: Vec<Member>,
}

/// A member of an enum.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Member {
    /// Its name without the prefix.
    pub name: String,
    /// Index of its constant in the message that owns the enum.
    pub constant: usize,
    /// Its value: the constant's; for flags the mask.
    pub value: i128,
}

impl Enum {
    /// The member whose name stands for `member`'s value, where that is another one.
    pub fn alias_of(&self, member: &Member) -> Option<&Member> {
        self.members
            .iter()
            .find(|other| other.value == member.value)
            .filter(|other| other.name != member.name)
    }
}

/// Names an enum of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EnumRef {
    /// The message whose constants it holds.
    pub message: MessageId,
    /// Its index in `Message::enums`.
    pub index: usize,
}

/// Whether a constant counts or bounds those of `names` that start like it, whether or not a field claims them.
pub(crate) fn is_sentinel_among(name: &str, names: &BTreeSet<&str>) -> bool {
    let prefix = SENTINELS.iter().find_map(|word| name.strip_suffix(word)?.strip_suffix('_'));
    prefix.is_some_and(|prefix| {
        let start = format!("{prefix}_");
        let mut alike = names.range(start.as_str()..).take_while(|other| other.starts_with(&start));
        alike.any(|other| *other != name)
    })
}

/// The longest claimed prefix that `name` starts with, and what follows its `_`.
pub(crate) fn longest_prefix<'n, 'c>(
    name: &'n str,
    claimed: &'c BTreeSet<String>,
) -> Option<(&'c str, &'n str)> {
    // From the last `_` on, so that the first hit is the longest.
    name.rmatch_indices('_').find_map(|(at, _)| {
        let prefix = claimed.get(&name[..at])?;
        Some((prefix.as_str(), &name[at + 1..])).filter(|(_, rest)| !rest.is_empty())
    })
}

/// Whether a constant that belongs to a prefix, after which `rest` follows, counts or bounds an enum.
pub(crate) fn is_sentinel(rest: &str) -> bool {
    SENTINELS.contains(&rest) || SENTINEL_ENDINGS.iter().any(|ending| rest.ends_with(ending))
}
