//! `FW-ENV-24`.
//!
//! Whoever tries it asks something of each family, and on the same connection for a type that there isn't: a family has
//! no handler where all that was asked of it is refused just as that was. ACK has no requests that could be tried.
//!
//! Servers that need a login may refuse everything before it alike. So nothing is said of connections without one, where
//! the server has said that it needs one.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Location, Mutant, PerConnection, Role, Rule,
    RuleContext, SessionCheck, Status, Tree, env_07, mutant, served, source,
};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-24",
        level: Level::Must,
        status: Status::Normative,
        statement: "Each mandatory family has a handler: ASYNC, AUTH, CONN, DEV, EXT, OBJ, RTK, SYS and UAV. (Nothing can be asked of ACK.)",
        source: source::GENERAL,
        applies_to: "requests that try it",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Session(|| Box::new(Families::default()))],
    covers: &[],
    bug: Bug::behaviour("Nothing of the family DEV is handled."),
    trial: None,
    mutants: &[
        Mutant {
            name: "DEV is refused as what there isn't",
            make: || {
                mutant::over("tcp#9", |session| {
                    session.logs_in();
                    for (rule, name) in
                        [(&RULE.rule, "DEV-LIST"), (&env_07::RULE.rule, "UAV-SOAR"), (&RULE.rule, "DEV-SUB")]
                    {
                        let refused = json!({ "type": "ACK-NAK", "reason": format!("{name} isn't known") });
                        session.tries_and_receives(rule, "", json!({ "type": name }), refused);
                    }
                })
            },
            also: &[],
        },
        Mutant {
            name: "CONN is refused without a reason, as is what there isn't",
            make: || {
                mutant::over("tcp#9", |session| {
                    session.logs_in();
                    for (rule, name) in [(&env_07::RULE.rule, "UAV-SOAR"), (&RULE.rule, "CONN-LIST")] {
                        session.tries_and_receives(
                            rule,
                            "",
                            json!({ "type": name }),
                            json!({ "type": "ACK-NAK" }),
                        );
                    }
                })
            },
            also: &[],
        },
        Mutant {
            name: "no answer to a family",
            make: || {
                mutant::over("tcp#9", |session| {
                    session.tries(&RULE.rule, "", json!({ "type": "RTK-LIST" }));
                })
            },
            also: &[],
        },
    ],
};

/// The families that can be asked.
const FAMILIES: [&str; 9] = ["ASYNC", "AUTH", "CONN", "DEV", "EXT", "OBJ", "RTK", "SYS", "UAV"];

/// How much of a reason is compared, in characters.
const MAX_REASON: usize = 256;

/// How many ways to refuse are told apart.
const MAX_REASONS: usize = 16;

/// How families are refused, connection by connection.
#[derive(Default)]
struct Families {
    is_login_needed: bool,
    connections: PerConnection<Refusals>,
}

/// How requests on a connection are refused.
#[derive(Default)]
struct Refusals {
    is_logged_in: bool,
    /// How a type is that there isn't.
    unknown: BTreeSet<String>,
    /// How each family is.
    families: BTreeMap<&'static str, Family>,
}

/// What came of asking a family.
struct Family {
    is_served: bool,
    reasons: BTreeSet<String>,
    location: Location,
}

impl SessionCheck for Families {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if let Some(refusals) = self.connections.closed(exchange) {
            return self.check_family(refusals, context);
        }
        if !exchange.record.connection.is_ordered {
            return;
        }
        if let Some(body) = exchange.response("AUTH-INF") {
            self.is_login_needed |= body.get("required") == Some(&Tree::Bool(true));
        }
        if let Some(body) = exchange.response("AUTH-RESP") {
            self.connections.get(exchange).is_logged_in |= body.get("result") == Some(&Tree::Bool(true));
        }
        if exchange.role == Role::Response && exchange.tried(&env_07::RULE.rule).is_some() {
            let request = exchange.request.as_ref().and_then(|request| request.type_name.as_deref());
            if let Some(name) = request.filter(|name| !context.definitions.body_schemas().has(name))
                && let Some(reason) = reason(exchange, name)
            {
                let unknown = &mut self.connections.get(exchange).unknown;
                if unknown.len() < MAX_REASONS {
                    unknown.insert(reason);
                }
            }
        }
        if served::tried(exchange, context) {
            self.tried(exchange);
        }
    }

    fn corruption(&mut self, _: Location) {
        self.connections.clear();
    }
}

impl Families {
    fn tried(&mut self, exchange: &Exchange<'_>) {
        let Some(name) = exchange.request.as_ref().and_then(|request| request.type_name.as_deref()) else {
            return;
        };
        let Some(family) = FAMILIES.iter().find(|family| name.split('-').next() == Some(family)) else {
            return;
        };
        let families = &mut self.connections.get(exchange).families;
        let new =
            || Family { is_served: false, reasons: BTreeSet::new(), location: exchange.record.location };
        let family = families.entry(family).or_insert_with(new);
        match reason(exchange, name) {
            Some(reason) if family.reasons.len() < MAX_REASONS => _ = family.reasons.insert(reason),
            // What is refused in ever other ways is refused for a reason.
            Some(_) | None => family.is_served = true,
        }
    }

    fn check_family(&self, refusals: Refusals, context: &mut RuleContext<'_>) {
        if self.is_login_needed && !refusals.is_logged_in {
            return;
        }
        for (name, family) in refusals.families {
            let is_absent = !family.is_served && family.reasons.is_subset(&refusals.unknown);
            if is_absent {
                context.violation(name, family.location, || {
                    Detail::new("requests are refused just as one of a type that there isn't")
                        .expected("a handler")
                        .actual("none")
                });
            }
        }
    }
}

/// The reason with which a request is refused, but for its type; empty where there is none.
fn reason(exchange: &Exchange<'_>, type_name: &str) -> Option<String> {
    let body = exchange.response("ACK-NAK")?;
    let reason = body.get("reason").and_then(Tree::as_str).unwrap_or_default();
    Some(reason.replace(type_name, "…").chars().take(MAX_REASON).collect())
}
