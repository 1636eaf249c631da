//! Enums and flags, which list the constants for a field.

use std::collections::{BTreeSet, HashMap};

use uavspec_runtime::Scalar;

use super::id::MessageId;

/// A constant is not a member of an enum if its name consists of the enum's prefix and one of these words. The value of
/// such a constant is the count or limit of the members. With the prefix `GPS`, `GPS_COUNT` is not a member, but
/// `GPS_MIN_SAT_COUNT` is.
const SENTINELS: [&str; 5] = ["COUNT", "MAX", "LAST", "NUM", "ENUM_END"];

/// Constants with these endings are not members either. In `MAVLink`, these constants mark the end of each block of
/// commands.
const SENTINEL_ENDINGS: [&str; 2] = ["_LAST", "_ENUM_END"];

/// The constants that a field may contain: one of them or, for flags, any combination. Enums are open, because newer
/// firmware may send unknown values.
#[derive(Clone, Debug, PartialEq)]
pub struct Enum {
    /// The prefixes of the constants, in the order of the annotation.
    pub prefixes: Vec<String>,
    /// The type of the fields, which may differ from the type of the constants.
    pub scalar: Scalar,
    /// True if values are bit masks.
    pub is_flags: bool,
    /// The members, in declaration order. If several members have the same value, the later ones are aliases of the
    /// first.
    pub members: Vec<Member>,
}

/// A member of an enum.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Member {
    /// The name without the prefix.
    pub name: String,
    /// The index of the constant in the message that defines it.
    pub constant: usize,
    /// The value of the constant; for flags, the mask.
    pub value: i128,
}

impl Enum {
    /// All members. An alias is paired with the first member that has the same value, other members
    /// with `None`.
    pub fn with_aliases(&self) -> impl Iterator<Item = (&Member, Option<&Member>)> {
        let mut first = HashMap::new();
        self.members.iter().map(move |member| {
            let leader: &Member = first.entry(member.value).or_insert(member);
            (member, Some(leader).filter(|leader| leader.name != member.name))
        })
    }
}

/// A reference to an enum of a message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EnumRef {
    /// The message that defines the constants.
    pub message: MessageId,
    /// The index in `Message::enums`.
    pub index: usize,
}

/// True if the value of a constant is the count or limit of other constants in `names` that have the same prefix. The
/// result doesn't depend on whether any field uses these constants.
pub fn is_sentinel_among(name: &str, names: &BTreeSet<&str>) -> bool {
    let prefix = SENTINELS.iter().find_map(|word| name.strip_suffix(word)?.strip_suffix('_'));
    prefix.is_some_and(|prefix| {
        let start = format!("{prefix}_");
        let mut alike = names.range(start.as_str()..).take_while(|other| other.starts_with(&start));
        alike.any(|other| *other != name)
    })
}

/// The longest claimed prefix of `name`, and the part after its `_`.
pub fn longest_prefix<'n, 'c>(name: &'n str, claimed: &'c BTreeSet<String>) -> Option<(&'c str, &'n str)> {
    // Search backwards, so that the first match is the longest.
    name.rmatch_indices('_').find_map(|(at, _)| {
        let prefix = claimed.get(&name[..at])?;
        Some((prefix.as_str(), &name[at + 1..])).filter(|(_, rest)| !rest.is_empty())
    })
}

/// True if the value of a constant is the count or limit of the members of an enum. `rest` is the constant's name
/// without the prefix.
pub fn is_sentinel(rest: &str) -> bool {
    SENTINELS.contains(&rest) || SENTINEL_ENDINGS.iter().any(|ending| rest.ends_with(ending))
}
