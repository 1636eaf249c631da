//! `FW-UAV-LIST-01J`.

use super::{
    Attribution, Bug, Check, ExpectedValue, Fault, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext,
    Status, Tree, body, mutant, source,
};
use crate::flockwave::body_schema::Mismatch;

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-LIST-01J",
        level: Level::Should,
        status: Status::Advisory,
        statement: "The `ids` are unique, and each has 1 to 64 characters, none of them `/`.",
        source: source::SCHEMA,
        applies_to: "UAV-LIST",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[
        Attribution::new(&["UAV-LIST"], "ids", &[Fault::Value]),
        Attribution::new(&["UAV-LIST"], "ids.*", &[Fault::Value]),
    ],
    bug: Bug::message("UAV-LIST has its first id twice.", |out| out.repeat_first_id("UAV-LIST")),
    trial: None,
    mutants: &[
        Mutant {
            name: "an id twice",
            make: || mutant::reply("UAV-LIST", |body| body["ids"][0] = "swift".into()),
            also: &[],
        },
        Mutant {
            name: "an id with a slash",
            make: || mutant::reply("UAV-LIST", |body| body["ids"][0] = "kite/2".into()),
            also: &[],
        },
    ],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let Some(Tree::List(ids)) = message.body_of("UAV-LIST").and_then(|body| body.get("ids")) else { return };
    body::unique(message, context, "ids");
    // What is no string is another rule's matter.
    let wrong =
        ids.iter().filter(|id| id.as_str().is_some()).find_map(|id| ExpectedValue::ObjectId.mismatch(id));
    if let Some(found) = wrong {
        body::mismatched(message, context, Mismatch { path: "/body/ids".to_owned(), ..found });
    }
}
