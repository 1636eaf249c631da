//! `FW-ENV-21`.

use serde_json::json;

use super::{
    Attempt, Bug, Check, FlockwaveRule, Level, Mutant, Rule, Status, Step, Strain, Trial, env_05, env_06,
    mutant, served, source,
};

pub(crate) static RULE: FlockwaveRule = FlockwaveRule {
    rule: Rule {
        id: "FW-ENV-21",
        level: Level::Info,
        status: Status::Advisory,
        statement: "A request whose id is unusual but allowed is answered, and the answer has that id: 36 characters, letters that aren't ASCII, spaces.",
        source: source::DERIVED,
        applies_to: served::APPLIES_TO,
        why: "",
        example: "",
        fix: "",
    },
    checks: &[Check::Exchange(served::check)],
    covers: &[],
    bug: Bug::message("Responses refer to ids without what isn't an ASCII letter, digit, - or _.", |out| {
        if let Some(refs) = out.message()["refs"].as_str() {
            let is_plain = |character: &char| character.is_ascii_alphanumeric() || "-_".contains(*character);
            let plain: String = refs.chars().filter(is_plain).collect();
            out.message()["refs"] = json!(plain);
        }
    })
    .with(&[&env_05::RULE.rule, &env_06::RULE.rule]),
    trial: Some(Trial::Attempts(Strain::Sound, |_| attempts())),
    mutants: &[
        Mutant { name: served::UNANSWERED, make: || mutant::unanswered("tcp#9", &RULE.rule), also: &[] },
        Mutant { name: served::REFUSED, make: || mutant::refused("tcp#9", &RULE.rule), also: &[] },
        Mutant { name: served::NO_CONNECTION, make: || served::no_connection(&RULE.rule), also: &[] },
    ],
};

/// An attempt for each unusual id.
fn attempts() -> Vec<Attempt> {
    let ids = [
        ("an id of 36 characters", "c0ffee00-1234-4abc-9def-0123456789ab"),
        ("an id with spaces", " two words "),
        ("an id that isn't ASCII", "Höhe 高度 \u{1fa82}"),
        ("an id with characters that JSON escapes", "\"\\/\u{7}\t<&>"),
    ];
    ids.map(|(how, id)| Attempt::new(how, [Step::request(id)])).into()
}
