//! `FW-SIO-03`.

use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-SIO-03",
    name: "Unknown Socket.IO events do no harm",
    level: Level::Info,
    status: Status::Advisory,
    statement: "Over Socket.IO, the server keeps answering requests after an event other than `fw`, or \
                after an `fw` event without a message.",
    source: source::DERIVED,
    applies_to: served::APPLIES_TO,
    why: "A single unexpected event, for example from a newer client, must not end that client's session.",
    example: r#"→ 42["wind","turns"]
→ 42["fw",{"$fw.version":"1.0","id":"c1","body":{"type":"SYS-PING"}}]
(no response)"#,
    fix: "Log and ignore events other than `fw`, and `fw` events whose argument is not an object.",
})
.checks(&[Check::Exchange(served::check)])
.bug(
    Bug::behaviour("Over Socket.IO, no request is answered after an event other than `fw`.")
        .needs(Needs::SocketIo),
)
.trial(Trial::Attempts(Strain::Noise, attempts))
.mutants(&served::mutants("socketio#9"));

fn attempts(endpoint: &Endpoint) -> Vec<Attempt> {
    if !matches!(endpoint, Endpoint::SocketIo { .. }) {
        return Vec::new();
    }
    let events = [
        ("another name", r#"2["wind","turns"]"#),
        ("no argument", r#"2["fw"]"#),
        ("a number as the argument", r#"2["fw",17]"#),
        ("a string as the argument", r#"2["fw","not a message"]"#),
        ("null as the argument", r#"2["fw",null]"#),
        ("two arguments", r#"2["fw",{},{}]"#),
        ("a number as the name", r"2[17,{}]"),
    ];
    let attempt = |(kind, packet): (&str, &str)| {
        let steps = [Step::Packet(packet.to_owned()), Step::request("one")];
        Attempt::new(format!("after an unexpected event: {kind}"), steps)
    };
    events.map(attempt).into()
}
