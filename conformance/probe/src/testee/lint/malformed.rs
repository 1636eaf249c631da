//! Checks that a testee continues after a malformed line.

use super::{Bench, Check, CheckOutcome};

pub(super) const EMPTY_LINE: Check = Check {
    id: "empty-line",
    statement: "the testee continues after an empty line",
    help: "skip lines that contain only white space",
    attempt: empty_line,
};

pub(super) const NOT_JSON: Check = Check {
    id: "not-json",
    statement: "the testee continues after a line that is not a JSON object",
    help: "catch JSON parser errors, and continue with the next line; lines without an id need no response",
    attempt: not_json,
};

pub(super) const NOT_UTF8: Check = Check {
    id: "not-utf8",
    statement: "the testee continues after invalid UTF-8",
    help: "read lines as bytes, decode each line separately, and skip lines that can't be decoded",
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
    // Some testees replace the invalid byte and see a valid request, so they may respond.
    let outcome = bench.run(|bench, session| {
        let case = bench.plain_case()?;
        let id = session.fresh_id();
        let line = format!("{{\"id\":{id},\"op\":\"decode\",\"type\":\"");
        session.send_malformed(Some(id), &[line.as_bytes(), b"\xff\"}"].concat());
        session.check_alive(case)
    });
    if outcome == CheckOutcome::Pass { survives(bench, &[b"\xff\xfe{\x00}\x00", b"\xc3"]) } else { outcome }
}

/// Sends malformed lines, each followed by a request that must get a response.
fn survives(bench: &mut Bench<'_>, lines: &[&[u8]]) -> CheckOutcome {
    bench.run(|bench, session| {
        let case = bench.plain_case()?;
        lines.iter().try_for_each(|line| {
            session.send_malformed(None, line);
            session.check_alive(case).map_err(|wrong| format!("after `{}`: {wrong}", line.escape_ascii()))
        })
    })
}
