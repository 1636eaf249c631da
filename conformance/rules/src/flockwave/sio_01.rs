//! `FW-SIO-01`.

use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-SIO-01",
    name: "Socket.IO handshake",
    level: Level::Must,
    status: Status::Normative,
    statement: "Over Socket.IO, connections follow the handshake and upgrade steps of the Socket.IO \
                protocol, and messages are sent as `fw` events.",
    source: source::TRANSPORT,
    applies_to: served::APPLIES_TO,
    why: "Socket.IO clients listen for `fw` events only. If the server deviates, clients get no response \
          or cannot connect at all.",
    example: r#"→ 42["fw",{"$fw.version":"1.0","id":"c1","body":{"type":"SYS-PING"}}]
← 42["flockwave",{"$fw.version":"1.0","id":"s1","refs":"c1","body":{"type":"ACK-ACK"}}]"#,
    fix: "Use a standard Socket.IO server library. Send and receive each message as the only argument of \
          an `fw` event.",
})
.checks(&[Check::Exchange(served::check)])
.bug(Bug::behaviour("Over Socket.IO, messages are sent as `flockwave` events.").needs(Needs::SocketIo))
.trial(Trial::Attempts(Strain::Plain, attempts))
.mutants(&served::mutants("socketio#9"));

fn attempts(endpoint: &Endpoint) -> Vec<Attempt> {
    match endpoint {
        Endpoint::SocketIo { .. } => vec![Attempt::new("", [Step::request("one")])],
        _ => Vec::new(),
    }
}
