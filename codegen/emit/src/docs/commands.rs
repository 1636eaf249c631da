//! Commands: the constants in `VehicleCommand` that have seven parameters.

use uavspec_schema::MessageId;
use uavspec_schema::msg::constraint::INVALID;
use uavspec_schema::translation::MessageText;

use super::cell::{
    command_anchor, constraint, has_parameters, meaning, name_with_parameters, unit, value_cell,
};
use super::constants::{Anchored, Constants, ParameterRef, prefix_anchor};
use super::markdown::{Page, Table, code, inline, link, number_column, text_column};
use super::scope::Scope;
use super::site::Part;
use super::words::{self};

/// Writes the commands of a message. One table lists the commands outside enums. Each command with parameters has a
/// parameter table.
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
    let words = scope.site.words;
    let columns = [
        number_column(words.get(words::VALUE)),
        text_column(words.get(words::COMMAND)),
        text_column(words.get(words::DESCRIPTION)),
    ];
    let mut list = Table::new(&columns);
    for index in commands.iter().filter(|index| !constants.members.contains(index)) {
        let constant = &message.constants[*index];
        let name = anchored.place(scope, id, *index) + &name_with_parameters(constant);
        list.row([value_cell(&constant.value), name, scope.inline_of(MessageText::Constant(*index))]);
    }
    page.table(&list);
    for index in commands.into_iter().filter(|index| has_parameters(&message.constants[*index])) {
        command(page, scope, index, constants);
    }
}

fn command(page: &mut Page, scope: Scope<'_, '_>, command: usize, constants: &Constants<'_>) {
    let constant = &scope.site.schema.message(scope.message).constants[command];
    page.anchor(&command_anchor(constant));
    page.heading(3, &format!("{} ({})", code(&constant.name), inline(&constant.value.to_string())));
    page.block(&scope.block_of(MessageText::Constant(command)));
    let words = scope.site.words;
    let columns = [
        number_column(words.get(words::PARAMETER)),
        text_column(words.get(words::UNIT)),
        text_column(words.get(words::VALUES)),
        text_column(words.get(words::DESCRIPTION)),
    ];
    let mut table = Table::new(&columns);
    for (index, parameter) in constant.parameters.iter().enumerate() {
        if !parameter.is_unused() {
            table.row([
                (index + 1).to_string(),
                unit(parameter.unit.as_deref()),
                values(scope, (command, index), constants).join("<br>"),
                scope.inline_of(MessageText::Parameter(command, index)),
            ]);
        }
    }
    page.table(&table);
}

fn values(scope: Scope<'_, '_>, (command, index): ParameterRef, constants: &Constants<'_>) -> Vec<String> {
    let words = scope.site.words;
    let parameter = &scope.site.schema.message(scope.message).constants[command].parameters[index];
    let one_of =
        |prefix: &String| words.fill(words::ONE_OF, &[("enum", &prefix_link(scope, prefix, constants))]);
    let prefixes = parameter.enum_prefixes.iter();
    let mut lines: Vec<String> = prefixes.map(one_of).collect();
    lines.extend(parameter.constraints.iter().filter_map(|found| {
        let text = MessageText::ParameterConstraint(command, index, found.kind);
        if *found.kind == INVALID {
            return Some(meaning(scope, found, text, words::LEFT_OUT));
        }
        constraint(scope, found, text)
    }));
    lines
}

/// A link to the constants with this prefix, if they are on the page.
fn prefix_link(scope: Scope<'_, '_>, prefix: &str, constants: &Constants<'_>) -> String {
    let text = code(prefix);
    if constants.parameter_enums.contains_key(prefix) {
        return link(&text, &format!("#{}", prefix_anchor(prefix)));
    }
    match scope.site.part_named(scope.message, prefix) {
        Some(part @ Part::Enum(_)) => link(&text, &scope.site.href(scope.from, scope.message, part)),
        _ => text,
    }
}
