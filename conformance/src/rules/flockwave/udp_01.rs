//! `FW-UDP-01`.

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Needs, Rule, RuleContext, Status, fw,
};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-UDP-01",
        level: Level::Must,
        status: Status::Normative,
        statement: "Over UDP each datagram holds one message.",
        source: fw::TRANSPORT,
        applies_to: "messages of the server on connections whose name begins with `udp`",
    },
    check: Check::Context(judge),
    covers: &[],
    bug: Bug::behaviour("Over UDP, each notification is twice in its datagram.").needs(Needs::Udp),
    trial: None,
    mutants: &[Mutant {
        name: "two messages in a datagram",
        make: || {
            let message = |id: &str| {
                format!(r#"{{"$fw.version":"1.0","id":"{id}","body":{{"type":"OBJ-DEL","ids":[]}}}}"#)
            };
            fw::over("udp#9", |session| session.says_raw(&["a", "b"].map(message).join("\n")))
        },
        also: &[],
    }],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    if !exchange.is_of_server() || !fw::is_called(exchange, "udp") {
        return;
    }
    context.covered();
    if fw::are_several(exchange, "udp") {
        exchange.breaks(context, || {
            Detail::new("several messages in a datagram").expected("one").actual("more than one")
        });
    }
}
