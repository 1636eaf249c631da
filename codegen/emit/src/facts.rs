//! Facts in the documentation of generated code: units, ranges and other annotations.

use uavspec_schema::json_type::Limits;
use uavspec_schema::value::Value;
use uavspec_schema::{Field, Message, Range, prose, unit};

/// The form of texts in documentation.
#[derive(Clone, Copy)]
pub(crate) struct Style {
    /// Formats a value or a name.
    code: fn(&str) -> String,
    /// Formats a text of a definition.
    inline: fn(&str) -> String,
}

/// Plain text.
pub(crate) const PLAIN: Style = Style { code: str::to_owned, inline: str::to_owned };

/// Markdown.
pub(crate) const MARKDOWN: Style = Style { code: prose::code, inline: prose::inline };

impl Style {
    /// The facts about a field of a message, except facts about its type.
    pub(crate) fn field(self, message: &Message, field: &Field) -> Vec<String> {
        let group = field.group.and_then(|group| message.groups.get(group));
        let mut facts: Vec<String> =
            group.map(|group| format!("group: {}", (self.inline)(&group.summary))).into_iter().collect();
        facts.extend(self.unit(field.unit.as_deref()));
        facts.extend(field.constraints.iter().filter_map(|found| found.fact(self.code, self.inline)));
        let attributes = field.attributes();
        facts.extend(attributes.map(|(attribute, text)| attribute.to_text(&(self.inline)(text))));
        facts
    }

    /// The annotations of a value defined on a page.
    pub(crate) fn limits(self, limits: &Limits) -> Vec<String> {
        let int = |value: u32| Value::Int(value.into());
        let length = Range { low: limits.min.map(int), high: limits.max.map(int) };
        let mut facts: Vec<String> = self.unit(limits.unit.as_deref()).into_iter().collect();
        facts.extend(limits.range.as_ref().and_then(Range::to_text).map(|range| format!("range: {range}")));
        facts.extend(length.to_text().map(|length| format!("length: {length}")));
        facts.extend(limits.is_unique.then(|| "elements are unique".to_owned()));
        facts.extend(limits.pattern.as_ref().map(|pattern| format!("pattern: {}", (self.code)(pattern))));
        facts.extend(limits.format.as_ref().map(|format| format!("format: {}", (self.inline)(format))));
        facts
    }

    /// The unit, unless the symbol means "no unit".
    pub(crate) fn unit(self, symbol: Option<&str>) -> Option<String> {
        let symbol = symbol.filter(|symbol| *symbol != unit::NONE)?;
        let name = unit::lookup(symbol).map_or_else(String::new, |unit| format!(" ({})", unit.name));
        Some(format!("unit: {}{name}", (self.inline)(symbol)))
    }
}

/// Joins a description and a paragraph that lists facts.
pub(crate) fn with_facts(description: &str, facts: &[String]) -> String {
    let facts = facts.join("; ");
    let mut text = description.trim().to_owned();
    let Some(first) = facts.chars().next() else { return text };
    if !text.is_empty() {
        text.push_str("\n\n");
    }
    text.extend(first.to_uppercase());
    text.push_str(&facts[first.len_utf8()..]);
    text.push('.');
    text
}
