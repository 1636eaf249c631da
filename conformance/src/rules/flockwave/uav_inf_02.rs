//! `FW-UAV-INF-02`.

use super::fw::{self, Exchange};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

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
    mutants: &[Mutant {
        name: "one more glider",
        make: || fw::reply("UAV-INF", |body| body["error"]["hawk"] = "Asleep".into()),
        also: &[],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    fw::strangers(exchange, context, &["UAV-INF"]);
}
