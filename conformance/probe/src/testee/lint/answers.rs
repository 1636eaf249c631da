//! Checks that every request gets one response, regardless of its id and length, and even if it arrives in parts.

use serde_json::Value;

use super::{Bench, Check, CheckOutcome};
use crate::testee::case::{Case, Input};
use crate::testee::wire::to_base64;

/// The number of requests in checks that send more than one.
const NUM_CASES: usize = 16;

/// The length of a long request in bytes. A mission or a list of all firmware parameters has a similar length. The
/// request is longer than typical buffers.
const LONG_REQUEST_LENGTH: usize = 1 << 20;

/// The limits of common integer types, and the smallest and largest integers that every JSON parser preserves.
const IDS: [i64; 15] = [
    0,
    1,
    -1,
    255,
    256,
    -129,
    65_536,
    -32_769,
    1 << 31,
    -(1 << 31) - 1,
    1 << 32,
    (1 << 53) - 1,
    1 << 53,
    -(1 << 53) + 1,
    -(1 << 53),
];

pub(super) const ANSWERS_HAVE_IDS: Check = Check {
    id: "answers-have-ids",
    statement: "every response has the id of a request",
    help: "copy \"id\" from the request to the response unchanged",
    attempt: answers_have_ids,
};

pub(super) const ONE_ANSWER_EACH: Check = Check {
    id: "one-answer-each",
    statement: "every request gets exactly one response, in any order",
    help: "write one line for each request, and flush it; don't write a second response later",
    attempt: one_answer_each,
};

pub(super) const IDS_OF_ANY_SIZE: Check = Check {
    id: "ids-of-any-size",
    statement: "an id may be any integer within ±2^53",
    help: "store ids as signed 64-bit integers, 64-bit floats or unparsed JSON",
    attempt: ids_of_any_size,
};

pub(super) const QUESTIONS_IN_ONE_WRITE: Check = Check {
    id: "questions-in-one-write",
    statement: "if one write contains several requests, each gets a response",
    help: "read input line by line; one system read may return many lines",
    attempt: questions_in_one_write,
};

pub(super) const QUESTION_IN_MANY_WRITES: Check = Check {
    id: "question-in-many-writes",
    statement: "a request that arrives in several parts gets a response",
    help: "read input line by line; one system read may return part of a line",
    attempt: question_in_many_writes,
};

pub(super) const LONG_QUESTION: Check = Check {
    id: "long-question",
    statement: "a 1 MiB request gets a response",
    help: "accept lines of up to 16 MiB; the response may be \"rejected\"",
    attempt: long_question,
};

pub(super) const ONLY_ANSWERS: Check = Check {
    id: "only-answers",
    statement: "standard output contains responses only",
    help: "write logs to standard error; uavspec shows the last lines if the testee fails",
    attempt: only_answers,
};

fn answers_have_ids(bench: &mut Bench<'_>) -> CheckOutcome {
    bench.run(|bench, session| {
        for case in several(bench)? {
            session.send_case(case);
        }
        let received = session.receive();
        // A response may be late. Another check covers how the testee exits.
        let _ = session.finish();
        match session.received.foreign {
            Some(id) => Err(format!("unexpected response with id {id}")),
            // A response without an id doesn't answer its request, so it also causes a failure here.
            None => received,
        }
    })
}

fn one_answer_each(bench: &mut Bench<'_>) -> CheckOutcome {
    bench.run(|bench, session| {
        for case in several(bench)? {
            session.send_case(case);
        }
        session.receive()?;
        // A second response may be late. Another check covers how the testee exits.
        let _ = session.finish();
        match session.received.repeated {
            Some(id) => Err(format!("more than one response with id {id}")),
            None => Ok(()),
        }
    })
}

fn ids_of_any_size(bench: &mut Bench<'_>) -> CheckOutcome {
    bench.run(|bench, session| {
        let case = bench.plain_case()?;
        for id in IDS {
            let mut request = case.request(0);
            request["id"] = id.into();
            session.send(id, &request);
            session.receive().map_err(|wrong| match session.received.foreign {
                Some(other) => format!("the response to request {id} has id {other}"),
                None => wrong,
            })?;
        }
        Ok(())
    })
}

fn questions_in_one_write(bench: &mut Bench<'_>) -> CheckOutcome {
    bench.run(|bench, session| {
        let mut lines = String::new();
        for case in several(bench)? {
            let (id, request) = session.request(case);
            session.expect(id);
            lines.push_str(&request.to_string());
            lines.push('\n');
        }
        session.send_parts([lines.as_bytes()]);
        session.receive()
    })
}

fn question_in_many_writes(bench: &mut Bench<'_>) -> CheckOutcome {
    bench.run(|bench, session| {
        let case = bench.plain_case()?;
        let (first, request) = session.request(case);
        let (second, other) = session.request(case);
        session.expect(first);
        session.expect(second);
        // The end of the first request and the start of the second are sent together. The last line end is sent alone.
        let text = format!("{request}\n{other}\n");
        let (text, end) = text.as_bytes().split_at(text.len() - 1);
        session.send_parts(text.chunks(text.len().div_ceil(7)).chain([end]));
        session.receive()
    })
}

fn long_question(bench: &mut Bench<'_>) -> CheckOutcome {
    let Some(case) = bench.known_case(|case| case.input != Input::Nothing).cloned() else {
        return CheckOutcome::NotApplicable(
            "none of the test cases for the supported ops and types has an input".to_owned(),
        );
    };
    bench.run(|bench, session| {
        let (id, mut request) = session.request(&case);
        let (member, long): (&str, Value) = match case.input {
            // Base64 encodes three bytes as four characters.
            Input::Bytes(_) | Input::Event { .. } => {
                ("bytes", to_base64(&vec![0; LONG_REQUEST_LENGTH / 4 * 3]).into())
            }
            Input::Value(_) | Input::Nothing => ("value", "x".repeat(LONG_REQUEST_LENGTH).into()),
        };
        request[member] = long;
        session.send(id, &request);
        session.receive()?;
        session.check_alive(bench.plain_case()?)
    })
}

fn only_answers(bench: &mut Bench<'_>) -> CheckOutcome {
    bench.strays.summary().map_or(CheckOutcome::Pass, CheckOutcome::Fail)
}

/// Returns `NUM_CASES` cases: the supported cases, or another case if none is supported. Cases are repeated if there
/// are too few.
fn several<'b>(bench: &'b Bench<'_>) -> Result<impl Iterator<Item = &'b Case>, String> {
    let plain = bench.plain_case()?;
    let mut known: Vec<&Case> = bench.known_cases().take(NUM_CASES).collect();
    if known.is_empty() {
        known.push(plain);
    }
    Ok(known.into_iter().cycle().take(NUM_CASES))
}
