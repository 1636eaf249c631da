//! That what it doesn't know, or can't understand, is answered as that.

use serde_json::Value;

use super::session::Session;
use super::{Bench, Check, CheckOutcome};
use crate::testee::case::Case;
use crate::testee::protocol::Answer;

pub(super) const UNKNOWN_OP: Check = Check {
    id: "unknown-op",
    statement: "an op that it doesn't know is `unsupported`, or an `error`",
    help: "answer {\"id\":…,\"unsupported\":true} to ops that aren't in the hello: later versions may have more",
    attempt: unknown_op,
};

pub(super) const UNKNOWN_TYPE: Check = Check {
    id: "unknown-type",
    statement: "a type that it doesn't know is `unsupported`, or an `error`",
    help: "answer {\"id\":…,\"unsupported\":true} to types that aren't in the hello",
    attempt: unknown_type,
};

pub(super) const UNKNOWN_FORMAT: Check = Check {
    id: "unknown-format",
    statement: "a format that it doesn't know is `unsupported`, or an `error`",
    help: "compare \"format\" with the names that you know, and take none for the one that is left",
    attempt: unknown_format,
};

pub(super) const MISSING_MEMBER: Check = Check {
    id: "missing-member",
    statement: "a question that lacks a member is `unsupported`, or an `error`",
    help: "answer {\"id\":…,\"error\":\"no bytes\"}; \"rejected\" is for what a question asks about, not for itself",
    attempt: missing_member,
};

fn unknown_op(bench: &mut Bench<'_>) -> CheckOutcome {
    bench.attempt(|bench, session| {
        let case = bench.plain_case()?;
        refuses(session, case, &["op"], Some(&"levitate".into()))
    })
}

fn unknown_type(bench: &mut Bench<'_>) -> CheckOutcome {
    bench.attempt(|bench, session| {
        let case = bench.plain_case()?;
        let other = case.type_name.clone() + "ThatNobodyKnows";
        refuses(session, case, &["type"], Some(&other.into()))?;
        // Without a package, it is no name of a type.
        refuses(session, case, &["type"], Some(&"levitate".into()))
    })
}

fn unknown_format(bench: &mut Bench<'_>) -> CheckOutcome {
    let Some(case) = bench.known_case(|case| case.format.is_some()).cloned() else {
        return CheckOutcome::NotApplicable(
            "none of its ops on types of the definitions has a format".to_owned(),
        );
    };
    bench.attempt(|_, session| refuses(session, &case, &["format"], Some(&"morse".into())))
}

fn missing_member(bench: &mut Bench<'_>) -> CheckOutcome {
    // One case of each op, since each has members of its own.
    let mut cases: Vec<Case> = Vec::new();
    for case in bench.known_cases().filter(|case| case.rule.is_none()) {
        if cases.iter().all(|other| other.op != case.op) {
            cases.push(case.clone());
        }
    }
    if cases.is_empty() {
        return CheckOutcome::NotApplicable("it knows no type of the definitions".to_owned());
    }
    bench.attempt(|_, session| {
        cases.iter().try_for_each(|case| {
            let members = ["op", "type", "format", "bytes", "value"];
            let request = case.request(0);
            let present: Vec<&str> =
                members.into_iter().filter(|member| request.get(*member).is_some()).collect();
            refuses(session, case, &present, None)
        })
    })
}

/// Asks the case once for each of the members, with another value there or without the member. Every answer has to say
/// that this can't be answered, and the case itself must be answered afterwards.
fn refuses(
    session: &mut Session<'_>,
    case: &Case,
    members: &[&str],
    value: Option<&Value>,
) -> Result<(), String> {
    for member in members {
        let (id, mut question) = session.question(case);
        if let (None, Some(members)) = (value, question.as_object_mut()) {
            members.shift_remove(*member);
        } else if let Some(value) = value {
            question[*member] = value.clone();
        }
        session.send(id, &question);
        let what = match value {
            Some(value) => format!("{} with \"{member}\":{value}", case.action()),
            None => format!("{} without \"{member}\"", case.action()),
        };
        session.receive().map_err(|wrong| format!("{what}: {wrong}"))?;
        let wrong = match session.answer(id) {
            Some(Answer::Ok(_)) => "ok",
            Some(Answer::Rejected(_)) => "rejected",
            Some(Answer::Unsupported | Answer::Error(_)) | None => continue,
        };
        return Err(format!("{what} is answered with \"{wrong}\""));
    }
    session.survive(case)
}
