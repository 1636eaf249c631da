//! Pages of services and actions.

use uavspec_schema::fingerprint::interface_name;
use uavspec_schema::translation::{MessageText, interface_unit};
use uavspec_schema::{Interface, Kind, MessageId, Package};

use super::constants::{self, Anchored, Constants};
use super::language::{self, Heading, heading};
use super::markdown::{Page, Table, code, inline, text_column, unbroken};
use super::message::{cdr_size, package_cell};
use super::scope::Scope;
use super::site::{Site, interface_path, part_names};
use super::words::{self, ENGLISH, Words};
use super::{enums, fields, history};
use crate::file::OutputFile;
use crate::json_schema::Target;

/// The name of a kind in running text.
pub(super) fn kind_name(kind: Kind) -> &'static str {
    match kind {
        Kind::Message => "message",
        Kind::Service => "service",
        Kind::Action => "action",
    }
}

/// The main heading of the page, as Markdown.
fn title(words: Words, interface: &Interface) -> String {
    let word = if interface.kind == Kind::Action { words::ACTION } else { words::SERVICE };
    words.fill(word, &[("name", &inline(&interface.name))])
}

/// The page of a service or action with all its parts.
pub(super) fn page(site: &Site<'_>, package: &Package, interface: &Interface) -> OutputFile {
    let unit = interface_unit(package, interface);
    let english = interface_path(package, interface);
    let (title, english_title) = (title(site.words, interface), title(ENGLISH, interface));
    let heading = Heading { text: &title, english: &english_title };
    let mut page = language::page(site, &unit, &english, &heading);
    page.table(&facts(site, package, interface, &site.path_of(&english, &unit)));
    for (id, name) in interface.parts.iter().zip(part_names(interface.kind)) {
        if site.words.are_english() {
            page.heading(2, name);
        } else {
            page.heading_for(2, site.words.part(name), name);
        }
        part(&mut page, Scope::of(site, *id), *id);
    }
    history::write(&mut page, site, &interface_name(package, interface), interface.type_hash.as_deref());
    page.finish()
}

fn facts(site: &Site<'_>, package: &Package, interface: &Interface, path: &str) -> Table {
    let words = site.words;
    let mut table = Table::new(&[text_column(""), text_column("")]);
    let mut fact = |name: &str, value: String| table.row([unbroken(name), value]);
    fact(words.get(words::PACKAGE), package_cell(words, path, package));
    fact(words.get(words::DEFINITION), code(site.source(interface.span)));
    fact(words.get(words::ROS_TYPE), code(&interface_name(package, interface)));
    if let Some(hash) = &interface.type_hash {
        fact(words.get(words::ROS_TYPE_HASH), code(hash));
    }
    for (id, part) in interface.parts.iter().zip(part_names(interface.kind)) {
        let part = words.part(part).to_lowercase();
        fact(
            &words.fill(words::CDR_SIZE_OF, &[("part", &part)]),
            cdr_size(words, site.schema.message(*id).cdr),
        );
        for (name, file) in site.files(path, Target::Message(*id)) {
            fact(&words.fill(words::OF_PART, &[("fact", name), ("part", &part)]), file);
        }
    }
    table
}

fn part(page: &mut Page, scope: Scope<'_, '_>, id: MessageId) {
    let message = scope.site.schema.message(id);
    page.block(&scope.block_of(MessageText::Summary));
    page.block(&scope.block_of(MessageText::Description));
    fields::write(page, scope, id, 3);
    let constants = Constants::of(message);
    let mut anchored = Anchored::default();
    enums::write(page, scope, id, 3, &mut anchored);
    let mut others = constants.others;
    others.extend(constants.parameter_enums.into_values().flat_map(|found| found.constants));
    others.extend(constants.commands.into_iter().filter(|index| !constants.members.contains(index)));
    others.sort_unstable();
    if !others.is_empty() {
        heading(page, scope.site.words, 3, words::CONSTANTS);
        constants::write(page, scope, id, &others, 4, &mut anchored);
    }
}
