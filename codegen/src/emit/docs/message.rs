//! The page of a message.

use super::commands;
use super::composer;
use super::constants::{self, Anchored, Constants};
use super::enums::{self, field_link};
use super::fields;
use super::markdown::{Page, Table, code, href, inline, link, plural, text_column, unbroken};
use super::picture;
use super::scope::Scope;
use super::site::Site;
use crate::emit::OutputFile;
use crate::emit::json_schema::Target;
use crate::schema::{CdrSize, Message, MessageId, Package, UorbLayout};

/// The page of a message.
pub(super) fn page(site: &Site<'_>, id: MessageId) -> OutputFile {
    let scope = Scope::of(site, id);
    let message = site.schema.message(id);
    let mut page = Page::new(scope.from, &inline(&message.name));
    page.block(&scope.block(&message.docs.summary));
    page.block(&scope.block(&message.docs.description));
    page.table(&facts(scope, id));
    page.heading(2, "Fields");
    fields::write(&mut page, scope, id, 3);
    layout(&mut page, scope, message);
    composer::write(&mut page, site, id);
    values(&mut page, scope, id);
    users(&mut page, scope, id);
    page.finish()
}

fn facts(scope: Scope<'_, '_>, id: MessageId) -> Table {
    let message = scope.site.schema.message(id);
    let package = scope.site.schema.package_of(message);
    let mut table = Table::new(&[text_column(""), text_column("")]);
    let mut fact = |name: &str, value: String| {
        if !value.is_empty() {
            table.row([unbroken(name), value]);
        }
    };
    fact("Package", package_cell(scope.from, package));
    fact("Definition", code(scope.site.source(message.span)));
    fact(if message.topics.len() == 1 { "Topic" } else { "Topics" }, topics(&message.topics));
    fact("Message version", message.version.map(|version| version.to_string()).unwrap_or_default());
    fact("Queue length", message.queue_length.map(|length| length.to_string()).unwrap_or_default());
    fact("uORB size", scope.site.layout(message).map(uorb_size).unwrap_or_default());
    if scope.site.is_px4(message) {
        fact("uORB hash", code(&format!("{:#010x}", message.hash)));
    }
    fact("CDR size", cdr_size(message.cdr) + ", 4 of them the encapsulation header");
    fact("ROS 2 type", code(&format!("{}/{}/{}", package.ros_package, message.kind.name(), message.name)));
    fact("ROS 2 type hash", code(&message.type_hash));
    for (name, file) in scope.site.files(scope.from, Target::Message(id)) {
        fact(name, file);
    }
    table
}

/// A package, and where it comes from.
pub(super) fn package_cell(from: &str, package: &Package) -> String {
    let name = link(&inline(&package.name), &href(from, &format!("{}/README.md", package.name), ""));
    format!("{name}{}", origin(package).map(|origin| format!(", from {origin}")).unwrap_or_default())
}

/// Where a package comes from, in which state.
pub(super) fn origin(package: &Package) -> Option<String> {
    match (&package.origin, &package.revision) {
        (Some(origin), Some(revision)) => Some(format!("{} at {}", inline(origin), code(revision))),
        (Some(origin), None) => Some(inline(origin)),
        (None, Some(revision)) => Some(code(revision)),
        (None, None) => None,
    }
}

/// Topics, as code.
pub(super) fn topics(topics: &[String]) -> String {
    topics.iter().map(|topic| code(topic)).collect::<Vec<_>>().join(", ")
}

fn uorb_size(layout: &UorbLayout) -> String {
    let size = link(&plural(layout.size as u64, "byte"), "#memory-layout");
    if layout.size == layout.size_no_padding {
        size
    } else {
        format!("{size}, {} without the padding at the end", layout.size_no_padding)
    }
}

/// Size of the CDR form.
pub(super) fn cdr_size(size: CdrSize) -> String {
    let least = plural(size.least, "byte");
    if size.is_fixed { least } else { format!("{least} or more") }
}

/// Writes all that is said of constants.
fn values(page: &mut Page, scope: Scope<'_, '_>, id: MessageId) {
    let message = scope.site.schema.message(id);
    let constants = Constants::of(message);
    let mut anchored = Anchored::default();
    if !message.enums.is_empty() {
        page.heading(2, "Enums");
        enums::write(page, scope, id, 3, &mut anchored);
    }
    if !constants.commands.is_empty() {
        page.heading(2, "Commands");
        commands::write(page, scope, id, &constants, &mut anchored);
    }
    if !constants.of_parameters.is_empty() {
        page.heading(2, "Values of parameters");
        constants::write_parameter_enums(page, scope, id, &constants, &mut anchored);
    }
    if !constants.others.is_empty() {
        page.heading(2, "Constants");
        constants::write(page, scope, id, &constants.others, 3, &mut anchored);
    }
}

fn layout<'s>(page: &mut Page, scope: Scope<'_, 's>, message: &'s Message) {
    if scope.site.layout(message).is_some() {
        page.heading(2, "Memory layout");
        page.block(
            "The order and offsets of the fields in uORB and in the data of ULog files, eight bytes a row.",
        );
        let name = inline(&message.name);
        let file = href(scope.from, &picture::path(scope.from), "");
        page.block(&format!("[![Memory layout of {name}]({file})]({file})"));
    }
}

fn users(page: &mut Page, scope: Scope<'_, '_>, id: MessageId) {
    let holders = scope.site.holders(id);
    if !holders.is_empty() {
        page.heading(2, "Used by");
        page.gap();
        for holder in holders {
            page.item(0, &field_link(scope, id, *holder));
        }
    }
}
