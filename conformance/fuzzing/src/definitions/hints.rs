//! Hints that follow their grammar, with expressions.

use super::grammar::{self, Table};
use crate::Choices;

/// Possible values of a field: constants, and `$`, which is replaced by an expression.
const VALUES: &[&str] = &[
    "\"$\"",
    "'$'",
    "\"\"\"\n$\"\"\"",
    "\"\\u0020$\"",
    "{ MODE_A = \"MODE_C\", MODE_B = \"MODE_A\" }",
    "{ MODE_B = \"MODE_C\" }",
    "0xffff_ffff_ffff_ffff",
    "-1e400",
    "true",
    "[]",
    "1979-05-27",
];

const MESSAGES: &[&str] = &["\"Glider\"", "\"Tow\"", "\"Absent\"", "\"\"", "7"];

/// Tables of hints. They have different keys, so that many texts have no mistakes.
const TABLES: [Table; 6] = [
    ("[[hint]]", &[("message", MESSAGES), ("new.mode", VALUES), ("old.mode", VALUES), ("new.mask", VALUES)]),
    (
        "[[hint]]",
        &[("message", MESSAGES), ("new.count", VALUES), ("new.is_on", VALUES), ("new.sink", VALUES)],
    ),
    (
        "[[hint]]",
        &[("message", MESSAGES), ("old.list", VALUES), ("old.absent", VALUES), ("old.sink", VALUES)],
    ),
    (
        "[[hint]]",
        &[
            ("message", MESSAGES),
            ("versions", &["[0, 1]", "[-1, 99999999999]", "[0]", "[0, 1, 2]", "\"0\""]),
            (
                "rename",
                &["{ sink = \"count\" }", "{ mode = \"mode\", list = \"absent\" }", "{ sink = 1 }", "[]"],
            ),
            (
                "narrow",
                &[
                    "{ count = \"neutral\", sink = \"nearest\" }",
                    "{ mode = \"nearest\", list = \"neutral\" }",
                    "{ count = \"near\" }",
                ],
            ),
            ("same", &["[\"list\"]", "[\"mode\", \"MODE_B\"]", "[]", "[7]", "\"list\""]),
        ],
    ),
    (
        "[[hint]]",
        &[
            ("old_message", &["\"Tow\"", "\"Glider\""]),
            ("new_message", &["\"Tow\"", "\"Glider\""]),
            ("topic", &["\"tow\"", "\"glider\"", "\"\"", "7"]),
            ("new.a", VALUES),
        ],
    ),
    ("[hint]", &[("message", MESSAGES), ("new", &["{ mode = \"$\" }", "7"])]),
];

const OPERANDS: [&str; 16] = [
    "mode",
    "count",
    "sink",
    "is_on",
    "list",
    "a",
    "0",
    "1",
    "-1.5",
    "~count",
    "(1 + mode)",
    "MODE_A",
    "old.MODE_A",
    "new.MODE_C",
    "nan",
    "true",
];

const OPERATORS: [&str; 14] = ["==", "!=", "<", "<=", ">", ">=", "+", "-", "*", "/", "&", "|", "and", "or"];

/// Tokens for expressions. Most sequences of them are invalid.
const TOKENS: [&str; 14] =
    ["if", "then", "else", "not", "absent", "old.", "(", ")", "^", "~", "0xffffffffff", "1e400", "$", "ä"];

/// A text that the bytes select. The last bytes select the expressions.
pub(super) fn text(data: &[u8]) -> String {
    let reversed: Vec<u8> = data.iter().rev().copied().collect();
    let mut choices = Choices::new(&reversed);
    let text = grammar::text(&TABLES, data);
    let mut parts = text.split('$');
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| text + &expression(&mut choices) + part)
}

/// An expression. It consists of arbitrary tokens, or of alternating operands and operators, which are often valid.
fn expression(choices: &mut Choices<'_>) -> String {
    match choices.below(4) {
        0 | 1 => alternating(choices),
        2 => {
            let [condition, yes, no] = [(); 3].map(|()| alternating(choices));
            format!("if {condition} == 1 then {yes} else {no}")
        }
        _ => {
            let all = [&OPERANDS[..], &OPERATORS, &TOKENS].concat();
            (0..choices.below(12)).map(|_| choices.of(&all)).collect::<Vec<_>>().join(" ")
        }
    }
}

fn alternating(choices: &mut Choices<'_>) -> String {
    let first = choices.of(&OPERANDS).to_owned();
    (0..choices.below(4))
        .fold(first, |text, _| format!("{text} {} {}", choices.of(&OPERATORS), choices.of(&OPERANDS)))
}
