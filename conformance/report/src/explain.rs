//! Explains words: error codes, topics, messages, fields, values, constants, hashes and rules.
//!
//! The definitions of all releases are read only for words that need them: error codes and rules don't.

mod annotation;
mod answer;
mod catalogue;
mod constant;
mod error_code;
mod field;
mod hash;
mod history;
mod message;
mod presence;
mod suggestion;
mod target;
#[cfg(test)]
mod tests;
mod text;
mod value;

use uavspec_rules::definitions::{Library, ReleaseId};
use uavspec_rules::rule;

pub(crate) use self::answer::{Answer, Explanation};
use self::answer::{Candidates, Field};
pub use self::history::History;
pub use self::text::to_text;
use crate::explain::catalogue::Catalogue;
use crate::explain::target::{Place, Target};
use crate::rule_list;

/// The maximum length of a word, in bytes. Longer texts can't be names.
pub(crate) const MAX_WORD: usize = 200;

/// The maximum number of candidate fields that are searched for the only one that can have a value.
const MAX_COMPARED: usize = 8;

/// A word that can't be explained.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unknown {
    /// The problem.
    pub problem: String,
    /// A hint, such as a similar name.
    pub help: String,
}

/// Explains a word based on the definitions and all releases, or on one release. The most specific answer comes first.
pub fn explain(library: &Library, word: &str, release: Option<ReleaseId>) -> Result<Explanation, Unknown> {
    let word = word.trim();
    if word.is_empty() || word.len() > MAX_WORD {
        return Err(suggestion::not_a_word());
    }
    let catalogue = Catalogue::new(library, release);
    let answers = answers(&catalogue, word)?;
    if answers.is_empty() {
        return Err(suggestion::unknown(&catalogue, word));
    }
    Ok(Explanation { word: word.to_owned(), answers })
}

fn answers(catalogue: &Catalogue<'_>, word: &str) -> Result<Vec<Answer>, Unknown> {
    if let Some(rule) = rule(&word.to_ascii_uppercase()) {
        return Ok(vec![Answer::Rule(Box::new(rule_list::entry(rule)))]);
    }
    if let Some((target, value)) = word.split_once('=') {
        return about_value(catalogue, target.trim(), value.trim());
    }
    if let Ok(code) = word.parse::<u32>()
        && !hash::is_message_hash(word)
    {
        return Ok(vec![Answer::ErrorCode(error_code::numbered(&catalogue.library().base().schema, code))]);
    }
    let mut answers: Vec<Answer> = hash::find(catalogue, word).into_iter().map(Answer::Hash).collect();
    if answers.is_empty() {
        let codes = error_code::abbreviated(&catalogue.library().base().schema, word);
        answers.extend(codes.into_iter().map(Answer::ErrorCode));
    }
    answers.extend(about_name(catalogue, word));
    Ok(answers)
}

/// Explains the values of fields.
fn about_value(catalogue: &Catalogue<'_>, target: &str, value: &str) -> Result<Vec<Answer>, Unknown> {
    let mut answers = Vec::new();
    for found in target::find(catalogue, target) {
        match found {
            Target::Field(place) => answers.push(Answer::Field(Box::new(asked(catalogue, &place, value)?))),
            Target::Several(candidates) => answers.push(only_possible(catalogue, candidates, value)),
            Target::Message(_) | Target::Constant(..) => {}
        }
    }
    Ok(answers)
}

/// Explains a value of a field.
fn asked(catalogue: &Catalogue<'_>, place: &Place, value: &str) -> Result<Field, Unknown> {
    let mut field = field::explain(catalogue, place);
    field.asked = Some(value::explain(catalogue, place, &field, value)?);
    Ok(field)
}

/// Explains the field that can have the value, if exactly one of the candidates can. Otherwise, lists the candidates.
fn only_possible(catalogue: &Catalogue<'_>, candidates: Candidates, value: &str) -> Answer {
    let paths = candidates.candidates.iter().filter(|_| candidates.candidates.len() <= MAX_COMPARED);
    let found = paths.flat_map(|path| target::find(catalogue, path));
    let fields = found.filter_map(|found| match found {
        Target::Field(place) => asked(catalogue, &place, value).ok(),
        Target::Message(_) | Target::Constant(..) | Target::Several(_) => None,
    });
    let mut possible: Vec<Field> = fields.filter(value::is_possible).collect();
    match possible.pop() {
        Some(field) if possible.is_empty() => Answer::Field(Box::new(field)),
        _ => Answer::Candidates(candidates),
    }
}

/// Explains topics, messages, fields and constants.
fn about_name(catalogue: &Catalogue<'_>, word: &str) -> Vec<Answer> {
    let answer = |found: Target| match found {
        Target::Field(place) => Answer::Field(Box::new(field::explain(catalogue, &place))),
        Target::Constant(place, others) => {
            Answer::Constant(Box::new(constant::explain(catalogue, &place, others)))
        }
        Target::Message(definition) => Answer::Message(Box::new(message::explain(catalogue, &definition))),
        Target::Several(candidates) => Answer::Candidates(candidates),
    };
    target::find(catalogue, word).into_iter().map(answer).collect()
}
