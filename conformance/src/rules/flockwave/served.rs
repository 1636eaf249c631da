//! Checks of requests that try a rule, and the parts that rules share on requests that a server has to serve, whatever
//! precedes them and however they arrive.
//!
//! Trials are marked in the session. A refused request isn't served either, so no trial uses a request that a server may
//! refuse for other reasons.

use super::{Detail, Exchange, Role, Rule, RuleContext, Tree, body, mutant, reply};

/// The records that these rules apply to.
pub(super) const APPLIES_TO: &str = "requests that try it";

/// The name of the mutant that has no answer.
pub(super) const UNANSWERED: &str = "a trial without an answer";

/// The name of the mutant that is refused.
pub(super) const REFUSED: &str = "a trial that is refused";

/// The name of the mutant that gets no connection.
pub(super) const NO_CONNECTION: &str = "a trial for which there is no connection";

/// Checks that a request that tries the rule is served.
pub(super) fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    served(exchange, context);
}

/// The session in which a connection that tries the rule is refused.
pub(super) fn no_connection(rule: &Rule) -> Option<Vec<u8>> {
    mutant::then(|session| session.refused(rule, "no connection", "Nobody is there"))
}

/// True if this is the response to a request that tries the rule. Reports a violation if there is no response or no
/// connection; but not if the session doesn't show how the connection ended, or messages may be lost.
pub(super) fn tried(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) -> bool {
    let Some(how) = exchange.tried(context.rule) else { return false };
    let (what, actual) = match exchange.role {
        Role::Response => {
            context.covered();
            return true;
        }
        Role::Unanswered if is_over(exchange) => ("no response", "none"),
        Role::Event if exchange.record.text == "refused" => ("no connection", "none"),
        _ => return false,
    };
    context.covered();
    unserved(exchange, context, what, actual, how);
    false
}

/// True if any response would be in the session.
fn is_over(exchange: &Exchange<'_>) -> bool {
    exchange.record.note.is_some() && exchange.record.connection.is_ordered
}

/// Reports a request that tries the rule and gets no response or no connection. The subject is the part of `how` before
/// the first colon: several ways of trying show one weakness.
fn unserved(exchange: &Exchange<'_>, context: &mut RuleContext<'_>, what: &str, actual: &str, how: &str) {
    let type_name = exchange.request.as_ref().and_then(|request| request.type_name.as_deref());
    let (way, kind) = how.split_once(": ").unwrap_or((how, ""));
    let subject = if way.is_empty() { type_name.unwrap_or("message") } else { way };
    context.violation(subject, exchange.record.location, || {
        let why = match exchange.record.note {
            // The client itself gave up.
            None | Some("client") => String::new(),
            Some("eof") => "; the server closed the connection".to_owned(),
            Some(why) => format!("; {}", body::quoted(why)),
        };
        let of = type_name.map_or_else(String::new, |name| format!(" to {}", body::quoted(name)));
        let kind = if kind.is_empty() { String::new() } else { format!(" ({kind})") };
        Detail::new(format!("{what}{of}{kind}{why}")).expected("a response").actual(actual)
    });
}

/// True if this is the response to a request that tries the rule, and doesn't refuse it. Reports a refusal as a
/// violation.
pub(super) fn served(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) -> bool {
    if !tried(exchange, context) {
        return false;
    }
    let Some((actual, reason)) = refusal(exchange) else { return true };
    let way =
        exchange.tried(context.rule).and_then(|how| how.split(": ").next()).filter(|way| !way.is_empty());
    context.violation(way.unwrap_or(actual), exchange.record.location, || {
        Detail::new(match reason {
            Some(reason) => format!("refused: {}", body::quoted(reason)),
            None => "refused".to_owned(),
        })
        .expected("what was asked for")
        .actual(actual)
    });
    false
}

/// The kind of a refusal, and the reason that it gives.
fn refusal<'t>(exchange: &Exchange<'t>) -> Option<(&'static str, Option<&'t str>)> {
    if exchange.type_name == Some("ACK-NAK") {
        return Some(("ACK-NAK", exchange.field("reason").and_then(Tree::as_str)));
    }
    let error =
        exchange.message()?.get("error").filter(|error| **error != Tree::Null && exchange.body.is_none())?;
    Some(("an error", error.get("message").and_then(Tree::as_str)))
}

/// Checks that the response to a request that tries the rule names the requested object in `error`. Other rules report
/// objects that the response doesn't have at all.
pub(super) fn in_error(exchange: &Exchange<'_>, context: &mut RuleContext<'_>, types: &[&str]) {
    if !served(exchange, context) {
        return;
    }
    let Some((request, parts)) = reply::replied(exchange, types) else { return };
    let listed_in = |object: &str, part: &str| reply::named(exchange, part).any(|other| other == object);
    let is_ordered = |object: &String| parts.iter().any(|part| listed_in(object, part));
    let wrong = request.first().filter(|_| request.iter().all(is_ordered));
    if let Some(object) = wrong.filter(|_| !request.iter().any(|object| listed_in(object, "error"))) {
        exchange.violates(context, || {
            Detail::new(format!("{} has no entry in `error`", body::quoted(object)))
                .at("/body")
                .expected("an entry in `error`")
                .actual("none")
        });
    }
}
