//! `FW-UAV-INF-05`.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, Tree, fw,
};
use crate::json::pointer;

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-INF-05",
        level: Level::Should,
        status: Status::Normative,
        statement: "A notification has nothing beside `type` but `status`.",
        source: fw::MESSAGES,
        applies_to: "UAV-INF",
    },
    check: Check::Exchange(judge),
    covers: &[],
    bug: Bug::message("Notifications have errors, too.", |out| {
        if let Some(body) = out.notification_of("UAV-INF") {
            body["error"] = json!({ "ghost-1": "there is no such UAV" });
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "errors in a notification",
        make: || fw::notice("UAV-INF", |body| body["error"] = json!({ "owl": "Lost" })),
        also: &[],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let Some(Tree::Object(members)) = exchange.notification("UAV-INF") else { return };
    context.covered();
    if let Some((key, _)) = members.iter().find(|(key, _)| key != "type" && key != "status") {
        exchange.breaks(context, || {
            Detail::new(format!("it has {}, too", fw::quoted(key))).at(pointer(&["body", key]))
        });
    }
}
