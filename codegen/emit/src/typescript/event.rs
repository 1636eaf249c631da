//! Events: a shared module that decodes them, and the data of each package.

use super::comment;
use super::comment::header;
use super::language::Language;
use crate::binding::{KnownEnum, KnownEvent, KnownEvents, quoted};
use crate::file::OutputFile;

/// The name of the shared module.
const MODULE: &str = "events";

const TYPES: &str = include_str!("events/types.ts.txt");

/// The decoder. Types are in comments such as `/*: number*/`.
const CODE: &str = include_str!("events/events.ts.txt");

const TEXT: &str = "Decodes an event from its id and the bytes of its arguments. Returns null if this package has no such \
                    event. Throws a RangeError if there are too few bytes.";

/// Creates the shared module.
pub(super) fn module(language: Language) -> OutputFile {
    let body = match language {
        Language::TypeScript => format!("{TYPES}\n{}", code(|ty| ty)),
        Language::JavaScript => code(|_| ""),
        Language::CommonJs => {
            "\"use strict\";\n\n".to_owned()
                + &code(|_| "").replace("export function decode(", "exports.decode = function decode(")
        }
        Language::Declarations => TYPES.to_owned(),
    };
    OutputFile { path: format!("{MODULE}.{}", language.extension()), text: header("the definitions") + &body }
}

/// The decoder with type annotations replaced by `annotation`.
fn code(annotation: impl Fn(&str) -> &str) -> String {
    let mut parts = CODE.split("/*:");
    let mut code = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (ty, after) = part.split_once("*/").unwrap_or((part, ""));
        let ty = annotation(ty);
        if !ty.is_empty() {
            code.extend([":", ty]);
        }
        code.push_str(after);
    }
    code
}

/// The import of the decoder in the module of a package.
pub(super) fn import(language: Language) -> String {
    let extension = language.imported_extension();
    match language {
        Language::TypeScript => format!(
            "import {{ decode }} from \"./{MODULE}.{extension}\";\n\
             import type {{ DecodedEvent, EventData }} from \"./{MODULE}.{extension}\";\n\n"
        ),
        Language::JavaScript => format!("import {{ decode }} from \"./{MODULE}.{extension}\";\n\n"),
        Language::CommonJs => format!("const {{ decode }} = require(\"./{MODULE}.{extension}\");\n\n"),
        Language::Declarations => {
            format!("import type {{ DecodedEvent }} from \"./{MODULE}.{extension}\";\n\n")
        }
    }
}

/// The data of a package, and the function that decodes its events.
pub(super) fn item(known: &KnownEvents, language: Language) -> String {
    let documentation = comment::block(TEXT, "");
    let types = "(id: number, bytes: Uint8Array): DecodedEvent | null";
    let (documentation, head, data_type) = match language {
        Language::Declarations => {
            return format!("{documentation}export declare function decodeEvent{types};\n");
        }
        Language::TypeScript => (documentation, format!("export function decodeEvent{types}"), ": EventData"),
        Language::JavaScript => (String::new(), "export function decodeEvent(id, bytes)".to_owned(), ""),
        Language::CommonJs => {
            (String::new(), "exports.decodeEvent = function decodeEvent(id, bytes)".to_owned(), "")
        }
    };
    let enums: String = known.enums.iter().map(enumeration).collect();
    let events: String = known.events.iter().map(event).collect();
    format!(
        "const data{data_type} = {{
  enums: [
{enums}  ],
  events: [
{events}  ],
}};

{documentation}{head} {{
  return decode(data, id, bytes);
}}
"
    )
}

fn enumeration(found: &KnownEnum) -> String {
    let entry = |(value, name, label): &(i128, String, String)| {
        format!("[\"{value}\", {}, {}]", quoted(name), quoted(label))
    };
    let entries: Vec<String> = found.entries.iter().map(entry).collect();
    let (key, bits, separator) = (quoted(&found.key), found.bits, quoted(&found.separator));
    format!("    [{key}, {bits}, {separator}, [{}]],\n", entries.join(", "))
}

fn event(event: &KnownEvent) -> String {
    let argument = |(name, ty, found): &(String, String, Option<usize>)| {
        let found = found.map_or_else(|| "null".to_owned(), |index| index.to_string());
        format!("[{}, \"{ty}\", {found}]", quoted(name))
    };
    let arguments: Vec<String> = event.arguments.iter().map(argument).collect();
    let KnownEvent { key, name, group, message, description, .. } = event;
    let texts = [key, name, group, message, description].map(|text| quoted(text));
    format!("    [{}, {}, [{}]],\n", event.id, texts.join(", "), arguments.join(", "))
}
