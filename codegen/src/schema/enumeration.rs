//! Enums and flags: which constants a field holds.

use std::collections::{BTreeMap, BTreeSet};

use uavspec_runtime::Scalar;

use super::{Element, Message, MessageId};

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
    /// Its index in [`Message::enums`].
    pub index: usize,
}

/// What an enum would have, but for the range of its type.
pub(crate) struct Candidate {
    pub(crate) found: Enum,
    /// Constants that the type can't hold: index and value.
    pub(crate) out_of_range: Vec<(usize, i128)>,
}

/// The constants of a message by the prefix that they belong to: the longest of all claimed prefixes
/// that they start with.
pub(crate) struct ByPrefix {
    /// For each claimed prefix its members, in declared order.
    members: BTreeMap<String, Vec<Member>>,
    /// All names, sorted.
    names: BTreeSet<String>,
}

/// Divides the constants of `message` among the `claimed` prefixes, once for all fields.
pub(crate) fn by_prefix(message: &Message, claimed: &BTreeSet<String>) -> ByPrefix {
    let mut members: BTreeMap<String, Vec<Member>> = BTreeMap::new();
    for (index, constant) in message.constants.iter().enumerate() {
        let (Element::Scalar(_), Some(value)) = (constant.ty, constant.value.as_int()) else { continue };
        let Some((prefix, rest)) = longest_prefix(&constant.name, claimed) else { continue };
        if !is_sentinel(rest) {
            let member = Member { name: rest.to_owned(), constant: index, value };
            members.entry(prefix.to_owned()).or_default().push(member);
        }
    }
    ByPrefix { members, names: message.constants.iter().map(|constant| constant.name.clone()).collect() }
}

impl ByPrefix {
    /// Whether any constant starts with `prefix` and `_`.
    pub(crate) fn is_used(&self, prefix: &str) -> bool {
        let start = format!("{prefix}_");
        self.names.range(start.clone()..).next().is_some_and(|name| name.starts_with(&start))
    }

    /// How many constants belong to `prefix`.
    pub(crate) fn count(&self, prefix: &str) -> usize {
        self.members.get(prefix).map_or(0, Vec::len)
    }

    /// Gathers the enum of `prefixes`.
    pub(crate) fn gather(
        &self,
        message: &Message,
        prefixes: &[String],
        scalar: Scalar,
        is_flags: bool,
    ) -> Candidate {
        let distinct: BTreeSet<&String> = prefixes.iter().collect();
        let mut members: Vec<Member> =
            distinct.into_iter().filter_map(|prefix| self.members.get(prefix)).flatten().cloned().collect();
        members.sort_by_key(|member| member.constant);
        if is_flags && are_bit_numbers(&members, scalar) {
            for member in &mut members {
                member.value = 1 << member.value;
            }
        }
        let (least, greatest) = scalar.integer_bounds().unwrap_or((0, 0));
        let (fitting, outside): (Vec<Member>, Vec<Member>) =
            members.into_iter().partition(|member| (least..=greatest).contains(&member.value));
        let out_of_range = outside.into_iter().map(|member| (member.constant, member.value)).collect();
        let mut found = Enum { prefixes: prefixes.to_vec(), scalar, is_flags, members: fitting };
        tell_apart(&mut found, message);
        Candidate { found, out_of_range }
    }
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
fn is_sentinel(rest: &str) -> bool {
    SENTINELS.contains(&rest) || SENTINEL_ENDINGS.iter().any(|ending| rest.ends_with(ending))
}

/// Whether the constants of a mask number its bits (`0, 1, 2, 3`) rather than being masks (`1, 2, 4`):
/// so where not all are powers of two and each is the number of a bit of the type.
fn are_bit_numbers(members: &[Member], scalar: Scalar) -> bool {
    let bits = 8 * i128::try_from(scalar.size()).unwrap_or(0);
    members.iter().all(|member| (0..bits).contains(&member.value))
        && members.iter().any(|member| member.value.count_ones() > 1)
}

/// Members of two prefixes may be called the same: those of all but the first prefix then keep it.
fn tell_apart(found: &mut Enum, message: &Message) {
    let mut seen = BTreeSet::new();
    for member in &mut found.members {
        if !seen.insert(member.name.clone()) {
            member.name.clone_from(&message.constants[member.constant].name);
            seen.insert(member.name.clone());
        }
    }
}
