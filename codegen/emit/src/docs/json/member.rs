//! Tables of fields and elements.

use uavspec_schema::json_type::{Expression, Limits, Member};
use uavspec_schema::value::Value;

use super::directory::{Json, Owner, anchor_of};
use crate::docs::cell::{range, unit};
use crate::docs::error_codes;
use crate::docs::markdown::{Page, Table, anchor, code, href, inline, link, number_column, text_column};
use crate::docs::words::ENGLISH;

impl Json<'_, '_> {
    /// Writes the fields of an object.
    pub(super) fn write_fields(&self, page: &mut Page, from: &str, owner: Owner, fields: &[Member]) {
        if fields.is_empty() {
            page.block("None.");
            return;
        }
        let columns = [
            text_column("Field"),
            text_column("Required"),
            text_column("Type"),
            text_column("Unit"),
            text_column("Values"),
            text_column("Description"),
        ];
        let mut table = Table::new(&columns);
        for field in fields {
            table.row(self.cells(from, owner, field));
        }
        page.table(&table);
    }

    /// Writes the elements of a tuple.
    pub(super) fn write_elements(&self, page: &mut Page, from: &str, owner: Owner, elements: &[Member]) {
        let columns = [
            number_column("Index"),
            text_column("Element"),
            text_column("Required"),
            text_column("Type"),
            text_column("Unit"),
            text_column("Values"),
            text_column("Description"),
        ];
        let mut table = Table::new(&columns);
        for (index, element) in elements.iter().enumerate() {
            table.row([index.to_string()].into_iter().chain(self.cells(from, owner, element)));
        }
        page.table(&table);
    }

    fn cells(&self, from: &str, owner: Owner, member: &Member) -> [String; 6] {
        let limits = &member.typed.limits;
        [
            anchor(&anchor_of(owner, member)) + &code(&member.name),
            if member.is_required { "yes" } else { "no" }.to_owned(),
            self.type_cell(from, &member.typed.ty),
            unit(limits.unit.as_deref()),
            values(limits).join("<br>"),
            self.inline(from, &member.description),
        ]
    }

    /// Formats a type. Named types link to their pages.
    pub(super) fn type_cell(&self, from: &str, expression: &Expression) -> String {
        let inner = |inner: &Expression| {
            let text = self.type_cell(from, inner);
            if matches!(inner, Expression::Either(_)) { format!("({text})") } else { text }
        };
        match expression {
            Expression::Named(id) => self.link(from, &self.site.schema.json_type(*id).name),
            Expression::ErrorCode | Expression::ErrorList => {
                let name = self.site.schema.expression_text(expression, &str::to_owned);
                link(&code(&name), &href(from, &error_codes::overview_path(self.package), ""))
            }
            Expression::List(element) => format!("list of {}", inner(element)),
            Expression::Map(value) => format!("map of {}", inner(value)),
            Expression::Either(all) => all.iter().map(inner).collect::<Vec<_>>().join(" or "),
            Expression::OneOf(constants) => {
                let constants: Vec<String> = constants.iter().map(|constant| json_code(constant)).collect();
                format!("one of {}", constants.join(", "))
            }
            plain => inline(&self.site.schema.expression_text(plain, &str::to_owned)),
        }
    }
}

/// A string as a JSON literal, formatted as code.
pub(super) fn json_code(text: &str) -> String {
    code(&serde_json::Value::from(text).to_string())
}

/// The constraints of a value, one per line.
pub(super) fn values(limits: &Limits) -> Vec<String> {
    let mut lines = Vec::new();
    lines.extend(limits.range.as_ref().and_then(|bounds| range(ENGLISH, bounds)));
    let int = |value: u32| Value::Int(value.into());
    let length = uavspec_schema::Range { low: limits.min.map(int), high: limits.max.map(int) };
    lines.extend(range(ENGLISH, &length).map(|length| format!("length {length}")));
    lines.extend(limits.is_unique.then(|| "unique elements".to_owned()));
    lines.extend(limits.pattern.as_ref().map(|pattern| format!("pattern {}", code(pattern))));
    lines.extend(limits.format.as_ref().map(|format| inline(format)));
    lines
}
