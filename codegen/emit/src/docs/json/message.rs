//! The page of a message, with a section for each direction.

use uavspec_schema::JsonMessageId;

use super::directory::{Json, Owner};
use crate::docs::markdown::{Page, Table, code, inline, text_column, unbroken};
use crate::docs::message::package_cell;
use crate::docs::words::ENGLISH;
use crate::file::OutputFile;
use crate::json_schema::Target;

impl Json<'_, '_> {
    /// Creates the page of a message.
    pub(super) fn message_page(&self, id: JsonMessageId) -> OutputFile {
        let message = self.site.schema.json_message(id);
        let from = self.path(&message.name);
        let mut page = Page::new(from, &inline(&message.name));
        page.block(&self.block(from, &message.docs.text()));
        let mut facts = Table::new(&[text_column(""), text_column("")]);
        facts.row([unbroken("Package"), package_cell(ENGLISH, from, self.package)]);
        let line = self.site.sources.position(message.span).line;
        facts.row([unbroken("Definition"), code(&format!("{}:{line}", self.site.source(message.span)))]);
        let directions: Vec<&str> = message.parts.iter().map(|part| part.direction.name()).collect();
        facts.row([unbroken("Directions"), directions.join(", ")]);
        page.table(&facts);
        for part in &message.parts {
            page.heading(2, part.direction.title());
            page.block(&self.block(from, &part.docs.text()));
            if !part.answers.is_empty() {
                let answers: Vec<String> = part.answers.iter().map(|name| self.link(from, name)).collect();
                page.block(&format!("Responses: {}.", answers.join(", ")));
            }
            page.block(&self.site.line_of_files(from, Target::JsonPart(id, part.direction)));
            let owner = Owner::Message(id, part.direction);
            page.block(&format!("`type`: {}.", code(&message.name)));
            if !part.fields().is_empty() {
                self.write_fields(&mut page, from, owner, part.fields());
            }
            page.block(match (part.body.is_closed, part.fields().is_empty()) {
                (true, _) => "Other fields are not allowed.",
                (false, true) => "",
                (false, false) => "Other fields are allowed and ignored.",
            });
        }
        page.finish()
    }
}
