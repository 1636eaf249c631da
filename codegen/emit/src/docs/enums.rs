//! Enums and flags.

use uavspec_schema::translation::MessageText;
use uavspec_schema::{Enum, EnumRef, Field, Member, Message, MessageId};

use super::cell::{field_link, name_with_parameters};
use super::constants::Anchored;
use super::markdown::{Page, Table, code, link, number_column, text_column};
use super::scope::Scope;
use super::site::Part;
use super::words;

/// Writes the enums of a message.
pub(super) fn write(
    page: &mut Page,
    scope: Scope<'_, '_>,
    id: MessageId,
    level: usize,
    anchored: &mut Anchored,
) {
    let message = scope.site.schema.message(id);
    for (index, found) in message.enums.iter().enumerate() {
        page.anchor(&scope.site.anchor(id, Part::Enum(index)));
        page.heading(level, &title(found));
        for text in introduction(message, found) {
            page.block(&scope.block_of(text));
        }
        page.block(&users(scope, EnumRef { message: id, index }, found));
        page.table(&table(scope, id, found, anchored));
    }
}

/// The prefixes of the constants, formatted as code.
fn title(found: &Enum) -> String {
    found.prefixes.iter().map(|prefix| code(prefix)).collect::<Vec<_>>().join(", ")
}

/// The group texts, if all constants of the enum are in one group.
fn introduction(message: &Message, found: &Enum) -> Vec<MessageText> {
    let mut groups = found.members.iter().map(|member| message.constants[member.constant].group);
    let first = groups.next().flatten();
    let group = first.filter(|_| groups.all(|group| group == first));
    let texts = group.map(|group| vec![MessageText::Group(group), MessageText::GroupDescription(group)]);
    texts.unwrap_or_default()
}

/// The fields that use the enum, followed by a sentence about undocumented values.
fn users(scope: Scope<'_, '_>, reference: EnumRef, found: &Enum) -> String {
    let fields: Vec<String> = scope
        .site
        .enum_users(reference)
        .iter()
        .map(|field| field_link(scope, reference.message, *field))
        .collect();
    let words = scope.site.words;
    let rest = words.get(if found.is_flags { words::OTHER_BITS } else { words::OTHER_VALUES });
    if fields.is_empty() {
        return rest.to_owned();
    }
    format!("{} {rest}", words.fill(words::USED_BY_FIELDS, &[("fields", &fields.join(", "))]))
}

fn table(scope: Scope<'_, '_>, id: MessageId, found: &Enum, anchored: &mut Anchored) -> Table {
    let message = scope.site.schema.message(id);
    let words = scope.site.words;
    let columns = [
        number_column(words.get(if found.is_flags { words::MASK } else { words::VALUE })),
        number_column(words.get(words::BIT)),
        text_column(words.get(words::NAME)),
        text_column(words.get(words::DESCRIPTION)),
    ];
    let mut table = Table::new(&columns);
    let mut members: Vec<&Member> = found.members.iter().collect();
    // The sort is stable, so the first declared name of each value comes first.
    members.sort_by_key(|member| member.value);
    let mut leader: Option<&Member> = None;
    for member in members {
        let alias_of = leader.filter(|leader| leader.value == member.value);
        if alias_of.is_none() {
            leader = Some(member);
        }
        let name = name_with_parameters(&message.constants[member.constant]);
        table.row([
            value_cell(found, member),
            bit_cell(found, member),
            anchored.place(scope, id, member.constant) + &name,
            description(scope, message, member, alias_of),
        ]);
    }
    table
}

fn value_cell(found: &Enum, member: &Member) -> String {
    if found.is_flags && member.value >= 0 {
        let digits = 2 * found.scalar.size();
        return code(&format!("0x{:0digits$x}", member.value));
    }
    member.value.to_string()
}

fn bit_cell(found: &Enum, member: &Member) -> String {
    let is_bit = found.is_flags && member.value > 0 && member.value.count_ones() == 1;
    if is_bit { member.value.trailing_zeros().to_string() } else { String::new() }
}

fn description(
    scope: Scope<'_, '_>,
    message: &Message,
    member: &Member,
    alias_of: Option<&Member>,
) -> String {
    let text = scope.at(Part::Constant(member.constant)).inline_of(MessageText::Constant(member.constant));
    let Some(other) = alias_of else { return text };
    let name = code(&message.constants[other.constant].name);
    let alias = scope.site.words.fill(words::ANOTHER_NAME_OF, &[("name", &name)]);
    if text.is_empty() { alias } else { format!("{text}<br>{alias}") }
}

/// The enum of a field, as a link.
pub(super) fn of_field(scope: Scope<'_, '_>, field: &Field) -> Option<String> {
    let words = scope.site.words;
    let Some(reference) = field.enumeration else {
        let prefixes: Vec<String> = field.enum_prefixes.iter().map(|prefix| code(prefix)).collect();
        let all = prefixes.join(", ");
        return (!prefixes.is_empty()).then(|| words.fill(words::ONE_OF, &[("enum", &all)]));
    };
    let found = scope.site.schema.enumeration(reference);
    let owner = scope.site.schema.message(reference.message);
    let name = found.prefixes.join(", ");
    let text = if scope.message == reference.message {
        code(&name)
    } else {
        code(&format!("{}.{name}", owner.name))
    };
    let kind = if found.is_flags { words::BITS_OF } else { words::ONE_OF };
    let link = link(&text, &scope.site.href(scope.from, reference.message, Part::Enum(reference.index)));
    Some(words.fill(kind, &[("enum", &link)]))
}
