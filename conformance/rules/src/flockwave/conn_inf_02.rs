//! `FW-CONN-INF-02`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-CONN-INF-02",
    name: "Keys of connection states",
    level: Level::Must,
    status: Status::Normative,
    statement: "The key of each state in `status` equals the `id` in that state.",
    source: source::MESSAGES,
    applies_to: "CONN-INF",
    why: "Clients that index by key and clients that index by `id` assign the state to different \
          connections.",
    example: r#"{"type":"CONN-INF","status":{"radio-1":{"id":"radio-2",
  "purpose":"uavRadioLink","status":"connected"}}}"#,
    fix: "Use the `id` of each state as its key in `status`.",
})
.checks(&[Check::Message(|message, context| body::keyed(message, context, "CONN-INF"))])
.bug(Bug::message("The `id` of each connection differs from its key.", |out| {
    out.each_status("CONN-INF", |status| status["id"] = json!("radio-7"));
}))
.mutants(&[Mutant::notice("an id that differs from its key", "CONN-INF", |body| {
    body["status"]["winch"]["id"] = "tow".into();
})]);
