//! `FW-SYS-VER-04`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-SYS-VER-04",
    name: "Constant server version",
    level: Level::Info,
    status: Status::Advisory,
    statement: "On a connection, SYS-VER always returns the same values.",
    source: source::DERIVED,
    applies_to: "SYS-VER over time",
    why: "Clients query the version once and store it. If the version changes, clients use the wrong \
          features for the rest of the connection.",
    example: r#"→ {"type":"SYS-VER"}
← {"type":"SYS-VER","software":"Example","version":"1.0","revision":"b7"}
→ {"type":"SYS-VER"}
← {"type":"SYS-VER","software":"Example","version":"1.0","revision":"b8"}"#,
    fix: "Determine the name, version and revision once at startup. If a load balancer is in use, pin \
          each connection to one server.",
})
.checks(&[Check::Session(|| Box::new(Versions::default()))])
.bug(Bug::message("The `revision` of SYS-VER changes each time.", |out| {
    let revision = format!("revision {}", out.number);
    out.set("SYS-VER", "revision", json!(revision));
}))
.mutants(&[Mutant::connection("a changed revision", "tcp#9", |session| {
    for revision in ["b7", "b8"] {
        let version = json!({ "software": "Windward", "version": "3.1", "revision": revision });
        session.exchange(json!({ "type": "SYS-VER" }), version);
    }
})]);

/// The compared fields.
const FIELDS: [&str; 4] = ["software", "version", "name", "revision"];

/// The number of characters that are compared in each field.
const MAX_TEXT: usize = 256;

/// The values of the latest response, by connection.
#[derive(Default)]
struct Versions(PerConnection<Option<[Option<String>; FIELDS.len()]>>);

impl SessionCheck for Versions {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        let Some(body) = exchange.response("SYS-VER").filter(|_| exchange.record.connection.is_ordered)
        else {
            return;
        };
        let text = |value: &Tree<'_>| match value {
            Tree::Text(text) => text.chars().take(MAX_TEXT).collect(),
            other => other.to_string(),
        };
        let now = FIELDS.map(|field| body.get(field).map(text));
        let Some(before) = self.0.get(exchange).replace(now.clone()) else { return };
        context.covered();
        let changed = FIELDS.iter().zip(before).zip(now).find(|((_, before), now)| before != now);
        if let Some(((field, before), now)) = changed {
            let reported = |value: Option<String>| {
                value.map_or_else(|| "nothing".to_owned(), |text| body::quoted(&text))
            };
            exchange.violates(context, || {
                Detail::differs(reported(before), reported(now)).at(pointer(&["body", field]))
            });
        }
    }

    fn corruption(&mut self, _: Location) {
        self.0.clear();
    }
}
