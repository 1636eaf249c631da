//! `FW-TCP-02`.

use super::prelude::*;
use super::trial::SHORT_PAUSE;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-TCP-02",
    name: "Split and joined TCP segments",
    level: Level::Must,
    status: Status::Normative,
    statement: "Over TCP, the server accepts a message that is split into several segments, and several \
                messages in one segment.",
    source: source::TRANSPORT,
    applies_to: served::APPLIES_TO,
    why: "TCP does not preserve message boundaries. A server that handles each segment as one message \
          fails under load or with long messages.",
    example: r#"(one message in two TCP segments)
→ {"$fw.version":"1.0","id":"c1","body":{"ty
→ pe":"SYS-VER"}}
(no response)"#,
    fix: "Append received data to a buffer and process every complete line in it. Keep the remaining \
          bytes until the next segment arrives.",
})
.checks(&[Check::Exchange(served::check)])
.bug(
    Bug::behaviour("Over TCP, only the first of several requests in a segment is handled.").needs(Needs::Tcp),
)
.trial(Trial::Attempts(Strain::Sound, attempts))
.mutants(&served::mutants("tcp#9"));

fn attempts(endpoint: &Endpoint) -> Vec<Attempt> {
    if !matches!(endpoint, Endpoint::Tcp(_)) {
        return Vec::new();
    }
    let (one, two) = (|| Sent::request("one", "SYS-VER"), || Sent::request("two", "SYS-VER"));
    vec![
        Attempt::new("a message in two segments", [Step::Pieces(one(), 2, SHORT_PAUSE)]),
        Attempt::new("a message in many segments", [Step::Pieces(one(), 12, SHORT_PAUSE / 4)]),
        Attempt::new("two messages in one segment", [Step::Together(vec![one(), two()])]),
    ]
}
