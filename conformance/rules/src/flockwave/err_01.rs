//! `FW-ERR-01`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ERR-01",
    name: "Error codes are integers",
    level: Level::Should,
    status: Status::Advisory,
    statement: "Error codes are non-negative integers.",
    source: source::ERRORS,
    applies_to: "`errors` of UAV-INF",
    why: "Clients look up the severity and the text of a code by its number. A negative code has neither.",
    example: concat!(
        r#"{"type":"UAV-INF","status":{"uav-1":{"id":"uav-1","timestamp":1790000000000,"#,
        r#""errors":[-1]}}}"#
    ),
    fix: "Send only codes from the specification, or custom codes of 32768 and above.",
})
.checks(&[Check::Message(check)])
.covers(&[Attribution::new(&["UAV-INF"], "status.*.errors.*", &[Fault::Value])])
.bug(Bug::message("An error code is negative.", |out| out.set_in_state("errors", json!([-1]))))
.mutants(&[Mutant::errors("a negative code", &[-1])]);

const CODE: ExpectedValue = ExpectedValue::Integer(0, i128::MAX);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    for (uav, state) in body::states(message, "UAV-INF") {
        let Some(Tree::List(codes)) = state.get("errors") else { continue };
        if codes.is_empty() {
            continue;
        }
        context.covered();
        // FW-UST-ERRORS reports values that are not integers.
        let codes = codes.iter().enumerate().filter(|(_, code)| code.as_integer().is_some());
        let wrong = codes.into_iter().find_map(|(at, code)| Some((at, CODE.mismatch(code)?)));
        if let Some((at, found)) = wrong {
            let path = pointer(&["body", "status", uav, "errors", &at.to_string()]);
            body::mismatched(message, context, Mismatch { path, ..found });
        }
    }
}
