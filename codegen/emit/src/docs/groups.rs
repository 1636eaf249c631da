//! Tables that are split by group.

use uavspec_schema::translation::MessageText;

use super::language::{heading, marked};
use super::markdown::{Page, Table, gist, inline};
use super::scope::Scope;
use super::words;

/// Maximum length of a group heading, in characters. A longer heading is shortened, and the full text follows it.
const MAX_HEADING: usize = 100;

/// Writes a table in parts: consecutive rows in the same group form one part.
pub(super) fn in_groups(
    page: &mut Page,
    scope: Scope<'_, '_>,
    table: Table,
    groups: &[Option<usize>],
    level: usize,
) {
    let runs: Vec<&[Option<usize>]> = groups.chunk_by(|left, right| left == right).collect();
    let tables = table.split(runs.iter().map(|run| run.len()));
    for (index, (run, table)) in runs.iter().zip(tables).enumerate() {
        match run[0] {
            Some(group) => group_heading(page, scope, group, level),
            None if index > 0 => heading(page, scope.site.words, level, words::OTHERS),
            None => {}
        }
        page.table(&table);
    }
}

fn group_heading(page: &mut Page, scope: Scope<'_, '_>, group: usize, level: usize) {
    let summary = scope.site.localized_of(scope.message, MessageText::Group(group));
    let heading = marked(&inline(&heading_text(summary.text)), summary.tag);
    if scope.site.language.is_some() {
        let english = MessageText::Group(group).of(scope.site.schema.message(scope.message));
        page.heading_for(level, &heading, &heading_text(english));
    } else {
        page.heading(level, &heading);
    }
    if summary.text.chars().count() > MAX_HEADING {
        page.block(&scope.block_of(MessageText::Group(group)));
    }
    page.block(&scope.block_of(MessageText::GroupDescription(group)));
}

/// The heading of a group, shortened if necessary.
fn heading_text(text: &str) -> String {
    let short = if text.chars().count() <= MAX_HEADING { text.to_owned() } else { gist(text, MAX_HEADING) };
    short.trim_end_matches(['.', ':']).to_owned()
}
