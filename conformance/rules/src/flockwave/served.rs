//! Checks that several rules use for trials. Trials are requests from a probe that test a rule, and that a server must
//! serve.
//!
//! Trials are marked in the session. A refused request counts as not served, so trials use only requests that a server
//! has no other reason to refuse.

use super::env_27;
use super::prelude::*;

/// The records that these rules apply to.
pub(super) const APPLIES_TO: &str = "probe requests that test this rule";

/// The trial with the first request of a probe: the server must respond, but may demand a login.
pub const BEFORE_LOGIN: &str = "before the login";

/// The prefix of the reason why a UDP connection ended, if no server listens on the port.
const REFUSED_DATAGRAM: &str = "connection refused";

/// The name of the mutant without a response.
pub(super) const UNANSWERED: &str = "no response";

/// The name of the mutant without a connection.
pub(super) const NO_CONNECTION: &str = "no connection";

/// Checks that the server serves a request that tests the rule.
pub(super) fn check(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    served(exchange, context);
}

/// The mutants of a rule that only requires the server to serve a request. They use a connection such as `tcp#9`.
pub(super) const fn mutants(connection: &'static str) -> [Mutant; 3] {
    [
        Mutant::unanswered(UNANSWERED, connection),
        Mutant::refused("a refused request", connection),
        Mutant::no_connection(NO_CONNECTION),
    ]
}

/// True if this is the response to a request that tests the rule. Reports a violation if there is no response or no
/// connection. A missing response is not reported if the session does not contain the end of the connection, or if
/// messages may be lost.
pub(super) fn tried(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) -> bool {
    tried_as(context.rule, exchange, context, |detail| detail)
}

/// Like [`tried`], for a request that may test another rule. `complete` changes the details of the violation.
pub(super) fn tried_as(
    tested: &Rule,
    exchange: &Exchange<'_>,
    context: &mut RuleContext<'_>,
    complete: impl FnOnce(Detail) -> Detail,
) -> bool {
    let Some(how) = exchange.tried(tested) else { return false };
    if exchange.role == Role::Response {
        context.covered();
        return true;
    }
    if let Some(problem) = problem(exchange, tested) {
        context.covered();
        unserved(exchange, context, (problem, how), complete);
    }
    false
}

/// The reason why a request that tests a rule was not served.
pub(super) fn problem(exchange: &Exchange<'_>, tested: &Rule) -> Option<&'static str> {
    exchange.tried(tested)?;
    match exchange.role {
        Role::Unanswered if is_over(exchange, tested) => Some("no response"),
        Role::Event if exchange.record.text == "refused" => Some("no connection"),
        _ => None,
    }
}

/// True if the session is complete enough that any response would appear in it. Over UDP, a missing response proves
/// only that the service ended, and only if the system reports that no server listens.
fn is_over(exchange: &Exchange<'_>, tested: &Rule) -> bool {
    let has_no_server = |note: &str| tested.id == env_27::RULE.rule.id && note.starts_with(REFUSED_DATAGRAM);
    exchange.record.note.is_some_and(|note| !exchange.record.connection.is_lossy || has_no_server(note))
}

/// Reports a trial without a response or without a connection. The subject of the finding is the part of `how` before
/// the first colon, so similar trials are grouped.
fn unserved(
    exchange: &Exchange<'_>,
    context: &mut RuleContext<'_>,
    (problem, how): (&str, &str),
    complete: impl FnOnce(Detail) -> Detail,
) {
    let type_name = exchange.request.as_ref().and_then(|request| request.type_name.as_deref());
    let how = if how == BEFORE_LOGIN { "" } else { how };
    let (group, kind) = how.split_once(": ").unwrap_or((how, ""));
    let subject = if group.is_empty() { type_name.unwrap_or("message") } else { group };
    context.violation(subject, exchange.record.location, || {
        let cause = match exchange.record.note {
            // The client closed the connection.
            None | Some("client") => String::new(),
            Some("eof") => "; the server closed the connection".to_owned(),
            Some(note) => format!("; {}", body::quoted(note)),
        };
        let request = type_name.map_or_else(String::new, |name| format!(" to {}", body::quoted(name)));
        let kind = if kind.is_empty() { String::new() } else { format!(" ({kind})") };
        complete(
            Detail::new(format!("{problem}{request}{kind}{cause}")).expected("a response").actual("none"),
        )
    });
}

/// True if this is the response to a request that tests the rule, and the response is not a refusal. Reports a refusal
/// as a violation.
pub(super) fn served(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) -> bool {
    if !tried(exchange, context) {
        return false;
    }
    let Some((actual, reason)) = refusal(exchange) else { return true };
    if exchange.tried(context.rule) == Some(BEFORE_LOGIN) {
        return false;
    }
    let group =
        exchange.tried(context.rule).and_then(|how| how.split(": ").next()).filter(|group| !group.is_empty());
    context.violation(group.unwrap_or(actual), exchange.record.location, || {
        Detail::new(match reason {
            Some(reason) => format!("refused: {}", body::quoted(reason)),
            None => "refused".to_owned(),
        })
        .expected("a successful response")
        .actual(actual)
    });
    false
}

/// The kind of a refusal, and its reason.
pub(super) fn refusal<'t>(exchange: &Exchange<'t>) -> Option<(&'static str, Option<&'t str>)> {
    if exchange.type_name == Some("ACK-NAK") {
        return Some(("ACK-NAK", exchange.field("reason").and_then(Tree::as_str)));
    }
    let error =
        exchange.message()?.get("error").filter(|error| **error != Tree::Null && exchange.body.is_none())?;
    Some(("an error", error.get("message").and_then(Tree::as_str)))
}

/// Checks the response to a request that tests the rule: the response must list the requested object in `error`. Other
/// rules report a response that omits the object.
pub(super) fn in_error(exchange: &Exchange<'_>, context: &mut RuleContext<'_>, types: &[&str]) {
    if !served(exchange, context) {
        return;
    }
    let Some((request, parts)) = reply::replied(exchange, types) else { return };
    let listed_in = |object: &str, part: &str| reply::named(exchange, part).any(|other| other == object);
    let is_listed = |object: &String| parts.iter().any(|part| listed_in(object, part));
    let wrong = request.first().filter(|_| request.iter().all(is_listed));
    if let Some(object) = wrong.filter(|_| !request.iter().any(|object| listed_in(object, "error"))) {
        exchange.violates(context, || {
            Detail::new(format!("{} has no entry in `error`", body::quoted(object)))
                .at("/body")
                .expected("an entry in `error`")
                .actual("none")
        });
    }
}
