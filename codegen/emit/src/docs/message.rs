//! The page of a message.

use uavspec_schema::fingerprint::ros_name;
use uavspec_schema::translation::{MessageText, message_unit};
use uavspec_schema::{CdrSize, MessageId, Package, UorbLayout};

use super::cell::field_link;
use super::constants::{self, Anchored, Constants};
use super::language::{self, Heading, heading};
use super::markdown::{Page, Table, code, href, inline, link, text_column, unbroken};
use super::scope::Scope;
use super::site::Site;
use super::words::{self, Word, Words};
use super::{commands, composer, enums, fields, history, picture};
use crate::file::OutputFile;
use crate::json_schema::Target;

/// Creates the page of a message.
pub(super) fn page(site: &Site<'_>, id: MessageId) -> OutputFile {
    let scope = Scope::of(site, id);
    let message = site.schema.message(id);
    let unit = message_unit(site.schema, message);
    let name = inline(&message.name);
    let heading_of_page = Heading { text: &name, english: &name };
    let mut page = language::page(site, &unit, site.english_path(id), &heading_of_page);
    page.block(&scope.block_of(MessageText::Summary));
    page.block(&scope.block_of(MessageText::Description));
    page.table(&facts(scope, id));
    heading(&mut page, site.words, 2, words::FIELDS);
    fields::write(&mut page, scope, id, 3);
    layout(&mut page, scope, id);
    composer::write(&mut page, site, id);
    values(&mut page, scope, id);
    users(&mut page, scope, id);
    let ros_name = ros_name(site.schema, message);
    history::write(&mut page, site, &ros_name, Some(&message.type_hash));
    page.finish()
}

fn facts(scope: Scope<'_, '_>, id: MessageId) -> Table {
    let message = scope.site.schema.message(id);
    let package = scope.site.schema.package_of(message);
    let words = scope.site.words;
    let mut table = Table::new(&[text_column(""), text_column("")]);
    let mut fact = |name: Word, value: String| {
        if !value.is_empty() {
            table.row([unbroken(words.get(name)), value]);
        }
    };
    let topic = if message.topics.len() == 1 { words::TOPIC } else { words::TOPICS };
    fact(words::PACKAGE, package_cell(words, scope.from, package));
    fact(words::DEFINITION, code(scope.site.source(message.span)));
    fact(topic, topics(&message.topics));
    fact(words::MESSAGE_VERSION, message.version.map(|version| version.to_string()).unwrap_or_default());
    fact(words::QUEUE_LENGTH, message.queue_length.map(|length| length.to_string()).unwrap_or_default());
    let uorb_size = |layout| uorb_size(words, layout);
    fact(words::UORB_SIZE, scope.site.layout(message).map(uorb_size).unwrap_or_default());
    if scope.site.is_px4(message) {
        fact(words::UORB_HASH, code(&format!("{:#010x}", message.hash)));
    }
    fact(words::CDR_SIZE, words.fill(words::WITH_HEADER, &[("size", &cdr_size(words, message.cdr))]));
    fact(words::ROS_TYPE, code(&ros_name(scope.site.schema, message)));
    fact(words::ROS_TYPE_HASH, code(&message.type_hash));
    for (name, file) in scope.site.files(scope.from, Target::Message(id)) {
        table.row([unbroken(name), file]);
    }
    table
}

/// A package with its origin.
pub(super) fn package_cell(words: Words, from: &str, package: &Package) -> String {
    let name = link(&inline(&package.name), &href(from, &format!("{}/README.md", package.name), ""));
    match origin(words, package) {
        Some(origin) => words.fill(words::PACKAGE_FROM, &[("package", &name), ("origin", &origin)]),
        None => name,
    }
}

/// The origin and revision of a package.
pub(super) fn origin(words: Words, package: &Package) -> Option<String> {
    match (&package.origin, &package.revision) {
        (Some(origin), Some(revision)) => {
            let parts = [("origin", inline(origin)), ("revision", code(revision))];
            Some(words.fill(words::ORIGIN_AT, &parts.each_ref().map(|(name, part)| (*name, part.as_str()))))
        }
        (Some(origin), None) => Some(inline(origin)),
        (None, Some(revision)) => Some(code(revision)),
        (None, None) => None,
    }
}

/// Topics, formatted as code.
pub(super) fn topics(topics: &[String]) -> String {
    topics.iter().map(|topic| code(topic)).collect::<Vec<_>>().join(", ")
}

fn uorb_size(words: Words, layout: &UorbLayout) -> String {
    let size = link(&words.bytes(layout.size as u64), "#memory-layout");
    if layout.size == layout.size_no_padding {
        size
    } else {
        let count = layout.size_no_padding.to_string();
        words.fill(words::WITHOUT_PADDING, &[("size", &size), ("count", &count)])
    }
}

/// The size of the CDR payload.
pub(super) fn cdr_size(words: Words, size: CdrSize) -> String {
    let min = words.bytes(size.min);
    if size.is_fixed { min } else { words.fill(words::OR_MORE, &[("size", &min)]) }
}

/// Writes the sections about constants.
fn values(page: &mut Page, scope: Scope<'_, '_>, id: MessageId) {
    let message = scope.site.schema.message(id);
    let words = scope.site.words;
    let constants = Constants::of(message);
    let mut anchored = Anchored::default();
    if !message.enums.is_empty() {
        heading(page, words, 2, words::ENUMS);
        enums::write(page, scope, id, 3, &mut anchored);
    }
    if !constants.commands.is_empty() {
        heading(page, words, 2, words::COMMANDS);
        commands::write(page, scope, id, &constants, &mut anchored);
    }
    if !constants.parameter_enums.is_empty() {
        heading(page, words, 2, words::PARAMETER_VALUES);
        constants::write_parameter_enums(page, scope, id, &constants, &mut anchored);
    }
    if !constants.others.is_empty() {
        heading(page, words, 2, words::CONSTANTS);
        constants::write(page, scope, id, &constants.others, 3, &mut anchored);
    }
}

fn layout(page: &mut Page, scope: Scope<'_, '_>, id: MessageId) {
    let message = scope.site.schema.message(id);
    if scope.site.layout(message).is_some() {
        let words = scope.site.words;
        heading(page, words, 2, words::MEMORY_LAYOUT);
        page.block(words.get(words::MEMORY_LAYOUT_MEANS));
        let text = words.fill(words::MEMORY_LAYOUT_OF, &[("name", &inline(&message.name))]);
        let file = href(scope.from, &picture::path(scope.site.english_path(id)), "");
        page.block(&format!("[![{text}]({file})]({file})"));
    }
}

fn users(page: &mut Page, scope: Scope<'_, '_>, id: MessageId) {
    let users = scope.site.users(id);
    if !users.is_empty() {
        heading(page, scope.site.words, 2, words::USED_BY);
        page.gap();
        for user in users {
            page.item(0, &field_link(scope, id, *user));
        }
    }
}
