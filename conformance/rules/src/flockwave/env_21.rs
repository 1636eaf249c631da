//! `FW-ENV-21`.

use super::env_06;
use super::prelude::*;

pub(crate) static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-ENV-21",
    name: "Request ids are returned unchanged",
    level: Level::Info,
    status: Status::Advisory,
    statement: "The `refs` of a response equals the id of the request, even if the id has 36 characters \
                or contains spaces or non-ASCII letters.",
    source: source::DERIVED,
    applies_to: served::APPLIES_TO,
    why: "Unusual ids are valid too. If the server changes an id, the client cannot match the response to \
          its request.",
    example: r#"→ {"$fw.version":"1.0","id":"Höhe 1","body":{"type":"SYS-PING"}}
← {"$fw.version":"1.0","id":"s1","refs":"Hhe1","body":{"type":"ACK-ACK"}}"#,
    fix: "Treat ids as opaque Unicode strings. Do not trim, filter, re-encode or truncate them.",
})
.checks(&[Check::Exchange(served::check)])
.bug(
    Bug::message(
        "All characters except ASCII letters, digits, - and _ are removed from the id in `refs`.",
        |out| {
            if let Some(refs) = out.message()["refs"].as_str() {
                let is_plain =
                    |character: &char| character.is_ascii_alphanumeric() || "-_".contains(*character);
                let plain: String = refs.chars().filter(is_plain).collect();
                out.message()["refs"] = json!(plain);
            }
        },
    )
    .also(&[&env_06::RULE.rule]),
)
.trial(Trial::Attempts(Strain::Sound, |_| attempts()))
.mutants(&served::mutants("tcp#9"));

/// An attempt for each unusual id.
fn attempts() -> Vec<Attempt> {
    let ids = [
        ("a 36-character id", "c0ffee00-1234-4abc-9def-0123456789ab"),
        ("an id with spaces", " two words "),
        ("a non-ASCII id", "Höhe 高度 \u{1fa82}"),
        ("an id with characters that must be escaped in JSON", "\"\\/\u{7}\t<&>"),
    ];
    ids.map(|(how, id)| Attempt::new(how, [Step::request(id)])).into()
}
