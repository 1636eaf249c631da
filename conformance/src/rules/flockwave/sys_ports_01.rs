//! `FW-SYS-PORTS-01`.

use serde_json::json;

use super::{
    Attribution, Bug, Check, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Shape, Status,
    attribution, fw,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-SYS-PORTS-01",
        level: Level::Must,
        status: Status::Disputed(
            "A port is one of TCP or UDP by the text, hence from 1 to 65535; the published schema takes any number.",
        ),
        statement: "`ports` maps names to ports, 1 to 65535.",
        source: fw::MESSAGES,
        applies_to: "SYS-PORTS",
    },
    check: Check::Exchange(judge),
    covers: &[Attribution::new(&["SYS-PORTS"], "ports.**", attribution::UNFIT)],
    bug: Bug::message("Ports are texts.", |out| {
        for port in out.ports() {
            *port = json!(port.to_string());
        }
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "port 0",
            make: || fw::reply("SYS-PORTS", |body| body["ports"]["tcp"] = 0.into()),
            also: &[],
        },
        Mutant {
            name: "a list of ports",
            make: || fw::reply("SYS-PORTS", |body| body["ports"] = json!([7001])),
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if exchange.body_of("SYS-PORTS").is_some() {
        fw::field(exchange, context, "ports", true, &Shape::Map(&Shape::Integer(1, 65535)));
    }
}
