//! That every question has its answer, whatever it looks like on the way.

use serde_json::Value;

use super::{Bench, Check, CheckOutcome};
use crate::testee::case::{Case, Input};
use crate::testee::wire::to_base64;

/// How many questions are asked where there should be several.
const NUM_CASES: usize = 16;

/// How large a long question is, in bytes: images of a firmware's parameters or of a mission come near to it, and no
/// buffer of a usual size holds it.
const LONG_REQUEST_LENGTH: usize = 1 << 20;

/// Integers that some type of a usual size doesn't hold, and the outermost that every reader of JSON keeps.
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
    statement: "every answer carries the id of a question",
    help: "copy \"id\" from the question into its answer as it is",
    attempt: answers_have_ids,
};

pub(super) const ONE_ANSWER_EACH: Check = Check {
    id: "one-answer-each",
    statement: "every question has exactly one answer, in any order",
    help: "write one line for every question, flush it, and nothing more about that question later",
    attempt: one_answer_each,
};

pub(super) const IDS_OF_ANY_SIZE: Check = Check {
    id: "ids-of-any-size",
    statement: "ids may be any integers within ±2^53",
    help: "keep ids as signed 64-bit integers or as 64-bit floats, or as the JSON that they came as",
    attempt: ids_of_any_size,
};

pub(super) const QUESTIONS_IN_ONE_WRITE: Check = Check {
    id: "questions-in-one-write",
    statement: "several questions that come at once are all answered",
    help: "read lines, not what one read of the system gives: that may hold many lines",
    attempt: questions_in_one_write,
};

pub(super) const QUESTION_IN_MANY_WRITES: Check = Check {
    id: "question-in-many-writes",
    statement: "a question that comes in several parts is answered",
    help: "read lines, not what one read of the system gives: that may hold a part of a line",
    attempt: question_in_many_writes,
};

pub(super) const LONG_QUESTION: Check = Check {
    id: "long-question",
    statement: "a question of 1 MiB is answered",
    help: "let the buffer for a line grow, up to 16 MiB; the answer may well be \"rejected\"",
    attempt: long_question,
};

pub(super) const ONLY_ANSWERS: Check = Check {
    id: "only-answers",
    statement: "nothing but answers goes to standard output",
    help: "write logs and messages to standard error; that is kept, and shown where the testee breaks",
    attempt: only_answers,
};

fn answers_have_ids(bench: &mut Bench<'_>) -> CheckOutcome {
    bench.attempt(|bench, session| {
        for case in several(bench)? {
            session.send_case(case);
        }
        let received = session.receive();
        // An answer may come late. How it ends is for another check.
        let _ = session.part();
        match session.received().foreign {
            Some(id) => Err(format!("an answer to id {id}, which no question has")),
            // One that lacks its id is seen as no answer, so none may be missing.
            None => received,
        }
    })
}

fn one_answer_each(bench: &mut Bench<'_>) -> CheckOutcome {
    bench.attempt(|bench, session| {
        for case in several(bench)? {
            session.send_case(case);
        }
        session.receive()?;
        // A second answer may come late. How it ends is for another check.
        let _ = session.part();
        match session.received().repeated {
            Some(id) => Err(format!("more than one answer to id {id}")),
            None => Ok(()),
        }
    })
}

fn ids_of_any_size(bench: &mut Bench<'_>) -> CheckOutcome {
    bench.attempt(|bench, session| {
        let case = bench.plain_case()?;
        for id in IDS {
            let mut question = case.request(0);
            question["id"] = id.into();
            session.send(id, &question);
            session.receive().map_err(|wrong| match session.received().foreign {
                Some(other) => format!("a question with id {id} is answered as {other}"),
                None => wrong,
            })?;
        }
        Ok(())
    })
}

fn questions_in_one_write(bench: &mut Bench<'_>) -> CheckOutcome {
    bench.attempt(|bench, session| {
        let mut lines = String::new();
        for case in several(bench)? {
            let (id, question) = session.question(case);
            session.expect(id);
            lines.push_str(&question.to_string());
            lines.push('\n');
        }
        session.send_bytes(lines.into_bytes());
        session.receive()
    })
}

fn question_in_many_writes(bench: &mut Bench<'_>) -> CheckOutcome {
    bench.attempt(|bench, session| {
        let case = bench.plain_case()?;
        let (first, question) = session.question(case);
        let (second, other) = session.question(case);
        session.expect(first);
        session.expect(second);
        // The last part of one and the first of the next come together, and the end of a line alone.
        let text = format!("{question}\n{other}\n");
        let (text, end) = text.as_bytes().split_at(text.len() - 1);
        session.send_parts(text.chunks(text.len().div_ceil(7)).chain([end]));
        session.receive()
    })
}

fn long_question(bench: &mut Bench<'_>) -> CheckOutcome {
    let Some(case) = bench.known_case(|case| case.input != Input::Nothing).cloned() else {
        return CheckOutcome::NotApplicable(
            "none of its ops on types of the definitions has an input".to_owned(),
        );
    };
    bench.attempt(|bench, session| {
        let (id, mut question) = session.question(&case);
        let (member, long): (&str, Value) = match case.input {
            // Three bytes become four letters.
            Input::Bytes(_) => ("bytes", to_base64(&vec![0; LONG_REQUEST_LENGTH / 4 * 3]).into()),
            Input::Value(_) | Input::Nothing => ("value", "x".repeat(LONG_REQUEST_LENGTH).into()),
        };
        question[member] = long;
        session.send(id, &question);
        session.receive()?;
        session.survive(bench.plain_case()?)
    })
}

fn only_answers(bench: &mut Bench<'_>) -> CheckOutcome {
    bench.strays.summary().map_or(CheckOutcome::Good, CheckOutcome::Bad)
}

/// Cases to ask at once: such as the testee knows, where there are any, and again from the first where they are few.
fn several<'b>(bench: &'b Bench<'_>) -> Result<impl Iterator<Item = &'b Case>, String> {
    let plain = bench.plain_case()?;
    let mut known: Vec<&Case> = bench.known_cases().take(NUM_CASES).collect();
    if known.is_empty() {
        known.push(plain);
    }
    Ok(known.into_iter().cycle().take(NUM_CASES))
}
