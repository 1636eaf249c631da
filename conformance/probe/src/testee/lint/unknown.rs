//! Checks the responses to requests that a testee doesn't support or can't understand.

use serde_json::Value;

use super::session::Session;
use super::{Bench, Check, CheckOutcome};
use crate::testee::case::Case;
use crate::testee::protocol::Response;

pub(super) const UNKNOWN_OP: Check = Check {
    id: "unknown-op",
    statement: "an unknown op gets `unsupported` or `error`",
    help: "respond with {\"id\":…,\"unsupported\":true} to ops that aren't in the hello; later versions may add ops",
    attempt: unknown_op,
};

pub(super) const UNKNOWN_TYPE: Check = Check {
    id: "unknown-type",
    statement: "an unknown type gets `unsupported` or `error`",
    help: "respond with {\"id\":…,\"unsupported\":true} to types that aren't in the hello",
    attempt: unknown_type,
};

pub(super) const UNKNOWN_FORMAT: Check = Check {
    id: "unknown-format",
    statement: "an unknown format gets `unsupported` or `error`",
    help: "compare \"format\" with every known name; don't fall back to a known format for unknown names",
    attempt: unknown_format,
};

pub(super) const MISSING_MEMBER: Check = Check {
    id: "missing-member",
    statement: "a request without a required member gets `unsupported` or `error`",
    help: "respond with {\"id\":…,\"error\":\"no bytes\"}; \"rejected\" is for invalid input, not for invalid requests",
    attempt: missing_member,
};

fn unknown_op(bench: &mut Bench<'_>) -> CheckOutcome {
    bench.run(|bench, session| {
        let case = bench.plain_case()?;
        refuses(session, case, &["op"], Some(&"levitate".into()))
    })
}

fn unknown_type(bench: &mut Bench<'_>) -> CheckOutcome {
    bench.run(|bench, session| {
        let case = bench.plain_case()?;
        let other = case.type_name.clone() + "ThatNobodyKnows";
        refuses(session, case, &["type"], Some(&other.into()))?;
        // A name without a package isn't a valid type name.
        refuses(session, case, &["type"], Some(&"levitate".into()))
    })
}

fn unknown_format(bench: &mut Bench<'_>) -> CheckOutcome {
    let Some(case) = bench.known_case(|case| case.format.is_some()).cloned() else {
        return CheckOutcome::NotApplicable(
            "no test case for the supported ops and types uses a format".to_owned(),
        );
    };
    bench.run(|_, session| refuses(session, &case, &["format"], Some(&"morse".into())))
}

fn missing_member(bench: &mut Bench<'_>) -> CheckOutcome {
    // One case for each op, because the ops have different members.
    let mut cases: Vec<Case> = Vec::new();
    for case in bench.known_cases().filter(|case| case.rule.is_none()) {
        if cases.iter().all(|other| other.op != case.op) {
            cases.push(case.clone());
        }
    }
    if cases.is_empty() {
        return CheckOutcome::NotApplicable("the testee supports none of the defined types".to_owned());
    }
    bench.run(|_, session| {
        cases.iter().try_for_each(|case| {
            let members = ["op", "type", "format", "bytes", "value"];
            let request = case.request(0);
            let present: Vec<&str> =
                members.into_iter().filter(|member| request.get(*member).is_some()).collect();
            refuses(session, case, &present, None)
        })
    })
}

/// Sends the case once for each member. The member is replaced by `value`, or removed if `value` is `None`. Each
/// response must be `unsupported` or `error`. Before and after that, the unchanged case must get a response.
fn refuses(
    session: &mut Session<'_>,
    case: &Case,
    members: &[&str],
    value: Option<&Value>,
) -> Result<(), String> {
    // If a testee answers no requests at all, this request isn't the cause.
    session.check_alive(case)?;
    for member in members {
        let (id, mut request) = session.request(case);
        if let (None, Some(members)) = (value, request.as_object_mut()) {
            members.shift_remove(*member);
        } else if let Some(value) = value {
            request[*member] = value.clone();
        }
        session.send(id, &request);
        let what = match value {
            Some(value) => format!("{} with \"{member}\":{value}", case.action()),
            None => format!("{} without \"{member}\"", case.action()),
        };
        session.receive().map_err(|wrong| format!("{what}: {wrong}"))?;
        let wrong = match session.answer(id) {
            Some(Response::Ok(_)) => "ok",
            Some(Response::Rejected(_)) => "rejected",
            Some(Response::Unsupported | Response::Error(_)) | None => continue,
        };
        return Err(format!("the response to {what} is \"{wrong}\", expected \"unsupported\" or \"error\""));
    }
    session.check_alive(case)
}
