//! `FW-ENV-02J`.

use serde_json::json;

use super::{
    Bug, Check, Detail, Exchange, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status, Tree, fw,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-02J",
        level: Level::Should,
        status: Status::Advisory,
        statement: "`$fw.version` of a message is one to three numbers with dots between them.",
        source: fw::SCHEMA,
        applies_to: "messages of the server",
    },
    check: Check::Exchange(judge),
    covers: &[],
    bug: Bug::message("The version of the protocol is a word.", |out| {
        out.message()["$fw.version"] = json!("newest");
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "a word for the version",
            make: || fw::reply_message("SYS-VER", |message| message["$fw.version"] = "first".into()),
            also: &[],
        },
        Mutant {
            name: "four numbers",
            make: || fw::reply_message("SYS-VER", |message| message["$fw.version"] = "1.0.0.0".into()),
            also: &[],
        },
    ],
};

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>) {
    let version = exchange.message().and_then(|message| message.get("$fw.version")).and_then(Tree::as_str);
    let Some(version) = version else { return };
    context.covered();
    if !fw::is_version(version) {
        exchange.breaks(context, || {
            Detail::differs("one to three numbers with dots between them", fw::quoted(version))
                .at("/$fw.version")
        });
    }
}
