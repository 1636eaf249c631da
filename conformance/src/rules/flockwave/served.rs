//! The parts that rules on requests share that a server has to serve, whatever precedes them and however they arrive.
//!
//! These rules are covered only by trials, which the session marks. A refused request isn't served either, so no trial
//! uses a request that a server may refuse for other reasons.

use super::{Rule, RuleContext, fw};
use crate::flockwave::session::Exchange;

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
    fw::served(exchange, context);
}

/// The session of which a connection that tries the rule doesn't come about.
pub(super) fn no_connection(rule: &Rule) -> Option<Vec<u8>> {
    fw::then(|session| session.refused(rule, "no connection", "Nobody is there"))
}
