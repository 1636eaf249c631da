//! Constants with seven parameters: the commands of `VehicleCommand`.

use super::constants::{Anchored, Constants, ParameterRef, prefix_anchor};
use super::fields::{meaning, range, unit, value_cell};
use super::markdown::{Page, Table, code, inline, link, number_column, text_column};
use super::scope::Scope;
use super::site::Part;
use crate::schema::{Constant, Message, MessageId, Parameter};

/// What descriptions say of a parameter that means nothing.
const UNUSED: [&str; 6] = ["", "-", "empty", "reserved", "unused", "n/a"];

/// Writes the commands of a message: a list of those that no enum lists, and the parameters of each.
pub(super) fn write(
    page: &mut Page,
    scope: Scope<'_, '_>,
    id: MessageId,
    constants: &Constants<'_>,
    anchored: &mut Anchored,
) {
    let message = scope.site.schema.message(id);
    let mut commands = constants.commands.clone();
    commands.sort_by_key(|index| message.constants[*index].value.as_int());
    let columns = [number_column("Value"), text_column("Command"), text_column("Description")];
    let mut list = Table::new(&columns);
    for index in commands.iter().filter(|index| !constants.members.contains(index)) {
        let constant = &message.constants[*index];
        let name = anchored.place(scope, id, *index) + &name_with_parameters(constant);
        list.row([value_cell(&constant.value), name, scope.inline(&constant.description)]);
    }
    page.table(&list);
    for constant in
        commands.into_iter().map(|index| &message.constants[index]).filter(|found| has_parameters(found))
    {
        command(page, scope, constant, constants);
    }
}

/// The name of a constant, which leads to its parameters where it has any.
pub(super) fn name_with_parameters(constant: &Constant) -> String {
    let name = code(&constant.name);
    if has_parameters(constant) { link(&name, &format!("#{}", command_anchor(constant))) } else { name }
}

/// A parameter, by its number and its command.
pub(super) fn parameter_link(message: &Message, (command, index): ParameterRef) -> String {
    format!("parameter {} of {}", index + 1, name_with_parameters(&message.constants[command]))
}

fn command_anchor(constant: &Constant) -> String {
    format!("command-{}", constant.name.to_ascii_lowercase())
}

fn has_parameters(constant: &Constant) -> bool {
    !constant.parameters.iter().all(is_unused)
}

fn is_unused(parameter: &Parameter) -> bool {
    let text = parameter.description.trim().trim_end_matches('.').to_ascii_lowercase();
    let says_nothing =
        parameter.range.is_none() && parameter.invalid.is_none() && parameter.enum_prefixes.is_empty();
    says_nothing && UNUSED.contains(&text.as_str())
}

fn command(page: &mut Page, scope: Scope<'_, '_>, constant: &Constant, constants: &Constants<'_>) {
    page.anchor(&command_anchor(constant));
    page.heading(3, &format!("{} ({})", code(&constant.name), inline(&constant.value.to_string())));
    page.block(&scope.block(&constant.description));
    let columns =
        [number_column("Parameter"), text_column("Unit"), text_column("Values"), text_column("Description")];
    let mut table = Table::new(&columns);
    for (index, parameter) in constant.parameters.iter().enumerate() {
        if !is_unused(parameter) {
            table.row([
                (index + 1).to_string(),
                unit(parameter.unit.as_deref()),
                values(scope, parameter, constants).join("<br>"),
                scope.inline(&parameter.description),
            ]);
        }
    }
    page.table(&table);
}

fn values(scope: Scope<'_, '_>, parameter: &Parameter, constants: &Constants<'_>) -> Vec<String> {
    let prefixes = parameter.enum_prefixes.iter();
    let mut lines: Vec<String> =
        prefixes.map(|prefix| format!("one of {}", prefix_link(scope, prefix, constants))).collect();
    lines.extend(parameter.range.as_ref().and_then(range));
    lines.extend(parameter.invalid.as_ref().map(|special| meaning(scope, special, "left out")));
    lines
}

/// A link to the constants of a prefix, where the page has them.
fn prefix_link(scope: Scope<'_, '_>, prefix: &str, constants: &Constants<'_>) -> String {
    let text = code(prefix);
    if constants.of_parameters.contains_key(prefix) {
        return link(&text, &format!("#{}", prefix_anchor(prefix)));
    }
    match scope.site.part_named(scope.message, prefix) {
        Some(part @ Part::Enum(_)) => link(&text, &scope.site.href(scope.from, scope.message, part)),
        _ => text,
    }
}
