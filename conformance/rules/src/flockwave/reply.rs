//! Checks of responses against their requests.

use std::collections::{BTreeMap, BTreeSet};

use uavspec_flockwave::body_schema::Deviation;
use uavspec_flockwave::limits::MAX_ID;
use uavspec_flockwave::session::{OPERATIONS, parts};

use super::prelude::*;
use crate::limits::MAX_LISTED;

/// The approximate overhead of a stored id, in bytes.
const OVERHEAD: usize = 40;

/// The maximum time between lists that are compared, in seconds. Objects come and go, and a server need not report that
/// an object is gone.
const MAX_LIST_AGE: f64 = 10.0;

/// The maximum number of misplaced objects in a finding.
const MAX_LISTED_ITEMS: usize = 4;

/// Checks that responses of these types contain each requested object in exactly one part.
pub(super) fn partition(exchange: &Exchange<'_>, context: &mut RuleContext<'_>, types: &[&str]) {
    let Some((request, parts)) = replied(exchange, types) else { return };
    // Any response fits a request without objects.
    if request.is_empty() {
        return;
    }
    context.covered();
    let mut found: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for part in parts {
        for object in named(exchange, part).filter(|object| request.contains(*object)) {
            let listed_in = found.entry(object).or_default();
            if listed_in.last() != Some(part) {
                listed_in.push(part);
            }
        }
    }
    let listed_in = |object: &String| found.get(object.as_str()).cloned().unwrap_or_default();
    let wrong = request
        .iter()
        .map(|object| (object, listed_in(object)))
        .filter(|(_, listed_in)| listed_in.len() != 1);
    let wrong: Vec<(&String, Vec<&str>)> = wrong.collect();
    if !wrong.is_empty() {
        exchange.violates(context, || {
            let reported = wrong.iter().take(MAX_LISTED_ITEMS).map(|(object, found)| {
                let place = match (found.len(), undefined_part(exchange, object)) {
                    (0, None) => "none".to_owned(),
                    (0, Some(part)) => format!("{}, which is not defined", body::quoted(part)),
                    _ => found.join(" and "),
                };
                format!("{} in {place}", body::quoted(object))
            });
            let mut reported: Vec<String> = reported.collect();
            if wrong.len() > MAX_LISTED_ITEMS {
                reported.push(format!("{} more", wrong.len() - MAX_LISTED_ITEMS));
            }
            let reported = reported.join(", ");
            Detail::new(format!(
                "each requested object must be in exactly one of {}, found {reported}",
                parts.join(", ")
            ))
            .at("/body")
            .expected(format!("each in exactly one of {}", parts.join(", ")))
            .actual(reported)
        });
    }
}

/// Checks that responses of these types contain only requested objects.
pub(super) fn unrequested(exchange: &Exchange<'_>, context: &mut RuleContext<'_>, types: &[&str]) {
    let Some((request, parts)) = replied(exchange, types) else { return };
    context.covered();
    let found = parts.iter().find_map(|part| {
        let (key, _) =
            body::members(exchange.body, part).iter().find(|(key, _)| !request.contains(key.as_ref()))?;
        Some((*part, key))
    });
    if let Some((part, key)) = found {
        exchange.violates(context, || {
            Detail::new(format!("{} was not requested", body::quoted(key))).at(pointer(&["body", part, key]))
        });
    }
}

/// The requested objects, and the parts of the response that name objects.
pub(super) fn replied<'u>(
    exchange: &'u Exchange<'_>,
    types: &[&str],
) -> Option<(&'u BTreeSet<String>, &'static [&'static str])> {
    let name = exchange.type_name.filter(|name| exchange.response(name).is_some() && types.contains(name))?;
    let request = exchange.same_type_request()?.objects.as_ref()?;
    Some((request, parts(name)?.reply_fields))
}

/// The undefined field of a response that holds an object.
fn undefined_part<'u>(exchange: &'u Exchange<'_>, object: &str) -> Option<&'u str> {
    let misplaced = |deviation: &&Deviation| deviation.fault == Some(Fault::Misplaced);
    let mut parts = exchange.deviations.iter().flatten().filter(misplaced);
    parts.find_map(|deviation| {
        let part = deviation.mismatch.path.strip_prefix("/body/")?;
        named(exchange, part).any(|other| other == object).then_some(part)
    })
}

/// The objects named in one part of a response: the keys of a map, or the strings of a list.
pub(super) fn named<'t>(exchange: &Exchange<'t>, part: &str) -> impl Iterator<Item = &'t str> {
    let (members, values) = match exchange.field(part) {
        Some(Tree::Object(members)) => (&members[..], &[][..]),
        Some(Tree::List(values)) => (&[][..], &values[..]),
        _ => (&[][..], &[][..]),
    };
    members.iter().map(|(key, _)| key.as_ref()).chain(values.iter().filter_map(Tree::as_str))
}

/// The `ids` of a message, if they are a list of strings and the list is not too long.
pub(super) fn listed(exchange: &Exchange<'_>) -> Option<BTreeSet<String>> {
    let Some(Tree::List(values)) = exchange.field("ids").filter(|_| exchange.role != Role::Unanswered) else {
        return None;
    };
    let mut room = MAX_LISTED;
    let id = |value: &Tree<'_>| {
        let id = value.as_str().filter(|id| id.len() <= MAX_ID)?;
        room = room.checked_sub(id.len() + OVERHEAD)?;
        Some(id.to_owned())
    };
    values.iter().map(id).collect()
}

/// A list of ids, with its time if known.
pub(super) struct TimedList {
    ids: BTreeSet<String>,
    time: Option<f64>,
}

impl TimedList {
    pub(super) fn new(ids: BTreeSet<String>, exchange: &Exchange<'_>) -> Self {
        Self { ids, time: exchange.time }
    }

    /// True if a later response has the same ids, and this list is still recent: objects rarely appear and disappear
    /// again in the meantime.
    pub(super) fn is_confirmed_by(&self, ids: &BTreeSet<String>, exchange: &Exchange<'_>) -> bool {
        let is_recent = |(before, now): (f64, f64)| now - before <= MAX_LIST_AGE;
        self.ids == *ids && self.time.zip(exchange.time).is_some_and(is_recent)
    }
}

/// True if this is a response from the server and its `refs` can be checked, because no earlier records are missing.
pub(super) fn refers(exchange: &Exchange<'_>) -> bool {
    let is_response = exchange.role == Role::Response && exchange.is_from_server();
    is_response && exchange.record.connection.is_ordered && exchange.reference != Reference::Unclear
}

/// True if responses of a type may have receipts.
pub(super) fn may_have_receipts(name: &str) -> bool {
    name == "LOG-DATA" || OPERATIONS.contains(&name)
}
