//! `FW-ERR-02`.

use super::fw::{self, Exchange};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ERR-02",
        level: Level::Should,
        status: Status::Normative,
        statement: "0 isn't listed: an empty list says that there is no error.",
        source: fw::ERRORS,
        applies_to: "`errors` of UAV-INF",
    },
    check: Check::Exchange(judge),
    mutants: &[
        Mutant { name: "0", make: || fw::errors(&[0]), also: &[] },
        Mutant { name: "0 beside another", make: || fw::errors(&[0, 1]), also: &[] },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    fw::codes(exchange, context, |codes| codes.contains(&0).then(|| "0 is listed".to_owned()));
}
