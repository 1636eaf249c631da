//! `[@invalid value text]` and `[@uncontrolled value text]`: values with a special meaning.

use super::model::{Argument, ConstraintKind, Effect, Stated};
use super::number::parse;
use crate::msg::words::split_word;
use crate::name::is_identifier;

/// The value that represents missing data.
pub static INVALID: ConstraintKind = ConstraintKind {
    name: "invalid",
    form: "[@invalid value]",
    words: "no data",
    keyword: "x-invalid",
    read,
    lay_out,
    effect: Effect::Allows {
        title: "No data",
        sample: ("no-data", "the value that represents missing data"),
    },
};

/// The value for a setpoint that is not controlled.
pub static UNCONTROLLED: ConstraintKind = ConstraintKind {
    name: "uncontrolled",
    form: "[@uncontrolled value]",
    words: "not controlled",
    keyword: "x-uncontrolled",
    read,
    lay_out,
    effect: Effect::Allows {
        title: "Not controlled",
        sample: ("not-controlled", "the value for a setpoint that is not controlled"),
    },
};

fn read(argument: &str) -> Option<(Argument<'_>, &str)> {
    let (word, text) = split_word(argument);
    let value = match parse(word) {
        Ok(number) => Argument::Stated(Stated::Value(number)),
        Err(_) if word.eq_ignore_ascii_case("empty") => Argument::Stated(Stated::Empty),
        Err(_) if is_identifier(word) => Argument::Name(word),
        Err(_) => return None,
    };
    Some((value, text))
}

/// Formats a value and the explanation that follows it. Preserves the spaces in the explanation.
fn lay_out(argument: &str) -> String {
    match split_word(argument) {
        (word, "") => word.to_owned(),
        (word, text) => format!("{word} {text}"),
    }
}
