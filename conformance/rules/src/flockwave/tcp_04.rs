//! `FW-TCP-04`.

use std::time::Duration;

use super::prelude::*;
use super::tcp_02;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-TCP-04",
    name: "Incomplete messages over TCP",
    level: Level::Info,
    status: Status::Advisory,
    statement: "Over TCP, the server waits for the rest of an incomplete message.",
    source: source::DERIVED,
    applies_to: served::APPLIES_TO,
    why: "Over a slow link, the parts of a message may arrive seconds apart. A server that drops the \
          first part loses the request.",
    example: r#"→ {"$fw.version":"1.0","id":"c1","body":{"ty
(1.2 s later)
→ pe":"SYS-VER"}}
(no response)"#,
    fix: "Keep incomplete lines in the buffer until the line break arrives or the connection closes. Do \
          not use a timeout shorter than a few seconds.",
})
.checks(&[Check::Exchange(served::check)])
.bug(
    Bug::behaviour("Over TCP, the start of a message is dropped if the rest is in another segment.")
        .needs(Needs::Tcp)
        .also(&[&tcp_02::RULE.rule]),
)
.trial(Trial::Attempts(Strain::Sound, attempts))
.mutants(&served::mutants("tcp#9"));

/// The pause between the two halves of a message.
const LONG_PAUSE: Duration = Duration::from_millis(1_200);

fn attempts(endpoint: &Endpoint) -> Vec<Attempt> {
    if !matches!(endpoint, Endpoint::Tcp(_)) {
        return Vec::new();
    }
    let late = Step::Pieces(Sent::request("one", "SYS-VER"), 2, LONG_PAUSE);
    vec![Attempt::new("a message whose second half arrives late", [late])]
}
