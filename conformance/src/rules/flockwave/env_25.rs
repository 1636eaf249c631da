//! `FW-ENV-25`.
//!
//! The specification lets answers come in any order. Most clients never see another than that of their requests, so it is
//! good to know of a server that doesn't keep to it. That a request isn't answered at all is another rule's matter.

use super::{
    Attempt, Bug, Check, Detail, Exchange, FlockwaveRule, Level, Location, Mutant, PerConnection, Role, Rule,
    RuleContext, Sent, SessionCheck, Status, Step, Strain, Trial, mutant, source,
};
use crate::flockwave::transport::endpoint::Endpoint;

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-25",
        level: Level::Info,
        status: Status::Advisory,
        statement: "Answers to requests that are sent at once come in the order of the requests.",
        source: source::DERIVED,
        applies_to: "requests that try it",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Session(|| Box::new(Order::default()))],
    covers: &[],
    bug: Bug::behaviour("Over TCP, requests that come at once are answered from the last to the first."),
    trial: Some(Trial::Attempts(Strain::Sound, attempts)),
    mutants: &[Mutant {
        name: "the last one is answered first",
        make: || mutant::over("tcp#9", |session| session.pipelines(&RULE.rule, &[2, 0, 1])),
        also: &[],
    }],
};

/// The order of answers, connection by connection.
#[derive(Default)]
struct Order(PerConnection<Answered>);

/// What was answered on a connection.
#[derive(Default)]
struct Answered {
    /// Where the request stands that was sent last of those.
    latest: Option<Location>,
    is_reported: bool,
}

impl SessionCheck for Order {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        let is_answer = exchange.role == Role::Response && exchange.record.connection.is_ordered;
        let Some(request) =
            exchange.request.as_ref().filter(|_| is_answer && exchange.tried(&RULE.rule).is_some())
        else {
            return;
        };
        context.covered();
        let answered = self.0.get(exchange);
        let later = answered.latest.filter(|latest| *latest > request.location);
        if let Some(later) = later.filter(|_| !answered.is_reported) {
            exchange.violates(context, || {
                Detail::new(format!(
                    "the request in {later} was answered before that in {}",
                    request.location
                ))
                .at("/refs")
            });
            answered.is_reported = true;
        }
        answered.latest = answered.latest.max(Some(request.location));
    }

    fn corruption(&mut self, _: Location) {
        self.0.clear();
    }
}

/// Many requests in one pass. Over other transports there is no order.
fn attempts(endpoint: &Endpoint) -> Vec<Attempt> {
    if !matches!(endpoint, Endpoint::Tcp(_) | Endpoint::SocketIo { .. }) {
        return Vec::new();
    }
    let kinds =
        ["SYS-VER", "SYS-TIME", "UAV-LIST", "SYS-PORTS", "CONN-LIST", "OBJ-LIST", "SYS-VER", "SYS-TIME"];
    let requests = kinds.iter().enumerate().map(|(at, kind)| Sent::request(&format!("at-once-{at}"), kind));
    vec![Attempt::new("", [Step::Together(requests.collect())])]
}
