//! `FW-ENV-27`.
//!
//! After a trial or a request without a response, the probe sends a request on another open connection and on a new
//! connection. These requests belong to this rule.

use super::{Bug, Check, FlockwaveRule, Level, Mutant, Rule, Status, env_22, mutant, served, source};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-27",
        name: "Clients do not affect each other",
        level: Level::Must,
        status: Status::Normative,
        statement: "Requests get a response, whatever another client has sent on another connection.",
        source: source::GENERAL,
        applies_to: "probe requests after a request or trial without a response",
        why: "If one message stops the service for all clients, a single faulty client grounds the whole fleet.",
        example: r#"(connection 1)
→ this is not JSON
(connection 2)
→ {"type":"SYS-VER"}
(no response)"#,
        fix: "Handle the errors of each connection separately. An error must end at most the connection that caused \
              it.",
    },
    checks: &[Check::Exchange(|exchange, context| {
        served::tried(exchange, context);
    })],
    covers: &[],
    bug: Bug::behaviour("After the message `{}`, no request is answered on any connection.")
        .with(&[&env_22::RULE.rule]),
    trial: None,
    mutants: &[
        Mutant { name: served::UNANSWERED, make: || mutant::unanswered("tcp#9", &RULE.rule), also: &[] },
        Mutant { name: served::NO_CONNECTION, make: || served::no_connection(&RULE.rule), also: &[] },
    ],
};
