//! `FW-UAV-INF-02`.

use super::fw::{self, Turn};
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

fn judge(turn: &Turn<'_>, context: &mut RuleContext<'_>) {
    fw::strangers(turn, context, &["UAV-INF"]);
}
