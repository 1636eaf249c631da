//! Help for words that have no meaning.

use uavspec_lint::release::{entries, full_name};
use uavspec_model::text::{shown, similar};
use uavspec_rules::RULES;

use super::answer::Field;
use super::catalogue::Catalogue;
use super::target::{Place, names};
use super::{MAX_WORD, Unknown, error_code};

/// The help if no name is similar.
const HELP: &str = "name an error code, a topic, a message, a field, a value, a constant, a hash or a rule";

/// The error for a text that isn't a word.
pub(super) fn not_a_word() -> Unknown {
    let problem = format!("expected a word of 1 to {MAX_WORD} bytes");
    Unknown { problem, help: HELP.to_owned() }
}

/// The error for a word without a meaning. Suggests a similar name.
pub(super) fn unknown(catalogue: &Catalogue<'_>, word: &str) -> Unknown {
    let target = word.split_once('=').map_or(word, |(target, _)| target);
    let help = match target.split_once('.') {
        Some((first, rest)) => similar_item(catalogue, first, rest),
        None => similar_name(catalogue, target),
    };
    let help = help.map_or_else(|| HELP.to_owned(), |name| format!("did you mean {name}?"));
    Unknown { problem: format!("{}: unknown", shown(word)), help }
}

/// The error for a value that the field can't have.
pub(super) fn no_value(place: &Place, text: &str, expected: &str) -> Unknown {
    let problem = format!("{}={}: expected {expected}", shown(&place.path), shown(text));
    Unknown { problem, help: format!("run `uavspec explain {}`", shown(&place.path)) }
}

/// The error for a name that isn't one of the field's constants.
pub(super) fn unknown_value(place: &Place, field: &Field, text: &str) -> Unknown {
    let members = field.values.iter().flat_map(|values| &values.members).map(|member| member.name.as_str());
    let prefixes = || field.values.iter().flat_map(|values| &values.prefixes);
    let rest = |name: &'_ str| {
        let mut prefixes = prefixes();
        prefixes.find_map(|prefix| name.strip_prefix(prefix.as_str())?.strip_prefix('_').map(str::to_owned))
    };
    let short: Vec<String> = members.clone().filter_map(rest).collect();
    let known = members.chain(short.iter().map(String::as_str));
    let mut unknown = no_value(place, text, "a number or the name of a constant");
    if let Some(name) = similar(&text.to_ascii_uppercase(), known) {
        unknown.help = format!("did you mean {}={name}?", place.path);
    }
    unknown
}

/// A similar name of any kind.
fn similar_name(catalogue: &Catalogue<'_>, word: &str) -> Option<String> {
    let mut known: Vec<String> = RULES.iter().map(|rule| rule.id.to_owned()).collect();
    let codes = error_code::all(&catalogue.library().base().schema);
    known.extend(codes.filter_map(|code| code.abbreviation.clone()));
    known.extend(definitions(catalogue));
    for release in catalogue.releases() {
        for entry in entries(catalogue.text(release)) {
            known.extend(names(entry.text).map(str::to_owned));
        }
    }
    known.sort_unstable();
    known.dedup();
    similar(word, known.iter().map(String::as_str)).map(str::to_owned)
}

/// A similar path of an item.
fn similar_item(catalogue: &Catalogue<'_>, first: &str, rest: &str) -> Option<String> {
    let known = definitions(catalogue);
    let definition = similar(first, known.iter().map(String::as_str))?;
    let rows = catalogue
        .rows()
        .filter(|row| row.topics.contains(&definition) || row.name.rsplit('/').next() == Some(definition));
    let mut items: Vec<String> = Vec::new();
    for row in rows {
        let Some(release) = catalogue.newest(row.name) else { continue };
        let own = entries(catalogue.text(release)).find(|entry| full_name(entry) == row.name);
        items.extend(own.iter().flat_map(|entry| names(entry.text)).map(str::to_owned));
    }
    let item = similar(rest, items.iter().map(String::as_str))?;
    Some(format!("{definition}.{item}"))
}

/// The names of the definitions and the topics.
fn definitions(catalogue: &Catalogue<'_>) -> Vec<String> {
    let mut known = Vec::new();
    for row in catalogue.rows() {
        known.extend(row.owned_topics());
        known.extend(row.name.rsplit('/').next().map(str::to_owned));
    }
    known.sort_unstable();
    known.dedup();
    known
}
