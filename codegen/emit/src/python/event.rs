//! Events: a shared module that decodes them, and the data of each package.

use super::text::{docstring, header};
use crate::binding::{KnownEnum, KnownEvent, KnownEvents, quoted};
use crate::file::OutputFile;

/// The name of the shared module.
const MODULE: &str = "_events";

/// The decoder.
const CODE: &str = include_str!("events/events.py.txt");

const TEXT: &str = "Decodes an event from its id and the bytes of its arguments.\n\nReturns None if this package has no \
                    such event. Raises ValueError if there are too few bytes.";

/// The names that the module of a package exports.
pub(super) const NAMES: [&str; 1] = ["decode_event"];

/// Creates the shared module.
pub(super) fn module() -> OutputFile {
    OutputFile { path: format!("{MODULE}.py"), text: header("the definitions") + CODE }
}

/// The import of the decoder in the module of a package.
pub(super) fn import() -> String {
    format!("from .{MODULE} import DecodedEvent, EventData, decode\n")
}

/// The data of a package, and the function that decodes its events.
pub(super) fn item(known: &KnownEvents) -> String {
    let enums: String = known.enums.iter().map(enumeration).collect();
    let events: String = known.events.iter().map(event).collect();
    format!(
        "_EVENTS: EventData = (
    (
{enums}    ),
    {{
{events}    }},
)


def decode_event(id: int, arguments: bytes) -> \"Optional[DecodedEvent]\":
{}    return decode(_EVENTS, id, arguments)
",
        docstring(TEXT, "    ")
    )
}

fn enumeration(found: &KnownEnum) -> String {
    let entry = |(value, name, label): &(i128, String, String)| {
        format!("{value}: ({}, {})", quoted(name), quoted(label))
    };
    let entries: Vec<String> = found.entries.iter().map(entry).collect();
    let (key, bits, separator) = (quoted(&found.key), found.bits, quoted(&found.separator));
    format!("        ({key}, {bits}, {separator}, {{{}}}),\n", entries.join(", "))
}

fn event(event: &KnownEvent) -> String {
    let argument = |(name, ty, found): &(String, String, Option<usize>)| {
        let found = found.map_or_else(|| "None".to_owned(), |index| index.to_string());
        format!("({}, \"{ty}\", {found}),", quoted(name))
    };
    let arguments: Vec<String> = event.arguments.iter().map(argument).collect();
    let KnownEvent { key, name, group, message, description, .. } = event;
    let texts = [key, name, group, message, description].map(|text| quoted(text));
    format!("        {}: ({}, ({})),\n", event.id, texts.join(", "), arguments.join(" "))
}
