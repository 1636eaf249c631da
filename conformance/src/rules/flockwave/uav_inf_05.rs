//! `FW-UAV-INF-05`.

use serde_json::json;

use super::{
    Bug, Check, Detail, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Status, Tree, body, mutant,
    source,
};
use crate::json::pointer;

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-INF-05",
        level: Level::Should,
        status: Status::Normative,
        statement: "A notification has nothing beside `type` but `status`.",
        source: source::MESSAGES,
        applies_to: "UAV-INF",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("Notifications have errors, too.", |out| {
        if let Some(body) = out.notification_of("UAV-INF") {
            body["error"] = json!({ "ghost-1": "there is no such UAV" });
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "errors in a notification",
        make: || mutant::notice("UAV-INF", |body| body["error"] = json!({ "owl": "Lost" })),
        also: &[],
    }],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let Some(Tree::Object(members)) = message.notification("UAV-INF") else { return };
    context.covered();
    if let Some((key, _)) = members.iter().find(|(key, _)| key != "type" && key != "status") {
        message.violates(context, || {
            Detail::new(format!("it has {}, too", body::quoted(key))).at(pointer(&["body", key]))
        });
    }
}
