//! `FW-OBJ-LIST-01`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-OBJ-LIST-01",
    name: "Fields of OBJ-LIST",
    level: Level::Must,
    status: Status::Normative,
    statement: "`ids` is a list of strings.",
    source: source::MESSAGES,
    applies_to: "OBJ-LIST",
    why: "Clients send these ids back in other requests, where only strings are valid.",
    example: r#"{"type":"OBJ-LIST","ids":["uav-1",2]}"#,
    fix: "Convert all ids to strings, and send `ids` even if the list is empty.",
})
.checks(&[Check::Message(|message, context| body::id_list(message, context, "OBJ-LIST"))])
.covers(&[
    Attribution::new(&["OBJ-LIST"], "ids", attribution::MISSING),
    Attribution::new(&["OBJ-LIST"], "ids.*", attribution::MISSING),
])
.bug(Bug::message("The last id in OBJ-LIST is a number.", |out| out.make_last_id_a_number("OBJ-LIST")))
.mutants(&[
    Mutant::reply("missing `ids`", "OBJ-LIST", |body| mutant::remove(body, "ids")),
    Mutant::reply("an id that is a number", "OBJ-LIST", |body| body["ids"][0] = 7.into()),
]);
