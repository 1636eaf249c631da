//! `FW-SYS-PORTS-02`.
//!
//! With port forwarding, the port that the client uses differs from the server's port. The level is therefore INFO.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-SYS-PORTS-02",
    name: "Port of this connection",
    level: Level::Info,
    status: Status::Advisory,
    statement: "If SYS-PORTS lists a port for the transport of the current connection, it is the port \
                that this connection uses.",
    source: source::DERIVED,
    applies_to: "SYS-PORTS on connections with a known URL",
    why: "Clients use these ports for further connections. If a port is wrong, the connection fails or \
          reaches a different service.",
    example: r#"(connected to tcp://localhost:5001)
→ {"type":"SYS-PORTS"}
← {"type":"SYS-PORTS","ports":{"tcp":5000}}"#,
    fix: "Read the port from the listening socket instead of the configuration. Ignore this finding if \
          the port is forwarded.",
})
.checks(&[Check::Session(|| Box::new(Used::default()))])
.bug(Bug::message("All port numbers are off by one.", |out| {
    for port in out.ports() {
        let number = port.as_u64().unwrap_or(1);
        *port = json!(if number == 1 { 2 } else { number - 1 });
    }
}))
.mutants(&[Mutant::connection("a different port", "tcp#9", |session| {
    let ports = json!({ "ports": { "tcp": 7004, "udp": 7002 } });
    session.exchange(json!({ "type": "SYS-PORTS" }), ports);
})]);

/// The transport and the port in use, by connection.
#[derive(Default)]
struct Used(PerConnection<Option<(&'static str, u16)>>);

impl SessionCheck for Used {
    fn exchange(&mut self, exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
        if exchange.role == Role::Event && exchange.record.text == "connect" {
            *self.0.get(exchange) = exchange.record.note.and_then(in_use);
            return;
        }
        let Some(body) = exchange.response("SYS-PORTS") else { return };
        let Some((transport, port)) = *self.0.get(exchange) else { return };
        let ports = body.get("ports");
        let Some(listed) = ports.and_then(|ports| ports.get(transport)).and_then(Tree::as_integer) else {
            return;
        };
        context.covered();
        if listed != i128::from(port) {
            exchange.violates(context, || {
                Detail::differs(port, listed).at(pointer(&["body", "ports", transport]))
            });
        }
    }

    fn corruption(&mut self, _: Location) {
        self.0.clear();
    }
}

/// The transport and the port of a URL.
fn in_use(url: &str) -> Option<(&'static str, u16)> {
    let endpoint: Endpoint = url.parse().ok()?;
    // A separate program may provide TLS at a different port.
    if endpoint.address().is_encrypted {
        return None;
    }
    Some(match endpoint {
        Endpoint::Tcp(address) => ("tcp", address.port),
        Endpoint::Udp(address) => ("udp", address.port),
        Endpoint::Http { address, .. } => ("http", address.port),
        Endpoint::SocketIo { address, .. } => ("socketio", address.port),
    })
}
