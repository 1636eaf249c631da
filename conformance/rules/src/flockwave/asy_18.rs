//! `FW-ASY-18`.

use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-18",
    name: "Unknown receipts are errors",
    level: Level::Info,
    status: Status::Advisory,
    statement: "If a receipt in ASYNC-CANCEL or ASYNC-RESUME is unknown, the response lists it in `error`.",
    source: source::DERIVED,
    applies_to: "ASYNC-CANCEL and ASYNC-RESUME requests from a probe that tests this rule",
    why: "If an unknown receipt is accepted, the client believes that an operation was stopped. If the \
          whole request is refused, the client gets no answer about the other receipts.",
    example: r#"→ {"type":"ASYNC-CANCEL","ids":["r99"]}
← {"type":"ASYNC-CANCEL","success":["r99"]}"#,
    fix: "Look up each receipt. If it is unknown, add an entry such as \"unknown receipt\" to `error`, \
          and process the other receipts.",
})
.checks(&[Check::Exchange(|exchange, context| {
    served::in_error(exchange, context, &["ASYNC-CANCEL", "ASYNC-RESUME"]);
})])
.bug(Bug::behaviour("ASYNC-CANCEL accepts unknown receipts."))
.trial(Trial::Requests(|_| requests()))
.mutants(&[
    Mutant::connection("an unknown receipt is cancelled", "tcp#9", |session| {
        let cancel = json!({ "type": "ASYNC-CANCEL", "ids": ["rcpt-none"] });
        let done = json!({ "type": "ASYNC-CANCEL", "success": ["rcpt-none"] });
        session.tries_and_receives(&RULE.rule, "", cancel, done);
    }),
    Mutant::refused("the request is refused", "tcp#9"),
]);

fn requests() -> Vec<Request> {
    let cancel = json!({ "type": "ASYNC-CANCEL", "ids": [trial::UNKNOWN_ID] });
    let resume = json!({ "type": "ASYNC-RESUME", "ids": [trial::UNKNOWN_ID], "values": {} });
    vec![Request::new("cancelled", cancel), Request::new("resumed", resume)]
}
