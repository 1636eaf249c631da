//! `FW-ENV-25`.
//!
//! The specification allows responses in any order. However, most clients only ever receive responses in request order,
//! so a different order is worth reporting. `FW-ENV-07` reports unanswered requests.

use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-25",
    name: "Order of responses",
    level: Level::Info,
    status: Status::Advisory,
    statement: "Requests that are sent together are answered in the order in which they were sent.",
    source: source::DERIVED,
    applies_to: "probe requests that test this rule",
    why: "The specification allows any order, but many clients were only ever tested with responses in \
          order. A client that matches responses by position assigns them to the wrong requests.",
    example: r#"→ {"type":"SYS-VER"}
→ {"type":"CONN-LIST"}
← {"type":"CONN-LIST","ids":[]}
← {"type":"SYS-VER","software":"Example","version":"1.0"}"#,
    fix: "In a server, answer in order if this requires no extra work. In a client, match responses by \
          `refs`, never by order.",
})
.checks(&[Check::Session(|| Box::new(Order::default()))])
.bug(
    Bug::behaviour("Over TCP, requests that arrive together are answered in reverse order.")
        .needs(Needs::Tcp),
)
.trial(Trial::Attempts(Strain::Sound, attempts))
.mutants(&[Mutant::connection("the last request is answered first", "tcp#9", |session| {
    session.pipelines(&RULE.rule, &[2, 0, 1]);
})]);

/// The order of responses, by connection.
#[derive(Default)]
struct Order(PerConnection<Answered>);

/// The answered requests of a connection.
#[derive(Default)]
struct Answered {
    /// The location of the answered request that was sent last.
    latest: Option<Location>,
    is_reported: bool,
}

impl SessionCheck for Order {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        let is_response = exchange.role == Role::Response && exchange.record.connection.is_ordered;
        let Some(request) =
            exchange.request.as_ref().filter(|_| is_response && exchange.tried(&RULE.rule).is_some())
        else {
            return;
        };
        context.covered();
        let answered = self.0.get(exchange);
        let later = answered.latest.filter(|latest| *latest > request.location);
        if let Some(later) = later.filter(|_| !answered.is_reported) {
            exchange.violates(context, || {
                Detail::new(format!(
                    "the request in {later} was answered before the earlier request in {}",
                    request.location
                ))
                .at("/refs")
            });
            answered.is_reported = true;
        }
        answered.latest = answered.latest.max(Some(request.location));
    }
}

/// An attempt that sends several requests together. Empty for transports that don't guarantee the order.
fn attempts(endpoint: &Endpoint) -> Vec<Attempt> {
    if !matches!(endpoint, Endpoint::Tcp(_) | Endpoint::SocketIo { .. }) {
        return Vec::new();
    }
    let kinds =
        ["SYS-VER", "SYS-TIME", "UAV-LIST", "SYS-PORTS", "CONN-LIST", "OBJ-LIST", "SYS-VER", "SYS-TIME"];
    let requests = kinds.iter().enumerate().map(|(at, kind)| Sent::request(&format!("together-{at}"), kind));
    vec![Attempt::new("", [Step::Together(requests.collect())])]
}
