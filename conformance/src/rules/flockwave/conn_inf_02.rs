//! `FW-CONN-INF-02`.

use super::fw::{self, Exchange};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-CONN-INF-02",
        level: Level::Must,
        status: Status::Normative,
        statement: "The key of each state is the `id` in it.",
        source: fw::MESSAGES,
        applies_to: "CONN-INF",
    },
    check: Check::Exchange(judge),
    mutants: &[Mutant {
        name: "another id",
        make: || fw::notice("CONN-INF", |body| body["status"]["winch"]["id"] = "tow".into()),
        also: &[],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    fw::keyed(exchange, context, "CONN-INF");
}
