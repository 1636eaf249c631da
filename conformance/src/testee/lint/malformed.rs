//! That a damaged line is survived.

use super::{Bench, Check, CheckOutcome};

pub(super) const EMPTY_LINE: Check = Check {
    id: "empty-line",
    statement: "an empty line is survived",
    help: "pass over lines without anything but white space",
    attempt: empty_line,
};

pub(super) const NOT_JSON: Check = Check {
    id: "not-json",
    statement: "a line that is no JSON, or no object, is survived",
    help: "catch what the reader of JSON raises, and read the next line; what has no id needs no answer",
    attempt: not_json,
};

pub(super) const NOT_UTF8: Check = Check {
    id: "not-utf8",
    statement: "a line that is no UTF-8 is survived",
    help: "read lines as bytes and decode them one by one, so that one which can't be decoded ends nothing",
    attempt: not_utf8,
};

fn empty_line(bench: &mut Bench<'_>) -> CheckOutcome {
    survives(bench, &[b"", b"  \t", b"\r"])
}

fn not_json(bench: &mut Bench<'_>) -> CheckOutcome {
    let lines: [&[u8]; 7] =
        [b"hello, world", b"{\"id\":1,\"op\":", b"{}", b"[]", b"7", b"null", b"\"hello\""];
    survives(bench, &lines)
}

fn not_utf8(bench: &mut Bench<'_>) -> CheckOutcome {
    // Some readers replace the byte, and find a question: it may be answered.
    let manner = bench.attempt(|bench, session| {
        let case = bench.plain_case()?;
        let id = session.fresh_id();
        let line = format!("{{\"id\":{id},\"op\":\"decode\",\"type\":\"");
        session.send_malformed(Some(id), &[line.as_bytes(), b"\xff\"}"].concat());
        session.survive(case)
    });
    if manner == CheckOutcome::Good { survives(bench, &[b"\xff\xfe{\x00}\x00", b"\xc3"]) } else { manner }
}

/// Sends lines that are no questions, each followed by a question.
fn survives(bench: &mut Bench<'_>, lines: &[&[u8]]) -> CheckOutcome {
    bench.attempt(|bench, session| {
        let case = bench.plain_case()?;
        lines.iter().try_for_each(|line| {
            session.send_malformed(None, line);
            session.survive(case).map_err(|wrong| format!("after `{}`: {wrong}", line.escape_ascii()))
        })
    })
}
