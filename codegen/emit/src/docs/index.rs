//! Index pages: one for all packages, and one per package.

use uavspec_schema::wording::{plural, thousands};
use uavspec_schema::{Enum, Message, MessageId, Package};

use super::interface::kind_name;
use super::json::Json;
use super::markdown::{Page, Table, code, gist, href, inline, link, number_column, text_column, unbroken};
use super::message::{cdr_size, origin, topics};
use super::options::Options;
use super::scope::Scope;
use super::site::{Part, Site, interface_path};
use super::words::ENGLISH;
use super::{error_codes, events, rules};
use crate::file::OutputFile;

/// Maximum length of an index cell, in characters.
const MAX_GIST: usize = 160;

/// Maximum number of topics in an index cell.
const MAX_TOPICS: usize = 4;

/// The index page of all packages.
pub(super) fn overview(site: &Site<'_>, options: &Options) -> OutputFile {
    let path = "README.md";
    let mut page = Page::new(path, &inline(&options.title));
    for package in site.packages() {
        page.heading(2, &inline(&package.name));
        introduction(&mut page, package);
        let more = link("Topics, enums and sizes", &href(path, &readme(package), ""));
        contents(&mut page, site, path, package, 3);
        if !package.messages.is_empty() {
            page.block(&format!("{more} of all {}.", messages(package.messages.len())));
        }
    }
    if options.rules {
        page.heading(2, rules::TITLE);
        let all = link("All rules", &href(path, rules::OVERVIEW, ""));
        page.block(&format!("{all} that uavspec checks definitions against, with examples."));
    }
    page.finish()
}

/// The index page of a package.
pub(super) fn package(site: &Site<'_>, package: &Package) -> OutputFile {
    let path = readme(package);
    let mut page = Page::new(&path, &inline(&package.name));
    introduction(&mut page, package);
    contents(&mut page, site, &path, package, 2);
    section(&mut page, 2, "Topics", &topic_table(site, &path, package));
    section(&mut page, 2, "Enums", &enum_table(site, &path, package));
    section(&mut page, 2, "Sizes", &size_table(site, &path, package));
    page.finish()
}

fn readme(package: &Package) -> String {
    format!("{}/README.md", package.name)
}

fn messages(count: usize) -> String {
    plural(count as u64, "message")
}

fn introduction(page: &mut Page, package: &Package) {
    if let Some(origin) = origin(ENGLISH, package) {
        page.block(&format!("From {origin}."));
    }
}

fn section(page: &mut Page, level: usize, heading: &str, table: &Table) {
    if !table.is_empty() {
        page.heading(level, heading);
        page.table(table);
    }
}

/// Writes the tables that list a package's contents.
fn contents(page: &mut Page, site: &Site<'_>, from: &str, package: &Package, level: usize) {
    section(page, level, "Messages", &message_table(site, from, package));
    section(page, level, "Services and actions", &interface_table(site, from, package));
    let json = Json::of(site, package);
    section(page, level, "Messages", &json.message_table(from));
    section(page, level, "Types", &json.type_table(from));
    if !package.error_tables.is_empty() {
        page.heading(level, error_codes::TITLE);
        page.table(&error_codes::list(site, from, package));
        page.block(&link("All codes in one table", &href(from, &error_codes::overview_path(package), "")));
    }
    for component in &package.components {
        page.heading(level, &events::title(ENGLISH, component));
        let count = plural(component.events.len() as u64, "event");
        let all =
            link("All events in one table", &href(from, &events::overview_path(package, component), ""));
        page.block(&format!("{count}. {all}"));
    }
}

fn message_table(site: &Site<'_>, from: &str, package: &Package) -> Table {
    let columns = [
        text_column("Message"),
        number_column("Version"),
        number_column("uORB"),
        text_column("Summary"),
        text_column("Topics"),
    ];
    let mut table = Table::new(&columns);
    for id in &package.messages {
        let message = site.schema.message(*id);
        let scope = Scope::on(site, from, *id);
        table.row([
            page_link(site, from, *id),
            message.version.map(|version| version.to_string()).unwrap_or_default(),
            uorb_size(site, message),
            scope.inline(&gist(&message.docs.summary, MAX_GIST)),
            some_topics(site, from, *id),
        ]);
    }
    table
}

/// The topics of a message. A long list is shortened.
fn some_topics(site: &Site<'_>, from: &str, id: MessageId) -> String {
    let message = site.schema.message(id);
    if message.topics.len() <= MAX_TOPICS {
        return topics(&message.topics);
    }
    let (first, rest) = message.topics.split_at(MAX_TOPICS - 1);
    let more = link(&format!("{} more", rest.len()), &href(from, site.path(id), ""));
    format!("{} and {more}", topics(first))
}

fn page_link(site: &Site<'_>, from: &str, id: MessageId) -> String {
    link(&inline(&site.schema.message(id).name), &href(from, site.path(id), ""))
}

fn uorb_size<'s>(site: &Site<'s>, message: &'s Message) -> String {
    site.layout(message).map(|layout| size(layout.size)).unwrap_or_default()
}

fn size(bytes: usize) -> String {
    unbroken(&format!("{} B", thousands(bytes as u64)))
}

fn interface_table(site: &Site<'_>, from: &str, package: &Package) -> Table {
    let mut table = Table::new(&[text_column("Name"), text_column("Kind"), text_column("Summary")]);
    for interface in &package.interfaces {
        let Some(first) = interface.parts.first() else { continue };
        let message = site.schema.message(*first);
        let scope = Scope::on(site, from, *first);
        table.row([
            link(&inline(&interface.name), &href(from, &interface_path(package, interface), "")),
            kind_name(interface.kind).to_owned(),
            scope.inline(&gist(&message.docs.summary, MAX_GIST)),
        ]);
    }
    table
}

/// The table of topics and their messages. Readers of logs need this table, because logs contain only topic names.
fn topic_table(site: &Site<'_>, from: &str, package: &Package) -> Table {
    let mut topics: Vec<(&str, MessageId)> = Vec::new();
    for id in &package.messages {
        topics.extend(site.schema.message(*id).topics.iter().map(|topic| (topic.as_str(), *id)));
    }
    topics.sort_unstable();
    let mut table =
        Table::new(&[text_column("Topic"), text_column("Message"), number_column("Queue length")]);
    for (topic, id) in topics {
        let queue = site.schema.message(id).queue_length.map(|length| length.to_string());
        table.row([code(topic), page_link(site, from, id), queue.unwrap_or_default()]);
    }
    table
}

fn enum_table(site: &Site<'_>, from: &str, package: &Package) -> Table {
    let columns = [text_column("Enum"), text_column("Message"), number_column("Values"), text_column("Kind")];
    let mut table = Table::new(&columns);
    for id in &package.messages {
        for (index, found) in site.schema.message(*id).enums.iter().enumerate() {
            let href = site.href(from, *id, Part::Enum(index));
            table.row([
                link(&code(&found.prefixes.join(", ")), &href),
                page_link(site, from, *id),
                found.members.len().to_string(),
                kind(found).to_owned(),
            ]);
        }
    }
    table
}

fn kind(found: &Enum) -> &'static str {
    if found.is_flags { "flags" } else { "values" }
}

fn size_table(site: &Site<'_>, from: &str, package: &Package) -> Table {
    let columns = [
        text_column("Message"),
        number_column("Fields"),
        number_column("uORB"),
        number_column("without trailing padding"),
        text_column("uORB hash"),
        number_column("CDR"),
    ];
    let mut table = Table::new(&columns);
    for id in &package.messages {
        let message = site.schema.message(*id);
        let layout = site.layout(message);
        table.row([
            page_link(site, from, *id),
            message.fields.len().to_string(),
            uorb_size(site, message),
            layout.map(|layout| size(layout.size_no_padding)).unwrap_or_default(),
            layout.map(|_| code(&format!("{:#010x}", message.hash))).unwrap_or_default(),
            unbroken(&cdr_size(ENGLISH, message.cdr)),
        ]);
    }
    table
}
