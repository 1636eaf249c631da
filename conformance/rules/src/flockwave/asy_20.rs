//! `FW-ASY-20`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ASY-20",
    name: "Fields of ASYNC-TIMEOUT",
    level: Level::Must,
    status: Status::Normative,
    statement: "ASYNC-TIMEOUT has `ids`, a list of strings.",
    source: source::ASYNC,
    applies_to: "ASYNC-TIMEOUT",
    why: "The client does not know which operations timed out and keeps waiting for them.",
    example: r#"{"type":"ASYNC-TIMEOUT","ids":"r2"}"#,
    fix: "Send the receipts as a list of strings in `ids`, even if there is only one receipt.",
})
.checks(&[Check::Message(|message, context| body::id_list(message, context, "ASYNC-TIMEOUT"))])
.covers(&[
    Attribution::new(&["ASYNC-TIMEOUT"], "ids", attribution::MISSING),
    Attribution::new(&["ASYNC-TIMEOUT"], "ids.*", attribution::MISSING),
])
.bug(Bug::message("The `ids` of ASYNC-TIMEOUT is a string.", |out| out.replace_ids_by_first("ASYNC-TIMEOUT")))
.mutants(&[Mutant::notice("a single id instead of a list", "ASYNC-TIMEOUT", |body| {
    body["ids"] = "rcpt-2".into();
})]);
