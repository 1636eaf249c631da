//! Collects constants with the same prefix into enums.

use std::collections::{BTreeMap, BTreeSet};

use uavspec_runtime::Scalar;

use crate::enumeration::{is_sentinel, longest_prefix};
use crate::{Element, Enum, Member, Message};

/// An enum, and the members that are out of range.
pub(super) struct Candidate {
    pub(super) found: Enum,
    /// The index and value of each constant that doesn't fit the type.
    pub(super) out_of_range: Vec<(usize, i128)>,
}

/// The constants of a message, grouped by prefix. Each constant belongs to the longest claimed prefix of its name.
pub(super) struct ByPrefix {
    /// The members of each claimed prefix, in declaration order.
    members: BTreeMap<String, Vec<Member>>,
    /// The names of all constants, sorted.
    names: BTreeSet<String>,
}

/// Groups the constants of `message` by the `claimed` prefixes of all fields.
pub(super) fn by_prefix(message: &Message, claimed: &BTreeSet<String>) -> ByPrefix {
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
    /// True if a constant starts with `prefix` and `_`.
    pub(super) fn is_used(&self, prefix: &str) -> bool {
        let start = format!("{prefix}_");
        self.names.range(start.clone()..).next().is_some_and(|name| name.starts_with(&start))
    }

    /// The number of constants with this prefix.
    pub(super) fn count(&self, prefix: &str) -> usize {
        self.members.get(prefix).map_or(0, Vec::len)
    }

    /// Creates the enum of `prefixes`.
    pub(super) fn gather(
        &self,
        message: &Message,
        prefixes: &[String],
        scalar: Scalar,
        is_flags: bool,
    ) -> Candidate {
        let distinct: BTreeSet<&str> = prefixes.iter().map(String::as_str).collect();
        let mut members: Vec<Member> =
            distinct.into_iter().filter_map(|prefix| self.members.get(prefix)).flatten().cloned().collect();
        members.sort_by_key(|member| member.constant);
        if is_flags && are_bit_numbers(&members, scalar) {
            for member in &mut members {
                member.value = 1 << member.value;
            }
        }
        let (min, max) = scalar.integer_bounds().unwrap_or((0, 0));
        let (fitting, outside): (Vec<Member>, Vec<Member>) =
            members.into_iter().partition(|member| (min..=max).contains(&member.value));
        let out_of_range = outside.into_iter().map(|member| (member.constant, member.value)).collect();
        let mut found = Enum { prefixes: prefixes.to_vec(), scalar, is_flags, members: fitting };
        make_names_unique(&mut found, message);
        Candidate { found, out_of_range }
    }
}

/// True if the constants of a mask are bit numbers (`0, 1, 2, 3`) rather than masks (`1, 2, 4`). The constants are bit
/// numbers if each is a valid bit number of the type and at least one has several bits set.
fn are_bit_numbers(members: &[Member], scalar: Scalar) -> bool {
    let bits = 8 * i128::try_from(scalar.size()).unwrap_or(0);
    members.iter().all(|member| (0..bits).contains(&member.value))
        && members.iter().any(|member| member.value.count_ones() > 1)
}

/// Makes the names of members unique: a duplicate gets its full name, with the prefix.
fn make_names_unique(found: &mut Enum, message: &Message) {
    let mut seen = BTreeSet::new();
    for member in &mut found.members {
        if !seen.insert(member.name.clone()) {
            member.name.clone_from(&message.constants[member.constant].name);
            seen.insert(member.name.clone());
        }
    }
}
