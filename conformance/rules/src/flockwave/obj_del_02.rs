//! `FW-OBJ-DEL-02`.

use uavspec_flockwave::limits::MAX_ID;
use uavspec_flockwave::session::remembered::ById;

use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-OBJ-DEL-02",
    name: "Deleted objects stay deleted",
    level: Level::Info,
    status: Status::Advisory,
    statement: "Once OBJ-DEL has reported an object as deleted, no list contains the object until the \
                server reports its state again.",
    source: source::DERIVED,
    applies_to: "OBJ-DEL, OBJ-LIST and UAV-LIST over time",
    why: "Clients remove the object after OBJ-DEL. If the object appears in the next list, the operator \
          sees a UAV that does not exist.",
    example: r#"← {"type":"OBJ-DEL","ids":["uav-2"]}
→ {"type":"OBJ-LIST"}
← {"type":"OBJ-LIST","ids":["uav-1","uav-2"]}"#,
    fix: "Remove the object from the registry before you send OBJ-DEL, and build OBJ-LIST and UAV-LIST \
          from the same registry.",
})
.checks(&[Check::Session(|| Box::new(Gone::default()))])
.bug(Bug::behaviour("Deleted objects stay in the lists."))
.mutants(&[Mutant::session("a deleted object is listed again", |session| {
    session.exchange(json!({ "type": "OBJ-LIST" }), json!({ "ids": ["kite", "swift", "vane"] }));
})]);

/// The memory limit, in bytes.
const MEMORY_LIMIT: usize = 1 << 20;

/// The deleted objects, by connection and id.
struct Gone(ById<()>);

impl Default for Gone {
    fn default() -> Self {
        Self(ById::new(MEMORY_LIMIT))
    }
}

impl SessionCheck for Gone {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if !exchange.is_from_server() || !exchange.record.connection.is_ordered {
            return;
        }
        for (id, _) in body::members(exchange.body, "status") {
            self.0.remove(&(exchange.serial, id.to_string()));
        }
        let ids = match exchange.field("ids") {
            Some(Tree::List(ids)) => ids.iter().filter_map(Tree::as_str).filter(|id| id.len() <= MAX_ID),
            _ => return,
        };
        match exchange.type_name {
            Some("OBJ-DEL") => {
                ids.for_each(|id| self.0.insert((exchange.serial, id.to_owned()), (), id.len()));
            }
            Some("OBJ-LIST" | "UAV-LIST") => {
                context.covered();
                let mut ids = ids;
                if let Some(id) = ids.find(|id| self.0.contains(&(exchange.serial, id.to_string()))) {
                    exchange.violates(context, || {
                        Detail::new(format!("{} is listed although it was deleted", body::quoted(id)))
                            .at("/body/ids")
                    });
                }
            }
            _ => {}
        }
    }

    fn status_report(&mut self, report: &StatusReport<'_>, _: &mut RuleContext<'_>) {
        if report.connection().is_ordered {
            for (id, _) in report.timestamps() {
                self.0.remove(&(report.connection_id().serial, id.to_owned()));
            }
        }
    }

    fn corruption(&mut self, _: Location) {
        self.0.clear();
    }
}
