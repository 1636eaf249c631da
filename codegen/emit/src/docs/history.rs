//! The section about the history of a definition.

use uavspec_lint::release::Step;
use uavspec_schema::translation::SOURCE_LANGUAGE;

use super::language::{heading, marked};
use super::markdown::{Page, Table, code, number_column, text_column, with_code};
use super::site::Site;
use super::words::{self, Words};

/// Writes the history section of a definition. `name` is the full ROS name.
pub(super) fn write(page: &mut Page, site: &Site<'_>, name: &str, type_hash: Option<&str>) {
    let (Some(steps), words) = (site.histories.get(name), site.words) else { return };
    heading(page, words, 2, words::HISTORY);
    let equal =
        steps.iter().filter(|step| step.type_hash.is_some() && step.type_hash.as_deref() == type_hash);
    let equal: Vec<String> = equal.map(|step| code(&step.release)).collect();
    page.block(&match equal.as_slice() {
        [] => words.get(words::FIELDS_OF_NO_RELEASE).to_owned(),
        _ => words.fill(words::FIELDS_OF_RELEASES, &[("releases", &equal.join(", "))]),
    });
    page.table(&table(steps, words));
}

/// One row for each release that contains or changes the definition.
fn table(steps: &[Step], words: Words) -> Table {
    let columns = [
        text_column(words.get(words::RELEASE)),
        number_column(words.get(words::MESSAGE_VERSION)),
        text_column(words.get(words::CHANGES)),
    ];
    let mut table = Table::new(&columns);
    // The changes are in English on all pages.
    let tag = Some(SOURCE_LANGUAGE).filter(|_| !words.are_english());
    for (at, step) in steps.iter().enumerate() {
        let changes: Vec<String> =
            step.changes.iter().map(|change| marked(&with_code(&change.message), tag)).collect();
        let changes = match (changes.is_empty(), step.name.is_some()) {
            (true, false) => continue,
            (true, true) if at == 0 => words.get(words::OLDEST_RELEASE).to_owned(),
            (true, true) => words.get(words::NO_CHANGES).to_owned(),
            (false, _) => changes.join("<br>"),
        };
        let version = step.version.map(|version| version.to_string()).unwrap_or_default();
        table.row([code(&step.release), version, changes]);
    }
    table
}
