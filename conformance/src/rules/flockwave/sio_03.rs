//! `FW-SIO-03`.

use super::{
    Attempt, Bug, Check, FlockwaveRule, Level, Mutant, Needs, Rule, Status, Step, Strain, Trial, mutant,
    served, source,
};
use crate::flockwave::transport::endpoint::Endpoint;

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SIO-03",
        level: Level::Info,
        status: Status::Advisory,
        statement: "An event that isn't `fw`, or whose argument is no message, doesn't end the service.",
        source: source::DERIVED,
        applies_to: served::APPLIES_TO,
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(served::check)],
    covers: &[],
    bug: Bug::behaviour(
        "Over Socket.IO, nothing is answered any more after an event that is none of Flockwave.",
    )
    .needs(Needs::SocketIo),
    trial: Some(Trial::Attempts(Strain::Noise, attempts)),
    mutants: &[
        Mutant { name: served::UNANSWERED, make: || mutant::unanswered("socketio#9", &RULE.rule), also: &[] },
        Mutant { name: served::REFUSED, make: || mutant::refused("socketio#9", &RULE.rule), also: &[] },
        Mutant { name: served::NO_CONNECTION, make: || served::no_connection(&RULE.rule), also: &[] },
    ],
};

fn attempts(endpoint: &Endpoint) -> Vec<Attempt> {
    if !matches!(endpoint, Endpoint::SocketIo { .. }) {
        return Vec::new();
    }
    let odd = [
        ("one of another name", r#"2["wind","turns"]"#),
        ("one without a message", r#"2["fw"]"#),
        ("one whose message is a number", r#"2["fw",17]"#),
        ("one whose message is a string", r#"2["fw","the wind turns"]"#),
        ("one whose message is null", r#"2["fw",null]"#),
        ("one with two messages", r#"2["fw",{},{}]"#),
        ("one whose name is a number", r"2[17,{}]"),
    ];
    let attempt = |(kind, packet): (&str, &str)| {
        let steps = [Step::Packet(packet.to_owned()), Step::request("one")];
        Attempt::new(format!("after an odd event: {kind}"), steps)
    };
    odd.map(attempt).into()
}
