//! Checks that a testee reads and writes tagged numbers, which JSON parsers preserve.

use serde_json::Value;
use uavspec_model::json::shortened;

use super::{Bench, Check, CheckOutcome};
use crate::testee::case::{Case, ExpectedResponse, Input};
use crate::testee::options::excerpt;
use crate::testee::protocol::{Op, Response};
use crate::testee::wire::{has_tag, to_wire};

/// The tags of integers.
const INTEGERS: &[&str] = &["$u64", "$i64"];

/// The tag of floats.
const FLOATS: &[&str] = &["$f"];

/// The maximum number of cases per check.
const NUM_CASES: usize = 16;

pub(super) const TAGGED_INTEGERS: Check = Check {
    id: "tagged-integers",
    statement: "integers outside ±2^53 are read and written as {\"$u64\":\"…\"} or {\"$i64\":\"…\"}",
    help: "read and write large integers as tagged strings; many JSON parsers round large integers",
    attempt: |bench| tagged(bench, INTEGERS),
};

pub(super) const TAGGED_FLOATS: Check = Check {
    id: "tagged-floats",
    statement: "NaN and infinities are read and written as {\"$f\":\"NaN\"}, {\"$f\":\"inf\"} and {\"$f\":\"-inf\"}",
    help: "read and write {\"$f\":\"NaN\"} for NaN; JSON has no NaN",
    attempt: |bench| tagged(bench, FLOATS),
};

fn tagged(bench: &mut Bench<'_>, tags: &[&str]) -> CheckOutcome {
    let is_right = |case: &&Case| case.rule.is_none() && !case.expected.rejection;
    let wanted = |case: &Case| match (&case.op, &case.expected.ok) {
        (Op::Decode, ExpectedResponse::Message(value)) => {
            Some(to_wire(value, case.message_type(bench.types))).filter(|wire| has(wire, tags))
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
        return CheckOutcome::NotApplicable(
            "no test case of a supported type contains these numbers".to_owned(),
        );
    }
    bench.run(|_, session| {
        for (case, wanted) in &decoded {
            let id = session.send_case(case);
            session.receive()?;
            // A failure to decode is reported by `uavspec test`.
            if let Some(Response::Ok(actual)) = session.answer(id)
                && let Some(location) = untagged(wanted, actual, tags, "")
            {
                return Err(format!("{}: {location}", case.name()));
            }
        }
        for case in &sent {
            let id = session.send_case(case);
            session.receive()?;
            if let Some(Response::Rejected(reason) | Response::Error(reason)) = session.answer(id) {
                return Err(format!("{}: expected \"ok\", got: {}", case.name(), excerpt(reason.as_bytes())));
            }
        }
        Ok(())
    })
}

/// True if a value contains one of the tags at any depth.
fn has(value: &Value, tags: &[&str]) -> bool {
    has_tag(value, tags)
        || match value {
            Value::Array(items) => items.iter().any(|item| has(item, tags)),
            Value::Object(members) => members.values().any(|member| has(member, tags)),
            Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => false,
        }
}

/// Describes the first value that lacks an expected tag. Ignores missing values, which `uavspec test` reports.
fn untagged(wanted: &Value, actual: &Value, tags: &[&str], path: &str) -> Option<String> {
    if has_tag(wanted, tags) {
        let found = || format!("expected {wanted} at {path}, found {}", shortened(&actual.to_string()));
        return (!has_tag(actual, tags)).then(found);
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
