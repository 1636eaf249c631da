//! `FW-UDP-03`.

use super::env_27;
use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UDP-03",
    name: "Malformed datagrams do no harm",
    level: Level::Info,
    status: Status::Advisory,
    statement: "Over UDP, the server keeps serving after a datagram that is not a message.",
    source: source::DERIVED,
    applies_to: udp::APPLIES_TO,
    why: "Anyone can send a datagram to a UDP port. If an invalid datagram stops the server, a single \
          port scan ends the service for all clients.",
    example: r#"→ {"type":"SYS-PING"}
← {"type":"ACK-ACK"}
→ this is not JSON
→ {"type":"SYS-PING"}
(no response)"#,
    fix: "Catch the parser error, drop the datagram, and continue receiving.",
})
.checks(&[Check::Session(|| Box::new(udp::Trials::if_server_sends()))])
.bug(
    Bug::behaviour("Over UDP, a datagram that is not JSON ends the service.")
        .needs(Needs::Udp)
        .also(&[&env_27::RULE.rule]),
)
.trial(Trial::Attempts(Strain::Noise, attempts))
.mutants(&[
    Mutant::connection("requests without a response", "udp#9", |session| {
        udp::unanswered(session, &RULE.rule);
    }),
    Mutant::refused("a refused request", "udp#9"),
]);

fn attempts(endpoint: &Endpoint) -> Vec<Attempt> {
    match endpoint {
        Endpoint::Udp(_) => trial::after_noise("after a datagram that is not JSON", &udp::REQUESTS),
        _ => Vec::new(),
    }
}
