//! `FW-UAV-LIST-03` and `FW-UAV-INF-07`: what UAV-INF says of the UAVs that UAV-LIST lists.
//!
//! UAVs come and go. So UAV-INF fails to know one only where the lists before and after it have that UAV, and nothing has
//! told in between that it is gone. Where an id stands twice in the request, that may be what it fails of, and the other
//! rule tells of it.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::fw::{self, Exchange, PerConnection};
use super::{Check, Checker, Detail, FlockwaveRule, Level, Mutant, Place, Rule, RuleContext, Status};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-LIST-03",
        level: Level::Info,
        status: Status::Advisory,
        statement: "UAV-INF knows each UAV that UAV-LIST lists.",
        source: fw::DERIVED,
        applies_to: "UAV-LIST and UAV-INF over time",
    },
    check: Check::State(|| {
        Box::new(Unknown { is_of_repeated: false, connections: PerConnection::default() })
    }),
    mutants: &[Mutant {
        name: "one that it doesn't know",
        make: || {
            fw::over("tcp#9", |session| {
                doubted(session, |session| {
                    let error = json!({ "error": { "kite": "No such glider" } });
                    session.asks(json!({ "type": "UAV-INF", "ids": ["kite"] }), error);
                });
            })
        },
        also: &[],
    }],
};

/// `FW-UAV-INF-07`.
pub(super) static REPEATED: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UAV-INF-07",
        level: Level::Info,
        status: Status::Advisory,
        statement: "UAV-INF serves a request without ids, and one that has an id twice.",
        source: fw::DERIVED,
        applies_to: "UAV-INF that tries it",
    },
    check: Check::State(|| Box::new(Unknown { is_of_repeated: true, connections: PerConnection::default() })),
    mutants: &[
        Mutant { name: "the request is refused", make: || fw::refused("tcp#9", "FW-UAV-INF-07"), also: &[] },
        Mutant {
            name: "a UAV that is asked for twice isn't known",
            make: || {
                let asked = json!({ "type": "UAV-INF", "ids": ["kite", "kite"] });
                let error = json!({ "type": "UAV-INF", "error": { "kite": "Again" } });
                fw::over("tcp#9", |session| {
                    doubted(session, |session| session.tries_and_hears("FW-UAV-INF-07", "", asked, error));
                })
            },
            also: &[],
        },
    ],
};

/// Between two lists of the same UAVs something is said.
fn doubted(session: &mut fw::Session, say: impl FnOnce(&mut fw::Session)) {
    let list = || -> (Value, Value) { (json!({ "type": "UAV-LIST" }), json!({ "ids": ["kite", "swift"] })) };
    let (request, answer) = list();
    session.asks(request, answer);
    say(session);
    let (request, answer) = list();
    session.asks(request, answer);
}

/// How many UAVs that aren't known are kept of a connection.
const MAX_DOUBTED: usize = 1_000;

/// UAVs that UAV-INF doesn't know, connection by connection.
struct Unknown {
    /// Whether it is about requests that have an id twice, for a trial.
    is_of_repeated: bool,
    connections: PerConnection<Listed>,
}

/// What was told on a connection.
#[derive(Default)]
struct Listed {
    /// The latest list.
    uavs: BTreeSet<String>,
    /// Those of it that UAV-INF hasn't known since, and where it says so.
    doubted: Vec<(String, Place)>,
}

impl Checker for Unknown {
    fn exchanged(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if self.is_of_repeated {
            fw::served(exchange, context);
        }
        if !exchange.is_of_server() || !exchange.record.connection.is_told {
            return;
        }
        if exchange.response("UAV-INF").is_some() {
            return self.inform(exchange, context);
        }
        let list = fw::listed(exchange);
        let listed = self.connections.of(exchange);
        if exchange.notification("OBJ-DEL").is_some() {
            let is_left = |id: &String| list.as_ref().is_some_and(|gone| !gone.contains(id));
            listed.uavs.retain(is_left);
            listed.doubted.retain(|(id, _)| is_left(id));
        } else if let (Some(_), Some(list)) = (exchange.response("UAV-LIST"), list) {
            for (id, place) in listed.doubted.drain(..).filter(|(id, _)| list.contains(id)) {
                context.violation("UAV-INF", place, || {
                    let id = fw::quoted(&id);
                    Detail::new(format!("{id} isn't known, and UAV-LIST has it before and after"))
                        .expected("a state")
                        .actual("an error")
                });
            }
            listed.uavs = list;
        }
    }

    fn damage(&mut self, _: Place) {
        self.connections.clear();
    }
}

impl Unknown {
    /// UAV-INF tells of UAVs.
    fn inform(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        let Some(asked) = exchange.asked_same() else { return };
        let is_repeated = asked.repeated.is_some() && exchange.tried(&REPEATED.rule).is_some();
        if is_repeated != self.is_of_repeated {
            return;
        }
        let listed = self.connections.of(exchange);
        let known = asked.objects.iter().flatten().filter(|id| listed.uavs.contains(*id));
        let unknown = fw::members(exchange, "error");
        for id in known {
            context.covered();
            let is_doubted = unknown.iter().any(|(unknown, _)| unknown == id);
            if is_doubted && listed.doubted.len() < MAX_DOUBTED {
                listed.doubted.push((id.clone(), exchange.record.place));
            }
        }
    }
}
