//! `FW-UAV-LIST-01J`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-UAV-LIST-01J",
    name: "Form of UAV ids",
    level: Level::Should,
    status: Status::Advisory,
    statement: "The `ids` are unique, and each is 1 to 64 characters long and contains no `/`.",
    source: source::SCHEMA,
    applies_to: "UAV-LIST",
    why: "Device paths start with the UAV id and use `/` as a separator, so an id with a slash cannot be \
          addressed. If an id is repeated, clients may show the UAV twice.",
    example: r#"{"type":"UAV-LIST","ids":["fleet/uav-1"]}"#,
    fix: "Replace slashes in ids, shorten long ids, and remove duplicates.",
})
.checks(&[Check::Message(|message, context| body::object_ids(message, context, "UAV-LIST"))])
.covers(&[
    Attribution::new(&["UAV-LIST"], "ids", &[Fault::Value]),
    Attribution::new(&["UAV-LIST"], "ids.*", &[Fault::Value]),
])
.bug(Bug::message("UAV-LIST contains its first id twice.", |out| out.repeat_first_id("UAV-LIST")))
.mutants(&[
    Mutant::reply("a duplicate id", "UAV-LIST", |body| body["ids"][0] = "swift".into()),
    Mutant::reply("an id with a slash", "UAV-LIST", |body| body["ids"][0] = "kite/2".into()),
]);
