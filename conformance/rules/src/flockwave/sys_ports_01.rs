//! `FW-SYS-PORTS-01`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-SYS-PORTS-01",
    name: "Port numbers",
    level: Level::Should,
    status: Status::Disputed(
        "In the specification text, ports are TCP or UDP ports, so the valid range is 1 to 65535. The \
         published JSON Schema allows any number.",
    ),
    statement: "`ports` maps service names to port numbers from 1 to 65535.",
    source: source::MESSAGES,
    applies_to: "SYS-PORTS",
    why: "Clients connect to these ports. If a port is a string or an invalid number, clients cannot \
          reach the service.",
    example: r#"{"type":"SYS-PORTS","ports":{"tcp":"5001"}}"#,
    fix: "Send port numbers as integers, and omit services that are not available.",
})
.checks(&[Check::Message(check)])
.covers(&[Attribution::new(&["SYS-PORTS"], "ports.**", attribution::INVALID)])
.bug(Bug::message("Port numbers are strings.", |out| {
    for port in out.ports() {
        *port = json!(port.to_string());
    }
}))
.mutants(&[
    Mutant::reply("port 0", "SYS-PORTS", |body| body["ports"]["tcp"] = 0.into()),
    Mutant::reply("a list of ports", "SYS-PORTS", |body| body["ports"] = json!([7001])),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    if message.body_of("SYS-PORTS").is_some() {
        body::field(message, context, "ports", true, &ExpectedValue::Map(&ExpectedValue::Integer(1, 65535)));
    }
}
