//! Facts about the quantity in a field, taken from its comment and its name.

use std::sync::LazyLock;

use regex_lite::Regex;
use uavspec_schema::msg::ast::Shape;
use uavspec_schema::msg::constraint::{RANGE, Stated};
use uavspec_schema::value::Value;
use uavspec_schema::{Field, Message, unit};

/// Adjectives for numbers without a unit. These words apply anywhere in the comment.
const ADJECTIVES: [&str; 4] = ["normalized", "normalised", "unitless", "dimensionless"];

/// Nouns for numbers without a unit. These words apply in the head of the comment, and as a word of the name.
const NOUNS: [&str; 7] =
    ["ratio", "fraction", "factor", "probability", "multiplier", "weighting", "quaternion"];

/// Further nouns, which apply only in the head of the comment: `index of the sensor`.
const HEAD_NOUNS: [&str; 3] = ["index", "counter", "dilution"];

/// Words in the names of fields whose unit depends on another field or on the program, such as a parameter's value.
const CONTAINERS: [&str; 4] = ["value", "values", "val", "param"];

/// Names of units at the end of field names: `rate_hz`. Other units have symbols that are also ordinary words or
/// abbreviations, such as `min`.
const SUFFIXES: [&str; 8] = ["hz", "ms", "us", "usec", "sec", "deg", "rad", "rpm"];

/// An interval of normalised values: `[-1, 1]`, `[0-1]`, `-1..1` or `0 to 1`.
static INTERVAL: LazyLock<Option<Regex>> = LazyLock::new(|| {
    let (low, high) = (r"(0|-1)(\.0*)?", r"\+?1(\.0*)?");
    let bracketed = format!(r"[\[(]\s*{low}\s*(,|-)\s*{high}\s*[\])]");
    let bare = format!(r"(^|[^0-9.])({low})\s*(\.\.|to\s)\s*{high}($|[^0-9.a-zA-Z*^])");
    Regex::new(&format!("{bracketed}|{bare}")).ok()
});

/// The groups of a message.
pub(super) struct Groups {
    /// For each group, true if its comment describes plain numbers.
    are_plain: Vec<bool>,
}

impl Groups {
    pub(super) fn new(message: &Message) -> Self {
        Self { are_plain: message.groups.iter().map(|docs| is_plain(&docs.text())).collect() }
    }

    /// True if the comment of the field's group describes plain numbers.
    fn is_plain(&self, field: &Field) -> bool {
        field.group.and_then(|group| self.are_plain.get(group)) == Some(&true)
    }
}

/// True if a text describes plain numbers.
fn is_plain(text: &str) -> bool {
    words(text).any(|word| is_one_of(word, &ADJECTIVES))
        || text.contains('1') && INTERVAL.as_ref().is_some_and(|interval| interval.is_match(text))
}

/// True if the values of a field are plain numbers, such as ratios, quaternions or values from -1 to 1. A unit in the
/// comment takes precedence: a `signal to noise ratio in units of dB` has a unit.
pub(super) fn is_dimensionless(field: &Field, groups: &Groups) -> bool {
    if let Some((symbol, _)) = stated_unit(field) {
        return [unit::NONE, "norm"].contains(&symbol);
    }
    has_normalised_range(field)
        || is_plain(&field.description)
        || groups.is_plain(field)
        || words(head(&field.description)).any(|word| is_one_of(word, &NOUNS) || is_one_of(word, &HEAD_NOUNS))
        || name_words(field).any(|word| is_one_of(word, &NOUNS) || is_one_of(word, &ADJECTIVES))
        || is_quaternion(field)
}

/// True if a field can hold any quantity, such as the value of a parameter or of a debug message.
pub(super) fn is_container(field: &Field) -> bool {
    let is_generic = field.name == "data" || name_words(field).any(|word| is_one_of(word, &CONTAINERS));
    is_generic && stated_unit(field).is_none()
}

/// The words of a field's name, without numbers at their ends.
pub(super) fn name_words(field: &Field) -> impl Iterator<Item = &str> {
    field.name.split('_').map(|word| word.trim_end_matches(|character: char| character.is_ascii_digit()))
}

/// True if the field has a range from 0 or -1 to 1.
fn has_normalised_range(field: &Field) -> bool {
    let Some(Stated::Range(range)) = field.constraint(&RANGE).map(|found| &found.stated) else {
        return false;
    };
    let is = |bound: &Option<Value>, number: f64| bound.as_ref().and_then(Value::as_f64) == Some(number);
    is(&range.high, 1.0) && (is(&range.low, 0.0) || is(&range.low, -1.0))
}

/// True for `q`, `q_d` and similar names of four numbers.
fn is_quaternion(field: &Field) -> bool {
    field.ty.shape == Shape::Array(4) && name_words(field).any(|word| word == "q")
}

/// The part of a comment that names the quantity: `filtered ratio` in `filtered ratio of the error to the limit`.
fn head(text: &str) -> &str {
    let end =
        [" of ", " from ", " for ", ",", "(", ". ", ";", ":"].iter().filter_map(|end| text.find(end)).min();
    &text[..end.unwrap_or(text.len())]
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|character: char| !character.is_alphanumeric()).filter(|word| !word.is_empty())
}

fn is_one_of(word: &str, known: &[&str]) -> bool {
    known.iter().any(|known| word.eq_ignore_ascii_case(known))
}

/// The advice for a field without a unit. `example` is a unit for fields without a unit in their comment and name.
pub(super) fn advice(field: &Field, example: &str) -> String {
    match stated_unit(field) {
        Some((symbol, Some(written))) if written == format!("[{symbol}]") => {
            format!("move `{written}` to the start of the comment")
        }
        Some((symbol, Some(written))) => {
            format!("write `[{symbol}]` at the start of the comment instead of `{written}`")
        }
        Some((symbol, None)) => format!("write `[{symbol}]` at the start of the comment"),
        None => {
            format!("write it at the start of the comment: `# [{example}] …`, or `[-]` for a plain number")
        }
    }
}

/// The unit that a field's comment or name contains outside annotations, and the bracketed text that an annotation
/// would replace. `None` if there are several units.
fn stated_unit(field: &Field) -> Option<(&'static str, Option<&str>)> {
    let text = &field.description;
    let mut found: Vec<(&'static str, Option<&str>)> = bracketed(text).collect();
    found.extend(named(text).map(|symbol| (symbol, None)));
    if found.is_empty() {
        found.extend(suffix(&field.name).map(|symbol| (symbol, None)));
    }
    let first = *found.first()?;
    found.iter().all(|(symbol, _)| *symbol == first.0).then_some(first)
}

/// The units in brackets: `(m/s)`, `[m/s]`, `(in m/s)` or `(rad, [0, 2PI])`.
fn bracketed(text: &str) -> impl Iterator<Item = (&'static str, Option<&str>)> {
    let mut rest = text;
    let groups = std::iter::from_fn(move || {
        let group = &rest[rest.find(['(', '['])?..];
        let end = closing(group)?;
        rest = &group[end..];
        Some(&group[..end])
    });
    groups.filter_map(|group| {
        let inner = &group[1..group.len() - 1];
        let inner = inner.strip_prefix("in ").unwrap_or(inner);
        let first = inner.split(',').next().unwrap_or(inner);
        let written = (first.len() == inner.len()).then_some(group);
        Some((unit::find(first)?, written))
    })
}

/// The position after the bracket that closes the bracket at the start of `text`.
fn closing(text: &str) -> Option<usize> {
    let mut depth = 0_usize;
    for (at, character) in text.char_indices() {
        match character {
            '(' | '[' => depth += 1,
            ')' | ']' => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth == 0 {
            return Some(at + character.len_utf8());
        }
    }
    None
}

/// The units in words: `in metres`, `in units of dB`, `Altitude, meters`, `rad/s (commanded)` or `percentage of …`.
fn named(text: &str) -> impl Iterator<Item = &'static str> {
    let spaced = text.strip_prefix("in ");
    let after_in = spaced.into_iter().chain(text.split(" in ").skip(1)).filter_map(|rest| {
        let rest = rest.strip_prefix("units of ").unwrap_or(rest);
        let mut ends = rest.match_indices(' ').map(|(at, _)| at).chain([rest.len()]);
        let (one, two) = (ends.next()?, ends.next());
        let is_symbol = |text: &str| text.len() > 1 || matches!(text, "m" | "s");
        let find = |end: usize| {
            let text = rest[..end].trim_end_matches([',', '.', ';', ':']);
            is_symbol(text).then(|| unit::find(text)).flatten()
        };
        two.and_then(find).or_else(|| find(one))
    });
    let start = text.split([' ', ',']).next().filter(|start| start.contains('/')).and_then(unit::find);
    let end = text.rsplit_once(", ").and_then(|(_, end)| unit::find(end.trim_end_matches('.')));
    let percent = words(head(text)).any(|word| is_one_of(word, &["percentage", "percent"])).then_some("%");
    after_in.chain(start).chain(end).chain(percent)
}

/// The unit at the end of a name. `noise_per_ms` is not in milliseconds.
fn suffix(name: &str) -> Option<&'static str> {
    let (rest, last) = name.rsplit_once('_')?;
    (SUFFIXES.contains(&last) && !rest.ends_with("per")).then(|| unit::find(last)).flatten()
}
