//! `FW-OBJ-LIST-01J`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-OBJ-LIST-01J",
    name: "Form of object ids",
    level: Level::Should,
    status: Status::Advisory,
    statement: "The `ids` are unique, and each is 1 to 64 characters long and contains no `/`.",
    source: source::SCHEMA,
    applies_to: "OBJ-LIST",
    why: "Device paths start with the object id and use `/` as a separator, so an id with a slash cannot \
          be addressed. If an id is repeated, clients may show the object twice.",
    example: r#"{"type":"OBJ-LIST","ids":["fleet/uav-1"]}"#,
    fix: "Replace slashes in ids, shorten long ids, and remove duplicates.",
})
.checks(&[Check::Message(|message, context| body::object_ids(message, context, "OBJ-LIST"))])
.covers(&[
    Attribution::new(&["OBJ-LIST"], "ids", &[Fault::Value]),
    Attribution::new(&["OBJ-LIST"], "ids.*", &[Fault::Value]),
])
.bug(Bug::message("OBJ-LIST contains its first id twice.", |out| out.repeat_first_id("OBJ-LIST")))
.mutants(&[
    Mutant::reply("a duplicate id", "OBJ-LIST", |body| body["ids"][0] = "swift".into()),
    Mutant::reply("an id with a slash", "OBJ-LIST", |body| body["ids"][0] = "kite/2".into()),
]);
