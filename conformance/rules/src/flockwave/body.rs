//! Checks of message contents.

use std::borrow::Cow;
use std::collections::HashSet;

use super::prelude::*;

/// The maximum length of a quoted text, in characters.
const MAX_QUOTED: usize = 64;

/// Reports a value that does not match its schema.
pub(super) fn mismatched(message: &Message<'_>, context: &mut RuleContext<'_>, found: Mismatch) {
    message.violates(context, || {
        let Mismatch { path, expected, actual } = found;
        Detail::differs(expected, actual).at(path)
    });
}

/// Checks that a field of the body matches a schema. An optional field may be absent.
pub(super) fn field(
    message: &Message<'_>,
    context: &mut RuleContext<'_>,
    name: &str,
    is_required: bool,
    schema: &ExpectedValue,
) {
    member(message, context, message.body, &["body"], (name, is_required), schema);
}

/// Checks that a member of the object at `keys` matches a schema. An optional member may be absent.
pub(super) fn member(
    message: &Message<'_>,
    context: &mut RuleContext<'_>,
    holder: Option<&Tree<'_>>,
    keys: &[&str],
    (name, is_required): (&str, bool),
    schema: &ExpectedValue,
) {
    let found = match holder.and_then(|holder| holder.get(name)) {
        None if is_required => Some(Mismatch::new(schema.to_string(), "nothing")),
        None => return,
        Some(value) => schema.mismatch(value),
    };
    context.covered();
    if let Some(found) = found {
        let path = pointer(keys) + &pointer(&[name]) + &found.path;
        mismatched(message, context, Mismatch { path, ..found });
    }
}

/// The states in a message of this type, by object id.
pub(super) fn states<'t>(message: &Message<'t>, type_name: &str) -> &'t [(Cow<'t, str>, Tree<'t>)] {
    members(message.body_of(type_name), "status")
}

/// Checks that the key of each state equals the `id` in that state.
pub(super) fn keyed(message: &Message<'_>, context: &mut RuleContext<'_>, type_name: &str) {
    for (key, state) in states(message, type_name) {
        context.covered();
        let id = state.get("id");
        // Other rules report a missing or invalid id.
        if let Some(id) = id.and_then(Tree::as_str).filter(|id| id != key) {
            message.violates(context, || {
                Detail::differs(quoted(key), quoted(id)).at(pointer(&["body", "status", key, "id"]))
            });
        }
    }
}

/// Checks that the strings in a list are unique.
pub(super) fn unique(message: &Message<'_>, context: &mut RuleContext<'_>, name: &str) {
    let Some(Tree::List(values)) = message.field(name) else { return };
    context.covered();
    let mut seen = HashSet::new();
    let repeated = values.iter().filter_map(Tree::as_str).find(|text| !seen.insert(*text));
    if let Some(text) = repeated {
        message.violates(context, || {
            Detail::new(format!("{} is listed twice", quoted(text))).at(pointer(&["body", name]))
        });
    }
}

/// Checks that a body of this type has a list of strings in `ids`.
pub(super) fn id_list(message: &Message<'_>, context: &mut RuleContext<'_>, type_name: &str) {
    if message.body_of(type_name).is_some() {
        field(message, context, "ids", true, &ExpectedValue::List(&ExpectedValue::Text));
    }
}

/// Checks that the `ids` in a body of this type are unique, and that each has the form of an object id. Other rules report
/// ids that are not strings.
pub(super) fn object_ids(message: &Message<'_>, context: &mut RuleContext<'_>, type_name: &str) {
    let Some(Tree::List(ids)) = message.body_of(type_name).and_then(|body| body.get("ids")) else { return };
    unique(message, context, "ids");
    let mut texts = ids.iter().filter(|id| id.as_str().is_some());
    if let Some(found) = texts.find_map(|id| ExpectedValue::ObjectId.mismatch(id)) {
        mismatched(message, context, Mismatch { path: "/body/ids".to_owned(), ..found });
    }
}

/// Checks each list of error codes. `FW-UST-ERRORS` reports values that are not integers. Findings of disputed cases have
/// a different subject, so that they form a separate group.
pub(super) fn codes<V: Into<Detail>>(
    message: &Message<'_>,
    context: &mut RuleContext<'_>,
    violation: impl Fn(&[i128]) -> Option<V>,
) {
    for (uav, state) in states(message, "UAV-INF") {
        let Some(Tree::List(values)) = state.get("errors") else { continue };
        let codes: Vec<i128> = values.iter().filter_map(Tree::as_integer).collect();
        if codes.is_empty() {
            continue;
        }
        context.covered();
        let Some(detail) = violation(&codes).map(V::into) else { continue };
        let is_disputed = detail.is_disputed;
        let complete = || {
            let reported: Vec<String> = codes.iter().take(16).map(ToString::to_string).collect();
            let path = pointer(&["body", "status", uav, "errors"]);
            detail.at(path).actual(format!("[{}]", reported.join(", ")))
        };
        if is_disputed {
            message.violates_in("errors", context, complete);
        } else {
            message.violates(context, complete);
        }
    }
}

/// Checks that the body has exactly one of these fields. Null counts as a value only in the field `may_be_null`, and
/// only if no other field has a value.
pub(super) fn exactly_one(
    message: &Message<'_>,
    context: &mut RuleContext<'_>,
    names: &[&str],
    may_be_null: &str,
) {
    context.covered();
    let mut found: Vec<&str> = names.iter().copied().filter(|name| is_present(message.field(name))).collect();
    if found.is_empty() && message.field(may_be_null) == Some(&Tree::Null) {
        found.push(may_be_null);
    }
    if found.len() != 1 {
        message.violates(context, || {
            let found = if found.is_empty() { "none".to_owned() } else { found.join(" and ") };
            Detail::differs(format!("exactly one of {}", names.join(", ")), found).at("/body")
        });
    }
}

/// True if a value is present and not null. The specification's guidelines for its authors allow null in optional
/// members.
pub(super) fn is_present(value: Option<&Tree<'_>>) -> bool {
    value.is_some_and(|value| *value != Tree::Null)
}

/// True if a text is one to three numbers separated by dots.
pub(super) fn is_version(text: &str) -> bool {
    let mut parts = text.split('.');
    let is_number = |part: &str| !part.is_empty() && part.bytes().all(|byte| byte.is_ascii_digit());
    parts.by_ref().take(3).all(is_number) && parts.next().is_none()
}

/// The text in backticks, shortened if it is long.
pub(super) fn quoted(text: &str) -> String {
    let short: String = text.chars().take(MAX_QUOTED).collect();
    let more = if short.len() < text.len() { "…" } else { "" };
    format!("`{short}{more}`")
}

/// The members of the object in this body field; empty if the field is not an object.
pub(super) fn members<'t>(body: Option<&'t Tree<'t>>, name: &str) -> &'t [(Cow<'t, str>, Tree<'t>)] {
    match body.and_then(|body| body.get(name)) {
        Some(Tree::Object(members)) => members,
        _ => &[],
    }
}

#[cfg(test)]
mod tests {
    use super::{MAX_QUOTED, quoted};

    #[test]
    fn long_texts_are_shortened() {
        assert_eq!(quoted("kite"), "`kite`");
        let longest = "ü".repeat(MAX_QUOTED);
        assert_eq!(quoted(&longest), format!("`{longest}`"));
        assert_eq!(quoted(&format!("{longest}ü")), format!("`{longest}…`"));
    }
}
