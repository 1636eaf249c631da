//! `FW-ENV-02J`.

use serde_json::json;

use super::{
    Bug, Check, Detail, FlockwaveRule, Level, Message, Mutant, Rule, RuleContext, Status, Tree, body, mutant,
    source,
};

pub(super) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-02J",
        level: Level::Should,
        status: Status::Advisory,
        statement: "`$fw.version` of a message is one to three numbers with dots between them.",
        source: source::SCHEMA,
        applies_to: "messages of the server",
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Message(check)],
    covers: &[],
    bug: Bug::message("The version of the protocol is a word.", |out| {
        out.message()["$fw.version"] = json!("newest");
    }),
    trial: None,
    mutants: &[
        Mutant {
            name: "a word for the version",
            make: || mutant::reply_message("SYS-VER", |message| message["$fw.version"] = "first".into()),
            also: &[],
        },
        Mutant {
            name: "four numbers",
            make: || mutant::reply_message("SYS-VER", |message| message["$fw.version"] = "1.0.0.0".into()),
            also: &[],
        },
    ],
};

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let version = message.value.get("$fw.version").and_then(Tree::as_str);
    let Some(version) = version else { return };
    context.covered();
    if !body::is_version(version) {
        message.violates(context, || {
            Detail::differs("one to three numbers with dots between them", body::quoted(version))
                .at("/$fw.version")
        });
    }
}
