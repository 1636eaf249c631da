//! The page of a service or action.

use super::constants::{self, Anchored, Constants};
use super::enums;
use super::fields;
use super::markdown::{Page, Table, code, inline, text_column, unbroken};
use super::message::{cdr_size, package_cell};
use super::scope::Scope;
use super::site::{Site, interface_path, part_names};
use crate::emit::OutputFile;
use crate::emit::json_schema::Target;
use crate::schema::{Interface, Kind, MessageId, Package};

/// What a kind is called in running text.
pub(super) fn kind_name(kind: Kind) -> &'static str {
    match kind {
        Kind::Message => "message",
        Kind::Service => "service",
        Kind::Action => "action",
    }
}

/// The page of a service or action: all its parts.
pub(super) fn page(site: &Site<'_>, package: &Package, interface: &Interface) -> OutputFile {
    let path = interface_path(package, interface);
    let mut page = Page::new(&path, &format!("{} {}", inline(&interface.name), kind_name(interface.kind)));
    page.table(&facts(site, package, interface, &path));
    for (id, name) in interface.parts.iter().zip(part_names(interface.kind)) {
        page.heading(2, name);
        part(&mut page, Scope::of(site, *id), *id);
    }
    page.finish()
}

fn facts(site: &Site<'_>, package: &Package, interface: &Interface, path: &str) -> Table {
    let mut table = Table::new(&[text_column(""), text_column("")]);
    table.row(["Package".to_owned(), package_cell(path, package)]);
    table.row(["Definition".to_owned(), code(site.source(interface.span))]);
    let ros_type = format!("{}/{}/{}", package.ros_package, interface.kind.name(), interface.name);
    table.row([unbroken("ROS 2 type"), code(&ros_type)]);
    if let Some(hash) = &interface.type_hash {
        table.row([unbroken("ROS 2 type hash"), code(hash)]);
    }
    for (id, part) in interface.parts.iter().zip(part_names(interface.kind)) {
        let name = format!("CDR size of the {}", part.to_ascii_lowercase());
        table.row([unbroken(&name), cdr_size(site.schema.message(*id).cdr)]);
        for (name, file) in site.files(path, Target::Message(*id)) {
            table.row([unbroken(&format!("{name} of the {}", part.to_ascii_lowercase())), file]);
        }
    }
    table
}

fn part(page: &mut Page, scope: Scope<'_, '_>, id: MessageId) {
    let message = scope.site.schema.message(id);
    page.block(&scope.block(&message.docs.summary));
    page.block(&scope.block(&message.docs.description));
    fields::write(page, scope, id, 3);
    let constants = Constants::of(message);
    let mut anchored = Anchored::default();
    enums::write(page, scope, id, 3, &mut anchored);
    let mut others = constants.others;
    others.extend(constants.of_parameters.into_values().flat_map(|found| found.constants));
    others.extend(constants.commands.into_iter().filter(|index| !constants.members.contains(index)));
    others.sort_unstable();
    if !others.is_empty() {
        page.heading(3, "Constants");
        constants::write(page, scope, id, &others, 4, &mut anchored);
    }
}
