//! `FW-ENV-23`.

use std::collections::HashSet;

use super::{
    Bug, Check, Detail, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Session, Status, Tree,
    body, source,
};
use crate::json::pointer;

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-23",
        level: Level::Info,
        status: Status::Advisory,
        statement: "A message is strict JSON: no `NaN` or `Infinity`, and no key twice in an object.",
        source: source::DERIVED,
        applies_to: "messages of the server",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("Notifications have a key twice.", |out| {
        if out.is_notification() {
            out.write = |message| {
                let text = message.to_string();
                text.replacen('{', "{\"$fw.version\":\"1.0\",", 1)
            };
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "`NaN`",
            make: || {
                let session = Session::new();
                let text = String::from_utf8(session.to_bytes()).ok()?;
                Some(text.replacen("\"name\":\"Hill\"", "\"name\":\"Hill\",\"gusts\":NaN", 1).into_bytes())
            },
            also: &[],
        },
        Mutant {
            name: "a key twice",
            make: || {
                let session = Session::new();
                let text = String::from_utf8(session.to_bytes()).ok()?;
                Some(
                    text.replacen("\"name\":\"Hill\"", "\"name\":\"Hill\",\"name\":\"Hill\"", 1).into_bytes(),
                )
            },
            also: &[],
        },
    ],
};

/// How many keys are few.
const MAX_SCANNED_KEYS: usize = 16;

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    context.covered();
    if let Some((path, what)) = loose(message.value) {
        message.violates(context, || Detail::new(what).at(path));
    }
}

/// The first place in a value that JSON doesn't have, or doesn't say the meaning of.
fn loose(value: &Tree<'_>) -> Option<(String, String)> {
    let below = |key: &str, (path, what): (String, String)| (pointer(&[key]) + &path, what);
    match value {
        Tree::Token(word) => Some((String::new(), format!("{word} is no JSON"))),
        Tree::List(values) => {
            values.iter().enumerate().find_map(|(at, value)| Some(below(&at.to_string(), loose(value)?)))
        }
        Tree::Object(members) => {
            let mut seen = HashSet::new();
            members.iter().enumerate().find_map(|(at, (key, value))| {
                // A few keys are sooner compared with each other than put into a set.
                let is_repeated = if members.len() <= MAX_SCANNED_KEYS {
                    members[..at].iter().any(|(other, _)| other == key)
                } else {
                    !seen.insert(key.as_ref())
                };
                if is_repeated {
                    return Some((
                        String::new(),
                        format!("the key {} stands there twice", body::quoted(key)),
                    ));
                }
                Some(below(key, loose(value)?))
            })
        }
        _ => None,
    }
}
