//! `FW-ACK-06`.
//!
//! AUTH-INF reports that a login is required, but doesn't say which requests require a login. The probe chooses a
//! request that requires a login.

use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ACK-06",
    name: "Refusal before login",
    level: Level::Must,
    status: Status::Normative,
    statement: "Before login, a request that requires a login is refused with ACK-NAK.",
    source: source::MESSAGES,
    applies_to: "probe requests that test this rule",
    why: "If the server serves protected requests before login, anyone who can connect can read data and \
          send commands reserved for authenticated users.",
    example: r#"→ {"type":"AUTH-INF"}
← {"type":"AUTH-INF","methods":["basic"],"required":true}
→ {"type":"UAV-LIST"}
← {"type":"UAV-LIST","ids":["uav-1","uav-2"]}"#,
    fix: "Check the login before you handle the request. Answer with ACK-NAK until a user is logged in.",
})
.checks(&[Check::Exchange(check)])
.bug(
    Bug::behaviour("With --login, requests that require a login are served before login.")
        .needs(Needs::Login),
)
.mutants(&[
    Mutant::connection("the request is served before login", "tcp#9", |session| {
        let served = json!({ "type": "UAV-LIST", "ids": ["kite"] });
        let request = json!({ "type": "UAV-LIST" });
        session.tries_and_receives(&RULE.rule, "", request, served);
    }),
    Mutant::unanswered("the request is not answered", "tcp#9"),
]);

fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if served::tried(exchange, context) && exchange.type_name != Some("ACK-NAK") {
        exchange.violates(context, || {
            let found = exchange.type_name.map_or_else(|| "another answer".to_owned(), body::quoted);
            Detail::differs("ACK-NAK", found)
        });
    }
}
