//! `FW-TCP-03`.

use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-TCP-03",
    name: "Lines that are not JSON over TCP",
    level: Level::Should,
    status: Status::Advisory,
    statement: "Over TCP, a line that is not JSON is ignored, and the next line is processed.",
    source: source::TRANSPORT,
    applies_to: served::APPLIES_TO,
    why: "If the server mishandles invalid lines, a single corrupt line ends the client's session or \
          blocks the client's later requests.",
    example: r#"→ this is not JSON
→ {"type":"SYS-PING"}
(the server closes the connection)"#,
    fix: "Catch the parser error, log the line, and continue with the next line.",
})
.checks(&[Check::Exchange(served::check)])
.bug(Bug::behaviour("Over TCP, a line that is not JSON ends the connection.").needs(Needs::Tcp))
.trial(Trial::Attempts(Strain::Noise, attempts))
.mutants(&served::mutants("tcp#9"));

fn attempts(endpoint: &Endpoint) -> Vec<Attempt> {
    match endpoint {
        Endpoint::Tcp(_) => {
            let together = vec![Sent::request("one", "SYS-VER"), Sent::text("not a message", None)];
            let together =
                Attempt::new("a segment with a message and a non-JSON line", [Step::Together(together)]);
            let mut attempts = trial::after_noise("after a line that is not JSON", &["one"]);
            attempts.push(together);
            attempts
        }
        _ => Vec::new(),
    }
}
