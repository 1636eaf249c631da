//! `FW-UDP-02`.

use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UDP-02",
    name: "Address of a response over UDP",
    level: Level::Info,
    status: Status::Advisory,
    statement: "Over UDP, the response goes to the address and port that the request came from.",
    source: source::DERIVED,
    applies_to: udp::APPLIES_TO,
    why: "The client receives responses only on the socket that sent the request, and most firewalls and \
          NATs drop all other datagrams.",
    example: r#"→ {"type":"SYS-PING"}
(the request comes from port 40001, the response goes to port 40002)"#,
    fix: "Send the response to the source address of the request, as `recvfrom` returns it.",
})
.checks(&[Check::Session(|| Box::new(udp::Trials::new()))])
.bug(Bug::behaviour("Over UDP, all responses go to the address of the first client.").needs(Needs::Udp))
.trial(Trial::Attempts(Strain::Plain, attempts))
.mutants(&[
    Mutant::connection("requests without a response", "udp#9", |session| {
        udp::unanswered(session, &RULE.rule);
    }),
    Mutant::refused("a refused request", "udp#9"),
]);

fn attempts(endpoint: &Endpoint) -> Vec<Attempt> {
    match endpoint {
        Endpoint::Udp(_) => vec![Attempt::new("", udp::REQUESTS.map(Step::request))],
        _ => Vec::new(),
    }
}
