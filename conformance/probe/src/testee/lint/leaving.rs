//! Checks how a testee exits.

use super::{Bench, Check, CheckOutcome};

/// The number of pending requests when the input is closed.
const NUM_CASES: usize = 8;

pub(super) const ANSWERS_BEFORE_END: Check = Check {
    id: "answers-before-end",
    statement: "every request sent before standard input closes must get a response",
    help: "process all lines up to the end of the input, write and flush all responses, then exit",
    attempt: answers_before_end,
};

pub(super) const ENDS_BY_ITSELF: Check = Check {
    id: "ends-by-itself",
    statement: "the testee exits with status 0 after standard input closes; over TCP, it closes the connection",
    help: "at the end of the input, stop threads and timers, and exit with status 0",
    attempt: ends_by_itself,
};

fn answers_before_end(bench: &mut Bench<'_>) -> CheckOutcome {
    bench.run(|bench, session| {
        let case = bench.plain_case()?;
        for _ in 0..NUM_CASES {
            session.send_case(case);
        }
        // Another check covers how the testee exits.
        let _ = session.finish();
        if session.is_answered() { Ok(()) } else { Err(format!("no response to {}", session.missing())) }
    })
}

fn ends_by_itself(bench: &mut Bench<'_>) -> CheckOutcome {
    let idle = bench.run(|_, session| session.finish());
    if idle != CheckOutcome::Pass {
        return idle;
    }
    bench.run(|bench, session| {
        session.check_alive(bench.plain_case()?)?;
        session.finish()
    })
}
