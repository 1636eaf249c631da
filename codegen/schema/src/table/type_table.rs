//! Reads tables that define types and messages. The tables are recognized by their header and heading.
//!
//! | header | defines |
//! |---|---|
//! | `Field`, `Required`, `Type`, `Description` | a JSON object |
//! | `Index`, `Element`, `Required`, `Type`, `Description` | a JSON array with a meaning for each position |
//! | `Value`, `Description` | a set of strings or integers |
//!
//! A heading defines a named type if it has none of these tables and its first paragraph starts with a built-in type:
//! `integer, [ms] Milliseconds since the epoch`. A heading with the subheadings `Request`, `Response` and
//! `Notification` defines a message.

mod columns;
mod expression;
mod message;
mod note;
mod reader;

use self::columns::Header;
pub use self::expression::{Expression, ExpressionKind, is_type_name};
pub(crate) use self::expression::{built_in_name, is_number};
pub use self::message::Direction;
pub(crate) use self::message::{MessageDefinition, PartDefinition};
use self::reader::Reader;
pub use self::reader::{Body, Entry, Member, TypeDefinition};
use super::page::Page;
use crate::diagnostic::Diagnostic;

/// The types and messages of a page.
#[derive(Debug, Default)]
pub struct Definitions<'p> {
    /// The types, in order.
    pub types: Vec<TypeDefinition<'p>>,
    /// The messages, in order.
    pub messages: Vec<MessageDefinition<'p>>,
}

/// Reads the types and messages of a page.
pub fn read(page: &Page) -> (Definitions<'_>, Vec<Diagnostic>) {
    let mut reader = Reader { page, diagnostics: Vec::new(), is_defined: vec![false; page.headings.len()] };
    let messages = message::headings(page);
    let mut is_part = vec![false; page.headings.len()];
    let mut is_message = vec![false; page.headings.len()];
    for message in &messages {
        is_message[message.index()] = true;
        message.parts().for_each(|part| is_part[part] = true);
    }
    let mut definitions = Definitions::default();
    for table in &page.tables {
        match columns::header_of(table) {
            Some(Header::Near(columns)) => reader.report_near_miss(table, columns),
            Some(Header::Known(columns)) if !table.heading.is_some_and(|heading| is_part[heading]) => {
                definitions.types.extend(reader.type_of_table(table, &columns));
            }
            Some(Header::Known(_)) | None => {}
        }
    }
    for index in 0..page.headings.len() {
        if !reader.is_defined[index] && !is_message[index] && !is_part[index] {
            definitions.types.extend(reader.named_type(index));
        }
    }
    definitions.types.sort_by_key(|definition| definition.span);
    definitions.messages = messages.iter().filter_map(|message| reader.message(message)).collect();
    (definitions, reader.diagnostics)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::SourceMap;
    use crate::table::text::Text;

    fn page(text: &str) -> Page {
        let mut sources = SourceMap::default();
        let id = sources.add("page.md", text.into()).expect("valid");
        crate::table::parse(&sources, id).0
    }

    fn codes(text: &str) -> Vec<&'static str> {
        read(&page(text)).1.iter().map(|diagnostic| diagnostic.problem.code()).collect()
    }

    #[test]
    fn header_and_heading_determine_the_definition() {
        let page = page(
            "# Gliders\n\n## Mark\n\nA turning point. Closed object.\n\n|Field|Required|Type|Description|\n|-|-|-|-|\n\
             |name|yes|string|[@length 1, 8] Its name|\n\n## Wind\n\n|Description|Element|Index|Type|Required|\n|-|-|-|-|-|\n\
             |[m/s] Speed|speed|0|number|Yes|\n\n## Phase\n\nAn open set.\n\n|Value|Description|\n|-|-|\n|thermal|Circling|\n\n\
             ## Height\n\ninteger, [m] Above the sea.\n\n[@range 0, 9000]\n",
        );
        let (found, diagnostics) = read(&page);
        assert_eq!(diagnostics, []);
        let names: Vec<&str> = found.types.iter().map(|definition| definition.name).collect();
        assert_eq!(names, ["Mark", "Wind", "Phase", "Height"]);
        assert!(matches!(&found.types[0].body, Body::Object(fields) if fields[0].note.text == "Its name"));
        assert!(matches!(&found.types[1].body, Body::Tuple(elements) if elements[0].is_required));
        assert!(matches!(&found.types[2].body, Body::Set(entries) if entries[0].value == "thermal"));
        let Body::Named { ty, notes } = &found.types[3].body else { panic!("{:?}", found.types[3]) };
        assert_eq!(ty.kind, ExpressionKind::BuiltIn(crate::json_type::Expression::Integer));
        let annotations: Vec<usize> = notes.iter().map(|note| note.annotations.len()).collect();
        assert_eq!(annotations, [1, 1]);
        assert_eq!(notes[0].text, "Above the sea.");
    }

    #[test]
    fn paragraphs_below_a_table_are_remarks() {
        let page = page(
            "# Wind\n\nIt blows.\n\n|Field|Required|Type|Description|\n|-|-|-|-|\n|speed|yes|number|How fast|\n\n\
             Disputed: whether it is a closed object.\n\n# WIND-INF\n\n## Notification\n\n\
             |Field|Required|Type|Description|\n|-|-|-|-|\n|wind|yes|Wind|The wind|\n\nNot stated: when.\n",
        );
        let found = read(&page).0;
        let texts = |texts: &[&Text]| texts.iter().map(|text| text.as_str().to_owned()).collect::<Vec<_>>();
        assert_eq!(texts(&found.types[0].paragraphs), ["It blows."]);
        assert_eq!(texts(&found.types[0].remarks), ["Disputed: whether it is a closed object."]);
        let part = &found.messages[0].parts[0];
        assert_eq!(
            (texts(&part.paragraphs), texts(&part.remarks)),
            (vec![], vec!["Not stated: when.".to_owned()])
        );
    }

    #[test]
    fn prose_defines_nothing() {
        for text in [
            "# Gliders\n\ninteger overflow is no matter, here.\n",
            "# integer\n\nstring\n",
            "# Wind\n\nIt blows.\n\n|A|B|\n|-|-|\n|1|2|\n",
            "# Talk\n\n## Request\n\nAsk politely.\n",
        ] {
            let page = page(text);
            let (found, diagnostics) = read(&page);
            assert!(found.types.is_empty() && found.messages.is_empty() && diagnostics.is_empty(), "{text}");
        }
    }

    #[test]
    fn each_bad_row_and_heading_is_reported() {
        let fields = |rows: &str| format!("|Field|Required|Type|Description|\n|-|-|-|-|\n{rows}");
        assert_eq!(codes(&fields("|a|yes|string|x|\n")), ["missing-heading"]);
        assert_eq!(codes(&format!("# A wind\n{}", fields("|a|yes|string|x|\n"))), ["type-name"]);
        let rows = "|a|maybe|string|x|\n|b c|yes|string|x|\n|d|yes|\n|e|yes|list string|x|\n";
        assert_eq!(
            codes(&format!("# Wind\n{}", fields(rows))),
            ["invalid-required", "invalid-name", "table-shape", "invalid-type-expression"]
        );
        assert_eq!(codes("# Wind\n|Field|Type|Description|\n|-|-|-|\n|a|string|x|\n"), ["near-type-table"]);
    }
}
