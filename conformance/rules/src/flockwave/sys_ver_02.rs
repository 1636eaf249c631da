//! `FW-SYS-VER-02`.

use super::prelude::*;

pub(super) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-SYS-VER-02",
    name: "Form of the server version",
    level: Level::Must,
    status: Status::Normative,
    statement: "`version` is a string of one to three numbers separated by dots.",
    source: source::MESSAGES,
    applies_to: "SYS-VER",
    why: "Clients compare versions number by number to decide which features to use. They cannot compare \
          versions in any other form.",
    example: r#"{"type":"SYS-VER","software":"Example","version":"3.1-rc1"}"#,
    fix: "Send only the numbers in `version`, and move suffixes such as `rc1` to `revision`.",
})
.checks(&[Check::Message(check)])
.covers(&[Attribution::new(&["SYS-VER"], "version", attribution::INVALID)])
.bug(Bug::message("The `version` of SYS-VER is a word.", |out| {
    out.set("SYS-VER", "version", json!("newest"));
}))
.mutants(&[
    Mutant::reply("`version` is a number", "SYS-VER", |body| body["version"] = 3.1.into()),
    Mutant::reply("a suffix after the numbers", "SYS-VER", |body| body["version"] = "3.1-rc".into()),
]);

fn check(message: &Message<'_>, context: &mut RuleContext<'_>) {
    let Some(body) = message.body_of("SYS-VER") else { return };
    context.covered();
    let version = body.get("version");
    if !version.and_then(Tree::as_str).is_some_and(body::is_version) {
        message.violates(context, || {
            let found = version.map_or_else(|| "nothing".to_owned(), ToString::to_string);
            Detail::differs("one to three numbers separated by dots", found).at("/body/version")
        });
    }
}
