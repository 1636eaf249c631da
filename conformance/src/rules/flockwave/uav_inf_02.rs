//! `FW-UAV-INF-02`.

use serde_json::json;

use super::{
    Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, mutant, reply, source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-INF-02",
        level: Level::Info,
        status: Status::Advisory,
        statement: "A response tells of no UAV that wasn't asked for.",
        source: source::DERIVED,
        applies_to: "UAV-INF",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(check)],
    covers: &[],
    bug: Bug::message("There is a UAV that nobody asked for.", |out| {
        if !out.is_notification()
            && let Some(mut state) = out.state().cloned()
        {
            state["id"] = json!("ghost-1");
            out.message()["body"]["status"]["ghost-1"] = state;
        }
    }),
    trial: None,
    mutants: &[Mutant {
        name: "one more glider",
        make: || mutant::reply("UAV-INF", |body| body["error"]["hawk"] = "Asleep".into()),
        also: &[],
    }],
};

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    reply::strangers(exchange, context, &["UAV-INF"]);
}
