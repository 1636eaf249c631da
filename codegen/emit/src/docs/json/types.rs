//! The page of a type.

use uavspec_schema::JsonTypeId;
use uavspec_schema::json_type::{Definition, Set, SetValue, SetValues};

use super::directory::{Json, Owner, kind};
use super::member::{json_code, values};
use crate::docs::cell::unit;
use crate::docs::markdown::{Page, Table, code, inline, text_column, unbroken};
use crate::docs::message::package_cell;
use crate::docs::words::ENGLISH;
use crate::file::OutputFile;
use crate::json_schema::Target;

impl Json<'_, '_> {
    /// Creates the page of a type.
    pub(super) fn type_page(&self, id: JsonTypeId) -> OutputFile {
        let found = self.site.schema.json_type(id);
        let from = self.path(&found.name);
        let mut page = Page::new(from, &inline(&found.name));
        page.block(&self.block(from, &found.docs.text()));
        page.table(&self.type_facts(id, from));
        let owner = Owner::Type(id);
        match &found.definition {
            Definition::Object(object) => {
                page.heading(2, "Fields");
                self.write_fields(&mut page, from, owner, &object.fields);
                page.block(if object.is_closed {
                    "Other fields are not allowed."
                } else {
                    "Other fields are allowed and ignored."
                });
            }
            Definition::Tuple(elements) => {
                page.heading(2, "Elements");
                self.write_elements(&mut page, from, owner, elements);
                if elements.iter().any(|element| !element.is_required) {
                    page.block("Optional elements at the end may be omitted.");
                }
            }
            Definition::Set(set) => {
                page.heading(2, "Values");
                self.write_set(&mut page, from, set);
            }
            Definition::Named(_) => {}
        }
        self.write_users(&mut page, from, id);
        page.finish()
    }

    fn type_facts(&self, id: JsonTypeId, from: &str) -> Table {
        let found = self.site.schema.json_type(id);
        let mut table = Table::new(&[text_column(""), text_column("")]);
        let mut fact = |name: &str, value: String| {
            if !value.is_empty() {
                table.row([unbroken(name), value]);
            }
        };
        fact("Package", package_cell(ENGLISH, from, self.package));
        let line = self.site.sources.position(found.span).line;
        fact("Definition", code(&format!("{}:{line}", self.site.source(found.span))));
        fact("Kind", kind(&found.definition).to_owned());
        if let Definition::Named(typed) = &found.definition {
            fact("JSON", self.type_cell(from, &typed.ty));
            fact("Unit", unit(typed.limits.unit.as_deref()));
            fact("Values", values(&typed.limits).join("<br>"));
        }
        for (name, file) in self.site.files(from, Target::JsonType(id)) {
            fact(name, file);
        }
        table
    }

    fn write_set(&self, page: &mut Page, from: &str, set: &Set) {
        let mut table = Table::new(&[text_column("Value"), text_column("Description")]);
        match &set.values {
            SetValues::Integers(values) => {
                for SetValue { value, description } in values {
                    table.row([code(&value.to_string()), self.inline(from, description)]);
                }
            }
            SetValues::Strings(values) => {
                for SetValue { value, description } in values {
                    table.row([json_code(value), self.inline(from, description)]);
                }
            }
        }
        page.table(&table);
        page.block(if set.is_open { "Other values are allowed." } else { "Other values are not allowed." });
    }

    fn write_users(&self, page: &mut Page, from: &str, id: JsonTypeId) {
        let users = self.users(id);
        if users.is_empty() {
            return;
        }
        page.heading(2, "Used by");
        page.gap();
        for user in users {
            page.item(0, &self.user_link(from, *user));
        }
    }
}
