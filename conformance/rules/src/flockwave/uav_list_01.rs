//! `FW-UAV-LIST-01`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UAV-LIST-01",
    name: "Fields of UAV-LIST",
    level: Level::Must,
    status: Status::Normative,
    statement: "`ids` is a list of strings.",
    source: source::MESSAGES,
    applies_to: "UAV-LIST",
    why: "Clients send these ids back in other requests, where only strings are valid.",
    example: r#"{"type":"UAV-LIST","ids":["uav-1",2]}"#,
    fix: "Convert all ids to strings, and send `ids` even if the list is empty.",
})
.checks(&[Check::Message(|message, context| body::id_list(message, context, "UAV-LIST"))])
.covers(&[
    Attribution::new(&["UAV-LIST"], "ids", attribution::MISSING),
    Attribution::new(&["UAV-LIST"], "ids.*", attribution::MISSING),
])
.bug(Bug::message("The last id in UAV-LIST is a number.", |out| out.make_last_id_a_number("UAV-LIST")))
.mutants(&[
    Mutant::reply("missing `ids`", "UAV-LIST", |body| mutant::remove(body, "ids")),
    Mutant::reply("an id that is a number", "UAV-LIST", |body| body["ids"][0] = 7.into()),
]);
