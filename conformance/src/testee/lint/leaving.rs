//! How it ends.

use super::{Bench, Check, CheckOutcome};

/// How many questions are on their way when the input closes.
const NUM_CASES: usize = 8;

pub(super) const ANSWERS_BEFORE_END: Check = Check {
    id: "answers-before-end",
    statement: "what was asked before its input closed is answered before it ends",
    help: "read all lines up to the end, then write what is still to be written, then end: files of questions need it",
    attempt: answers_before_end,
};

pub(super) const ENDS_BY_ITSELF: Check = Check {
    id: "ends-by-itself",
    statement: "it ends with status 0, in time, when its standard input closes; over TCP, it closes the connection",
    help: "leave the loop at the end of the input, stop threads and timers, and return 0",
    attempt: ends_by_itself,
};

fn answers_before_end(bench: &mut Bench<'_>) -> CheckOutcome {
    bench.attempt(|bench, session| {
        let case = bench.plain_case()?;
        for _ in 0..NUM_CASES {
            session.send_case(case);
        }
        // How it ends is for another check.
        let _ = session.part();
        if session.is_answered() { Ok(()) } else { Err(format!("no answer to {}", session.missing())) }
    })
}

fn ends_by_itself(bench: &mut Bench<'_>) -> CheckOutcome {
    let idle = bench.attempt(|_, session| session.part());
    if idle != CheckOutcome::Good {
        return idle;
    }
    bench.attempt(|bench, session| {
        session.survive(bench.plain_case()?)?;
        session.part()
    })
}
