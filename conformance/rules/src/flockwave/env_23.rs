//! `FW-ENV-23`.

use std::collections::HashSet;

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-23",
    name: "Strict JSON",
    level: Level::Info,
    status: Status::Advisory,
    statement: "A message is strict JSON: no `NaN` or `Infinity`, and no duplicate keys in an object.",
    source: source::DERIVED,
    applies_to: "messages from the server",
    why: "Standard JSON parsers reject `NaN`, so the whole message is lost. If a key is duplicated, \
          different parsers keep different values.",
    example: r#"{"$fw.version":"1.0","id":"s1","body":{"type":"DEV-INF","values":{"/uav-1/cpu/temp":NaN}}}"#,
    fix: "Configure the serializer to reject NaN and infinities. Send null or omit the field if there is \
          no value.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("Notifications have a duplicate key.", |out| {
    if out.is_notification() {
        out.write = |message| {
            let text = message.to_string();
            text.replacen('{', "{\"$fw.version\":\"1.0\",", 1)
        };
    }
}))
.mutants(&[
    Mutant::new("`NaN`", || {
        let session = Session::new();
        let text = String::from_utf8(session.to_bytes()).ok()?;
        Some(text.replacen("\"name\":\"Hill\"", "\"name\":\"Hill\",\"gusts\":NaN", 1).into_bytes())
    }),
    Mutant::new("a duplicate key", || {
        let session = Session::new();
        let text = String::from_utf8(session.to_bytes()).ok()?;
        Some(text.replacen("\"name\":\"Hill\"", "\"name\":\"Hill\",\"name\":\"Hill\"", 1).into_bytes())
    }),
]);

/// The maximum number of keys that are compared pairwise.
const MAX_SCANNED_KEYS: usize = 16;

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    context.covered();
    if let Some((path, what)) = non_strict(message.value) {
        message.violates(context, || Detail::new(what).at(path));
    }
}

/// The path and description of the first value that is not strict JSON.
fn non_strict(value: &Tree<'_>) -> Option<(String, String)> {
    let below = |key: &str, (path, what): (String, String)| (pointer(&[key]) + &path, what);
    match value {
        Tree::Token(word) => Some((String::new(), format!("{word} is not valid JSON"))),
        Tree::List(values) => values.iter().enumerate().find_map(|(at, value)| {
            let found = non_strict(value)?;
            Some(below(&at.to_string(), found))
        }),
        Tree::Object(members) => {
            let mut seen = HashSet::new();
            members.iter().enumerate().find_map(|(at, (key, value))| {
                // For a few keys, pairwise comparison is faster than a set.
                let is_repeated = if members.len() <= MAX_SCANNED_KEYS {
                    members[..at].iter().any(|(other, _)| other == key)
                } else {
                    !seen.insert(key.as_ref())
                };
                if is_repeated {
                    return Some((String::new(), format!("duplicate key {}", body::quoted(key))));
                }
                Some(below(key, non_strict(value)?))
            })
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use uavspec_model::json::Tree;

    use super::non_strict;

    #[test]
    fn finds_values_in_lists_and_objects() {
        for (text, expected) in [
            ("[1, [2, NaN]]", "/1/1 NaN is not valid JSON"),
            (r#"{"a": {"b": [{"c": 1, "c": 2}]}}"#, "/a/b/0 duplicate key `c`"),
            (r#"{"a": [1, {"c": 1}], "c": 2}"#, ""),
        ] {
            let tree = Tree::read(text).expect("JSON");
            let found = non_strict(&tree).map(|(path, what)| format!("{path} {what}"));
            assert_eq!(found.unwrap_or_default(), expected, "{text}");
        }
    }
}
