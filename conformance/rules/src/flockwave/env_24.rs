//! `FW-ENV-24`.
//!
//! The probe sends requests of each family, and a request of an unknown type. A family counts as unhandled under two
//! conditions: the server serves none of the family's requests on any connection, and it refuses them in the same way
//! as the request of an unknown type. ACK has no requests, so it is not tested. `FW-ENV-07` reports requests without a
//! response.
//!
//! A request that names objects may also be refused because the objects don't exist. Such a refusal counts only if its
//! reason contains the type of the request.
//!
//! Before login, a server may refuse every request in the same way. If the server reports that it requires a login,
//! connections without a login are not checked.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

use super::env_07;
use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-24",
    name: "Mandatory message families",
    level: Level::Must,
    status: Status::Normative,
    statement: "Each mandatory message family has a handler: ASYNC, AUTH, CONN, DEV, EXT, OBJ, RTK, SYS \
                and UAV. ACK has no requests.",
    source: source::GENERAL,
    applies_to: "probe requests that test this rule",
    why: "Clients use these families without checking that the server supports them. If a handler is \
          missing, views such as the list of devices stay empty.",
    example: r#"→ {"type":"UAV-SOAR"}
← {"type":"ACK-NAK","reason":"No handler for UAV-SOAR"}
→ {"type":"DEV-LIST","ids":["uav-1"]}
← {"type":"ACK-NAK","reason":"No handler for DEV-LIST"}"#,
    fix: "Add handlers for the family. If the server has no objects of this family, return empty lists \
          and report each unknown id in `error`.",
})
.checks(&[Check::Session(|| Box::new(Families::default()))])
.bug(Bug::behaviour("The DEV family has no handler."))
.mutants(&[
    Mutant::new("DEV requests are refused as if their type were unknown", || {
        refused(|session| {
            for (rule, name) in
                [(&RULE.rule, "DEV-LIST"), (&env_07::RULE.rule, "UAV-SOAR"), (&RULE.rule, "DEV-SUB")]
            {
                let refused = json!({ "type": "ACK-NAK", "reason": format!("{name} isn't known") });
                session.tries_and_receives(rule, "", json!({ "type": name }), refused);
            }
        })
    }),
    Mutant::new("CONN requests are refused without a reason, as if their type were unknown", || {
        refused(|session| {
            for (rule, name) in [(&env_07::RULE.rule, "UAV-SOAR"), (&RULE.rule, "CONN-LIST")] {
                session.tries_and_receives(rule, "", json!({ "type": name }), json!({ "type": "ACK-NAK" }));
            }
        })
    }),
]);

/// A session with these refusals. In the conforming session, the server serves all families.
#[allow(clippy::unnecessary_wraps)] // like all mutants
fn refused(add: impl FnOnce(&mut Session)) -> Option<Vec<u8>> {
    let mut session = Session::opened();
    session.logs_in();
    add(&mut session);
    session.closed("client");
    Some(session.to_bytes())
}

/// The families that have requests.
const FAMILIES: [&str; 9] = ["ASYNC", "AUTH", "CONN", "DEV", "EXT", "OBJ", "RTK", "SYS", "UAV"];

/// The maximum length of a compared reason, in characters.
const MAX_REASON: usize = 256;

/// The maximum number of distinct reasons.
const MAX_REASONS: usize = 16;

/// The refusals, by connection.
#[derive(Default)]
struct Families {
    is_login_needed: bool,
    /// The reasons for refusing an unknown type.
    unknown: BTreeSet<String>,
    /// The families with a request that was served on any connection.
    served: BTreeSet<&'static str>,
    connections: PerConnection<Refusals>,
    /// The refusals on connections that ended.
    ended: BTreeMap<&'static str, Family>,
}

/// The refused requests on a connection.
#[derive(Default)]
struct Refusals {
    is_logged_in: bool,
    /// The families with refused requests that test the rule.
    families: BTreeMap<&'static str, Family>,
}

/// The refusals of the requests of a family.
struct Family {
    reasons: BTreeSet<String>,
    location: Location,
}

impl SessionCheck for Families {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if let Some(refusals) = self.connections.closed(exchange) {
            return self.add_ended(refusals);
        }
        if let Some(body) = exchange.response("AUTH-INF") {
            self.is_login_needed |= body.get("required") == Some(&Tree::Bool(true));
        }
        if let Some(body) = exchange.response("AUTH-RESP") {
            self.connections.get(exchange).is_logged_in |= body.get("result") == Some(&Tree::Bool(true));
        }
        if exchange.tried(&env_07::RULE.rule).is_some() {
            let request = exchange.request.as_ref().and_then(|request| request.type_name.as_deref());
            if let Some(name) = request.filter(|name| !context.definitions.body_schemas().has(name))
                && let Some(reason) = reason(exchange, name)
                && self.unknown.len() < MAX_REASONS
            {
                self.unknown.insert(reason);
            }
        }
        let is_served = exchange.role == Role::Response
            && exchange.is_from_server()
            && served::refusal(exchange).is_none();
        if let Some(family) = requested_family(exchange).filter(|_| is_served) {
            self.served.insert(family);
        }
        if exchange.role == Role::Response && exchange.tried(context.rule).is_some() {
            context.covered();
            self.add(exchange);
        }
    }

    fn corruption(&mut self, _: Location) {
        self.connections.clear();
    }

    fn end(&mut self, context: &mut RuleContext<'_>) {
        for (name, family) in std::mem::take(&mut self.ended) {
            if !self.served.contains(name) && family.reasons.is_subset(&self.unknown) {
                context.violation(name, family.location, || {
                    Detail::new("requests are refused as if their type were unknown")
                        .expected("a handler")
                        .actual("none")
                });
            }
        }
    }
}

impl Families {
    /// Adds the refusal of a request that tests the rule.
    fn add(&mut self, exchange: &Exchange<'_>) {
        let (Some(request), Some(family)) = (&exchange.request, requested_family(exchange)) else { return };
        let name = request.type_name.as_deref().unwrap_or_default();
        let Some(reason) = reason(exchange, name) else { return };
        let names_objects = request.objects.as_ref().is_some_and(|objects| !objects.is_empty());
        if names_objects && !names_type(exchange, name) {
            return;
        }
        let refusals = self.connections.get(exchange);
        let new = || Family { reasons: BTreeSet::new(), location: exchange.record.location };
        let refused = refusals.families.entry(family).or_insert_with(new);
        if refused.reasons.len() < MAX_REASONS {
            refused.reasons.insert(reason);
        } else {
            // Only a server that handles the family gives so many different reasons.
            self.served.insert(family);
        }
    }

    /// Adds the refusals on a connection that ended.
    fn add_ended(&mut self, refusals: Refusals) {
        if self.is_login_needed && !refusals.is_logged_in {
            return;
        }
        for (name, family) in refusals.families {
            match self.ended.entry(name) {
                Entry::Vacant(entry) => drop(entry.insert(family)),
                Entry::Occupied(entry) => entry.into_mut().reasons.extend(family.reasons),
            }
        }
    }
}

/// The family of the request that a record answers.
fn requested_family(exchange: &Exchange<'_>) -> Option<&'static str> {
    let name = exchange.request.as_ref()?.type_name.as_deref()?;
    let family = name.split('-').next();
    FAMILIES.into_iter().find(|known| family == Some(*known))
}

/// The reason for a refusal, with each occurrence of the request type replaced by `…`; empty if there is no reason.
fn reason(exchange: &Exchange<'_>, type_name: &str) -> Option<String> {
    let (_, reason) = served::refusal(exchange).filter(|_| exchange.role == Role::Response)?;
    let reason = reason.unwrap_or_default();
    Some(reason.replace(type_name, "…").chars().take(MAX_REASON).collect())
}

/// True if the reason for a refusal contains the request type.
fn names_type(exchange: &Exchange<'_>, type_name: &str) -> bool {
    let reason = served::refusal(exchange).and_then(|(_, reason)| reason);
    reason.is_some_and(|reason| reason.contains(type_name))
}
