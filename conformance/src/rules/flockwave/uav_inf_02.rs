//! `FW-UAV-INF-02`.

use serde_json::json;

use super::{Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, fw};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-INF-02",
        level: Level::Info,
        status: Status::Advisory,
        statement: "A response tells of no UAV that wasn't asked for.",
        source: fw::DERIVED,
        applies_to: "UAV-INF",
    },
    check: Check::Exchange(judge),
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
        make: || fw::reply("UAV-INF", |body| body["error"]["hawk"] = "Asleep".into()),
        also: &[],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    fw::strangers(exchange, context, &["UAV-INF"]);
}
