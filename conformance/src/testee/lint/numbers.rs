//! That numbers travel so that no reader of JSON loses them.

use serde_json::Value;

use super::{Bench, Check, CheckOutcome};
use crate::testee::case::{Case, ExpectedAnswer, Input};
use crate::testee::protocol::{Answer, Op};
use crate::testee::wire::{has_tag, to_wire};

/// The tags of integers.
const INTEGERS: &[&str] = &["$u64", "$i64"];

/// The tag of floats.
const FLOATS: &[&str] = &["$f"];

/// How many cases are asked for each check.
const NUM_CASES: usize = 16;

pub(super) const TAGGED_INTEGERS: Check = Check {
    id: "tagged-integers",
    statement: "integers beyond ±2^53 are understood and come back as {\"$u64\":\"…\"} or {\"$i64\":\"…\"}",
    help: "write such integers as strings under the tag, and read them so: JSON itself lets readers round them",
    attempt: |bench| tagged(bench, INTEGERS),
};

pub(super) const TAGGED_FLOATS: Check = Check {
    id: "tagged-floats",
    statement: "NaN and the infinities are understood and come back as {\"$f\":\"NaN\"}, \"inf\" or \"-inf\"",
    help: "write {\"$f\":\"NaN\"} where the number is none, and read it so: JSON has no word for it",
    attempt: |bench| tagged(bench, FLOATS),
};

fn tagged(bench: &mut Bench<'_>, tags: &[&str]) -> CheckOutcome {
    let is_right = |case: &&Case| case.rule.is_none() && !case.expected.rejection;
    let wanted = |case: &Case| match (&case.op, &case.expected.ok) {
        (Op::Decode, ExpectedAnswer::Message(value)) => {
            let message = case.type_name.split_once('/');
            let message = message.and_then(|(package, name)| bench.types.find(package, name));
            Some(to_wire(value, message)).filter(|wire| has(wire, tags))
        }
        _ => None,
    };
    let sends = |case: &&Case| matches!(&case.input, Input::Value(value) if has(value, tags));
    let decoded: Vec<(Case, Value)> = bench
        .known_cases()
        .filter(is_right)
        .filter_map(|case| Some((case.clone(), wanted(case)?)))
        .take(NUM_CASES)
        .collect();
    let sent: Vec<Case> =
        bench.known_cases().filter(is_right).filter(sends).take(NUM_CASES).cloned().collect();
    if decoded.is_empty() && sent.is_empty() {
        return CheckOutcome::NotApplicable("none of the types that it knows holds such numbers".to_owned());
    }
    bench.attempt(|_, session| {
        for (case, wanted) in &decoded {
            let id = session.send_case(case);
            session.receive()?;
            // Whether it decodes at all is for `uavspec test`.
            if let Some(Answer::Ok(actual)) = session.answer(id)
                && let Some(location) = untagged(wanted, actual, tags, "")
            {
                return Err(format!("{} gives {location}", case.name()));
            }
        }
        for case in &sent {
            let id = session.send_case(case);
            session.receive()?;
            if let Some(Answer::Rejected(reason) | Answer::Error(reason)) = session.answer(id) {
                return Err(format!("{} is not understood: {reason}", case.name()));
            }
        }
        Ok(())
    })
}

/// Whether a value has one of the tags anywhere.
fn has(value: &Value, tags: &[&str]) -> bool {
    has_tag(value, tags)
        || match value {
            Value::Array(items) => items.iter().any(|item| has(item, tags)),
            Value::Object(members) => members.values().any(|member| has(member, tags)),
            Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => false,
        }
}

/// The first place where a tag should be and is none, with what is there; what is absent is for `uavspec test`.
fn untagged(wanted: &Value, actual: &Value, tags: &[&str], path: &str) -> Option<String> {
    if has_tag(wanted, tags) {
        return (!has_tag(actual, tags)).then(|| format!("{actual} at {path} instead of {wanted}"));
    }
    match wanted {
        Value::Array(items) => items.iter().enumerate().find_map(|(index, wanted)| {
            untagged(wanted, actual.get(index)?, tags, &format!("{path}/{index}"))
        }),
        Value::Object(members) => members
            .iter()
            .find_map(|(name, wanted)| untagged(wanted, actual.get(name)?, tags, &format!("{path}/{name}"))),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => None,
    }
}
