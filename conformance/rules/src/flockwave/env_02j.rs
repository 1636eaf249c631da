//! `FW-ENV-02J`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-02J",
    name: "Form of the version",
    level: Level::Should,
    status: Status::Advisory,
    statement: "The `$fw.version` of a message is one to three numbers separated by dots.",
    source: source::SCHEMA,
    applies_to: "messages from the server",
    why: "Clients compare the numbers of a version one by one. Clients may reject a message whose version \
          they cannot parse.",
    example: r#"{"$fw.version":"v1","id":"s1","body":{"type":"OBJ-DEL","ids":["uav-1"]}}"#,
    fix: "Send a version such as `1.0`, without a prefix or suffix.",
})
.checks(&[Check::Message(check)])
.bug(Bug::message("The protocol version is a word.", |out| out.message()["$fw.version"] = json!("newest")))
.mutants(&[
    Mutant::reply_message("a version that is a word", "SYS-VER", |message| {
        message["$fw.version"] = "first".into();
    }),
    Mutant::reply_message("a version with four numbers", "SYS-VER", |message| {
        message["$fw.version"] = "1.0.0.0".into();
    }),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let version = message.value.get("$fw.version").and_then(Tree::as_str);
    let Some(version) = version else { return };
    context.covered();
    if !body::is_version(version) {
        message.violates(context, || {
            Detail::differs("one to three numbers separated by dots", body::quoted(version))
                .at("/$fw.version")
        });
    }
}
