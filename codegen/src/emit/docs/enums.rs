//! Enums and flags: the constants that fields hold.

use super::commands::name_with_parameters;
use super::constants::Anchored;
use super::markdown::{Page, Table, code, link, number_column, text_column};
use super::scope::Scope;
use super::site::{FieldRef, Part};
use crate::schema::{Docs, Enum, EnumRef, Field, Member, Message, MessageId};

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
        page.block(&scope.block(&introduction(message, found)));
        page.block(&holders(scope, EnumRef { message: id, index }, found));
        page.table(&table(scope, id, found, anchored));
    }
}

/// The prefixes of the constants, which are what the annotation of a field names.
fn title(found: &Enum) -> String {
    found.prefixes.iter().map(|prefix| code(prefix)).collect::<Vec<_>>().join(", ")
}

/// The text that stands above all the constants of an enum.
fn introduction(message: &Message, found: &Enum) -> String {
    let mut groups = found.members.iter().map(|member| message.constants[member.constant].group);
    let first = groups.next().flatten();
    let docs = first.filter(|_| groups.all(|group| group == first)).map(|group| &message.groups[group]);
    docs.map(Docs::text).unwrap_or_default()
}

/// Which fields hold the enum, and what else they may hold.
fn holders(scope: Scope<'_, '_>, held: EnumRef, found: &Enum) -> String {
    let fields: Vec<String> =
        scope.site.enum_holders(held).iter().map(|field| field_link(scope, held.message, *field)).collect();
    let rest = if found.is_flags {
        "Any number of these bits may be set, and others, too."
    } else {
        "Other values may occur, too."
    };
    if fields.is_empty() { rest.to_owned() } else { format!("Held by {}. {rest}", fields.join(", ")) }
}

/// A field of this or another message.
pub(super) fn field_link(scope: Scope<'_, '_>, own: MessageId, (id, index): FieldRef) -> String {
    let schema = scope.site.schema;
    let message = schema.message(id);
    let field = &message.fields[index].name;
    let text = if id == own {
        code(field)
    } else if message.package == scope.package {
        code(&format!("{}.{field}", message.name))
    } else {
        code(&format!("{}/{}.{field}", schema.package_of(message).name, message.name))
    };
    link(&text, &scope.site.href(scope.from, id, Part::Field(index)))
}

fn table(scope: Scope<'_, '_>, id: MessageId, found: &Enum, anchored: &mut Anchored) -> Table {
    let message = scope.site.schema.message(id);
    let first = if found.is_flags { "Mask" } else { "Value" };
    let columns =
        [number_column(first), number_column("Bit"), text_column("Name"), text_column("Description")];
    let mut table = Table::new(&columns);
    let mut members: Vec<&Member> = found.members.iter().collect();
    // Stable: of several names for a value, the one that is declared first leads.
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
    let text =
        scope.at(Part::Constant(member.constant)).inline(&message.constants[member.constant].description);
    let Some(other) = alias_of else { return text };
    let alias = format!("Another name of {}.", code(&message.constants[other.constant].name));
    if text.is_empty() { alias } else { format!("{text}<br>{alias}") }
}

/// What a field holds, where it is an enum.
pub(super) fn of_field(scope: Scope<'_, '_>, field: &Field) -> Option<String> {
    let Some(held) = field.enumeration else {
        let prefixes: Vec<String> = field.enum_prefixes.iter().map(|prefix| code(prefix)).collect();
        return (!prefixes.is_empty()).then(|| format!("one of {}", prefixes.join(", ")));
    };
    let found = scope.site.schema.enumeration(held);
    let owner = scope.site.schema.message(held.message);
    let name = found.prefixes.join(", ");
    let text =
        if scope.message == held.message { code(&name) } else { code(&format!("{}.{name}", owner.name)) };
    let kind = if found.is_flags { "bits of" } else { "one of" };
    Some(format!(
        "{kind} {}",
        link(&text, &scope.site.href(scope.from, held.message, Part::Enum(held.index)))
    ))
}
