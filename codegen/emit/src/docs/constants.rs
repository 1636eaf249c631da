//! Constants outside enums: values of command parameters, and other constants.

use std::collections::{BTreeMap, BTreeSet};

use uavspec_schema::translation::MessageText;
use uavspec_schema::{Message, MessageId};

use super::cell::{constant_type, name_with_parameters, value_cell};
use super::groups::in_groups;
use super::markdown::{Page, Table, anchor, code, number_column, text_column};
use super::scope::Scope;
use super::site::{Part, is_fact};
use super::words::{self, Words};

/// Constants whose anchors are already on the page. Two enums may share a constant, but an anchor must be unique.
#[derive(Debug, Default)]
pub(super) struct Anchored(BTreeSet<usize>);

impl Anchored {
    /// The anchor of a constant, or an empty string if the page already contains it.
    pub(super) fn place(&mut self, scope: Scope<'_, '_>, id: MessageId, constant: usize) -> String {
        let is_new = self.0.insert(constant);
        if is_new { anchor(&scope.site.anchor(id, Part::Constant(constant))) } else { String::new() }
    }
}

/// A parameter: the index of its command, and the index of the parameter.
pub(super) type ParameterRef = (usize, usize);

/// Constants used as values of command parameters.
#[derive(Debug, Default)]
pub(super) struct ParameterEnum {
    pub(super) users: Vec<ParameterRef>,
    pub(super) constants: Vec<usize>,
}

/// The constants of a message, grouped by the section that shows them.
#[derive(Debug, Default)]
pub(super) struct Constants<'s> {
    /// Constants that are commands: all constants with parameters, and all constants that start with the common prefix
    /// of commands.
    pub(super) commands: Vec<usize>,
    /// Values of command parameters, by prefix.
    pub(super) parameter_enums: BTreeMap<&'s str, ParameterEnum>,
    /// Other constants outside enums.
    pub(super) others: Vec<usize>,
    /// Members of enums.
    pub(super) members: BTreeSet<usize>,
}

impl<'s> Constants<'s> {
    pub(super) fn of(message: &'s Message) -> Self {
        let members =
            message.enums.iter().flat_map(|found| &found.members).map(|member| member.constant).collect();
        let mut constants = Self { members, parameter_enums: parameter_enums(message), ..Self::default() };
        let command_prefix = command_prefix(message);
        for (index, constant) in message.constants.iter().enumerate() {
            let has_command_prefix = command_prefix.is_some_and(|prefix| constant.name.starts_with(prefix));
            if !constant.parameters.is_empty() || has_command_prefix {
                constants.commands.push(index);
            } else if !constants.members.contains(&index) && !is_fact(message, index) {
                match longest_prefix(&constant.name, &mut constants.parameter_enums) {
                    Some(found) => found.constants.push(index),
                    None => constants.others.push(index),
                }
            }
        }
        constants.parameter_enums.retain(|_, found| !found.constants.is_empty());
        constants
    }
}

/// The common prefix of all command names, including the underscore, if there are at least two commands.
fn command_prefix(message: &Message) -> Option<&str> {
    let commands = message.constants.iter().filter(|constant| !constant.parameters.is_empty());
    let mut names = commands.map(|constant| constant.name.as_str());
    let (first, second) = (names.next()?, names.next()?);
    let shared = names.fold(common_start(first, second), common_start);
    shared.rfind('_').map(|at| &shared[..=at])
}

fn common_start<'n>(left: &'n str, right: &str) -> &'n str {
    let length = left.bytes().zip(right.bytes()).take_while(|(left, right)| left == right).count();
    left.get(..length).unwrap_or_default()
}

/// The prefixes that command parameters refer to, except prefixes of enums in the same message.
fn parameter_enums(message: &Message) -> BTreeMap<&str, ParameterEnum> {
    let known: BTreeSet<&str> =
        message.enums.iter().flat_map(|found| &found.prefixes).map(String::as_str).collect();
    let mut found: BTreeMap<&str, ParameterEnum> = BTreeMap::new();
    for (command, constant) in message.constants.iter().enumerate() {
        for (index, parameter) in constant.parameters.iter().enumerate() {
            let prefixes = parameter.enum_prefixes.iter().map(String::as_str);
            for prefix in prefixes.filter(|prefix| !known.contains(prefix)) {
                found.entry(prefix).or_default().users.push((command, index));
            }
        }
    }
    found
}

/// The entry for the longest known prefix of `name`.
fn longest_prefix<'f>(
    name: &str,
    found: &'f mut BTreeMap<&str, ParameterEnum>,
) -> Option<&'f mut ParameterEnum> {
    let (at, _) = name.rmatch_indices('_').find(|(at, _)| found.contains_key(&name[..*at]))?;
    found.get_mut(&name[..at])
}

/// Formats a parameter as its number and a link to its command.
fn parameter_link(words: Words, message: &Message, (command, index): ParameterRef) -> String {
    let command = name_with_parameters(&message.constants[command]);
    words.fill(words::PARAMETER_OF, &[("number", &(index + 1).to_string()), ("command", &command)])
}

/// The anchor of the constants with this prefix.
pub(super) fn prefix_anchor(prefix: &str) -> String {
    format!("enum-{}", prefix.to_ascii_lowercase())
}

/// Writes the values of command parameters, prefix by prefix.
pub(super) fn write_parameter_enums(
    page: &mut Page,
    scope: Scope<'_, '_>,
    id: MessageId,
    constants: &Constants<'_>,
    anchored: &mut Anchored,
) {
    let message = scope.site.schema.message(id);
    let words = scope.site.words;
    for (prefix, found) in &constants.parameter_enums {
        page.anchor(&prefix_anchor(prefix));
        page.heading(3, &code(prefix));
        let users: Vec<String> =
            found.users.iter().map(|user| parameter_link(words, message, *user)).collect();
        page.block(&words.fill(words::USED_BY_FIELDS, &[("fields", &users.join(", "))]));
        let mut table = Table::new(&[
            number_column(words.get(words::VALUE)),
            text_column(words.get(words::NAME)),
            text_column(words.get(words::DESCRIPTION)),
        ]);
        for index in &found.constants {
            let constant = &message.constants[*index];
            let name = anchored.place(scope, id, *index) + &code(&constant.name);
            table.row([
                value_cell(&constant.value),
                name,
                scope.at(Part::Constant(*index)).inline_of(MessageText::Constant(*index)),
            ]);
        }
        page.table(&table);
    }
}

/// Writes the remaining constants, group by group.
pub(super) fn write(
    page: &mut Page,
    scope: Scope<'_, '_>,
    id: MessageId,
    indexes: &[usize],
    level: usize,
    anchored: &mut Anchored,
) {
    let message = scope.site.schema.message(id);
    let words = scope.site.words;
    let columns = [
        text_column(words.get(words::CONSTANT)),
        text_column(words.get(words::TYPE)),
        number_column(words.get(words::VALUE)),
        text_column(words.get(words::DESCRIPTION)),
    ];
    let mut table = Table::new(&columns);
    for index in indexes {
        let constant = &message.constants[*index];
        table.row([
            anchored.place(scope, id, *index) + &code(&constant.name),
            constant_type(scope, message, constant.ty),
            value_cell(&constant.value),
            scope.at(Part::Constant(*index)).inline_of(MessageText::Constant(*index)),
        ]);
    }
    let groups: Vec<Option<usize>> = indexes.iter().map(|index| message.constants[*index].group).collect();
    in_groups(page, scope, table, &groups, level);
}
