//! `FW-ENV-10`.

use serde_json::json;

use super::{Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, fw};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-10",
        level: Level::Must,
        status: Status::Normative,
        statement: "A message never has both `body` and `error`.",
        source: fw::GENERAL,
        applies_to: "messages of the server",
    },
    check: Check::Exchange(judge),
    covers: &[],
    bug: Bug::message("Beside its body SYS-VER has an error.", |out| {
        if out.kind() == "SYS-VER" {
            out.message()["error"] = json!({ "message": "all is well" });
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "both",
        make: || fw::reply_message("SYS-VER", |message| message["error"] = json!({ "code": 7 })),
        also: &[],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let Some(message) = exchange.message() else { return };
    context.covered();
    if ["body", "error"].iter().all(|name| fw::is_there(message.get(name))) {
        exchange.breaks(context, || Detail::differs("one of `body` and `error`", "both"));
    }
}
