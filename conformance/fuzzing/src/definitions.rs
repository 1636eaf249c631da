//! The fuzz targets for the generator: configurations, catalogues, hints, and the edits of documents in an editor.

#![allow(clippy::missing_panics_doc, reason = "a panic is a finding")]

mod configuration;
mod grammar;
mod hints;
mod replay;

use std::path::Path;

use lsp_types::Position;
use uavspec_codegen::load::Config;
use uavspec_dynamic::Types;
use uavspec_dynamic::conversion::{Conversions, Converter, Request, answer};
use uavspec_schema::msg::Dialect;
use uavspec_schema::source::{SourceMap, Span};
use uavspec_schema::translation::catalogue;
use uavspec_schema::{Form, PackageInput, Schema, read};

use self::replay::{Edit, replay};

/// Reads a text that follows the grammar of `uavspec.toml`, like [`configuration`]. A valid file has a plan with all packages.
pub fn configuration_grammar(data: &[u8]) {
    let text = configuration::text(data);
    configuration(text.as_bytes());
    let planned = Config::parse(Path::new("uavspec.toml"), text.clone()).and_then(Config::plan);
    let planned = planned.map_or(0, |plan| plan.packages.len());
    assert!(planned == 0 || planned == text.matches("[[package]]").count(), "{planned} packages: {text}");
}

/// Reads `uavspec.toml`. An error must name a line of the file.
pub fn configuration(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let path = Path::new("uavspec.toml");
    let Err(failure) = Config::parse(path, text.to_owned()).and_then(Config::plan) else { return };
    let failure = failure.to_string();
    let line = failure.split_once("uavspec.toml:").and_then(|(_, rest)| rest.split(':').next()?.parse().ok());
    let lines = text.split('\n').count();
    assert!(line.is_none_or(|line: usize| (1..=lines).contains(&line)), "{lines} lines: {failure}");
}

/// Reads a translation catalogue. A catalogue without problems must stay the same if it is printed and read again.
pub fn translations(data: &[u8]) {
    let Some((read, is_correct)) = read_catalogue(data.to_vec()) else { return };
    if !is_correct {
        return;
    }
    let printed = catalogue::print(&read);
    let again = read_catalogue(printed.clone().into_bytes());
    assert_eq!(again, Some((read, true)), "{printed}");
}

/// The catalogue, and true if it has no problems.
fn read_catalogue(data: Vec<u8>) -> Option<(catalogue::Catalogue, bool)> {
    let mut sources = SourceMap::default();
    let id = sources.add("uk.po", data).ok()?;
    let (read, places, diagnostics) = catalogue::parse(&sources, id);
    assert_eq!(read.entries.len(), places.len());
    for diagnostic in &diagnostics {
        check_span(&sources, diagnostic.span);
    }
    Some((read, diagnostics.is_empty()))
}

/// The definitions that fuzzed hints convert.
const CONVERTED: [(&str, &str); 4] = [
    (
        "old",
        "uint32 MESSAGE_VERSION = 0\nuint8 MODE_A = 0\nuint8 MODE_B = 1\nuint8 mode  # [@enum MODE]\nbool is_on\nfloat32 sink\nint64 count\nuint16[2] list\n",
    ),
    (
        "new",
        "uint32 MESSAGE_VERSION = 1\nuint8 MODE_A = 1\nuint8 MODE_C = 2\nuint16 mode  # [@enum MODE]\nbool is_on\nfloat64 sink\nint8 count\nuint16[3] list\nuint32 mask\n",
    ),
    ("old", "uint8 a\n# TOPICS tow\n"),
    ("new", "uint8 a\n# TOPICS tow\n"),
];

/// Reads hints, and converts a message with them. The generated code must be valid Rust.
pub fn hints(data: &[u8]) {
    let mut sources = SourceMap::default();
    let mut packages: Vec<PackageInput> = Vec::new();
    for (at, (package, text)) in CONVERTED.into_iter().enumerate() {
        let name = if at < 2 { "Glider" } else { "Tow" };
        let Ok(id) = sources.add(format!("{package}/{name}.msg"), text.into()) else { return };
        match packages.iter_mut().find(|found| found.name == package) {
            Some(found) => found.sources.push(id),
            None => packages.push(PackageInput::new(package, Form::Msg(Dialect::Px4), vec![id])),
        }
    }
    let (schema, _) = read(&sources, &packages);
    let Ok(id) = sources.add("hints.toml", data.to_vec()) else { return };
    let request = Request { from: "old".to_owned(), to: "new".to_owned(), hints: Some(id) };
    for answer in answer(&sources, &schema, &[request]) {
        for mistake in answer.mistakes().iter().chain(&answer.unused(&schema)) {
            check_span(&sources, mistake.span);
        }
        convert(&schema, &answer.conversions);
        {
            let options = uavspec_emit::rust::Options::default();
            let files =
                uavspec_emit::rust::emit_with_conversions(&schema, &sources, &answer.conversions, &options);
            let invalid = files.iter().find(|file| file.text.contains("compile_error!"));
            assert!(invalid.is_none(), "{invalid:?}");
        }
    }
}

/// Reads hints that follow the grammar, like [`hints`].
pub fn hints_grammar(data: &[u8]) {
    hints(hints::text(data).as_bytes());
}

/// Converts the initial message of each decided conversion. The result must have the type of the target.
fn convert(schema: &Schema, conversions: &[Conversions]) {
    let types = Types::new(schema);
    for found in conversions.iter().flat_map(|found| found.forward.iter().chain(&found.backward)) {
        let [source, target] = [found.from, found.to].map(|id| types.get(id));
        let Ok(converted) = Converter::new(found, source, target).convert(&source.default()) else { return };
        let Ok(converted) = converted.to_json() else { return };
        let read = target.from_json(&converted).map(|_| ());
        assert!(!found.is_decided() || read.is_ok(), "{read:?}: {converted}");
    }
}

/// Texts that an editor inserts. The byte of an edit selects one, so a few bytes cover much of the language.
const INSERTED: [&str; 25] = [
    "",
    "#",
    "[",
    "]",
    "[@",
    "[@enum ",
    "[@range 0, ",
    "@count marks]",
    "\n",
    " ",
    "uint8",
    "Mark",
    "Mark[3]",
    "MODE_A = 1",
    "=",
    "/",
    ".",
    "é𝄞",
    "\u{a0}",
    "---",
    "| 64 | A | code 66 |",
    "# TOPICS ",
    "uavspec:ignore unit-missing",
    "string<=3",
    "\r\n",
];

/// The documents that fuzzed edits change.
const EDITED: [(&str, &str); 4] = [
    ("msg/Mark.msg", "# A mark\n\nuint64 timestamp  # [us] Time\nfloat32 height  # [m] Height\n"),
    (
        "msg/Tow.msg",
        "uint8 MODE_A = 0  # A\nuint8 MODE_B = 1  # B\nuint8 mode  # [@enum MODE] Mode\nMark[3] marks\nuint8 num  # [@count marks]\n",
    ),
    ("srv/Start.srv", "Mark mark\n---\nbool ok\n"),
    (
        "page.md",
        "# Warnings (codes 64-127)\n\n| Code | Abbr | Description |\n|-|-|-|\n| 64 | A | Use code 66 |\n| 66 | B | B |\n",
    ),
];

/// Replays edits of documents in the language server. Four bytes are an edit: the document and the text, the line, the
/// column, and the length of the replaced text.
pub fn edits(data: &[u8]) {
    let position = |line: u8, character: u8| Position { line: line.into(), character: character.into() };
    let edit = |bytes: &[u8]| Edit {
        document: usize::from(bytes[0] >> 6),
        range: [
            position(bytes[1], bytes[2]),
            position(bytes[1].saturating_add(bytes[3] >> 5), bytes[2].saturating_add(bytes[3] & 31)),
        ],
        text: INSERTED[usize::from(bytes[0] & 63) % INSERTED.len()],
    };
    // An edit reads all documents, so a few are enough.
    let edits: Vec<Edit<'_>> = data.chunks_exact(4).take(32).map(edit).collect();
    replay(&EDITED, &edits);
}

/// A span must be within its source, and must not split a character.
fn check_span(sources: &SourceMap, span: Span) {
    assert!(sources.contains(span), "{span:?}");
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use uavspec_test_support::extent;

    use super::{configuration, hints, translations};

    /// The configuration with this number of cases, or with a part of them in a quick run.
    fn config(cases: u32, part: u32) -> ProptestConfig {
        let cases = extent(cases, cases / part);
        ProptestConfig { failure_persistence: None, cases, ..ProptestConfig::default() }
    }

    proptest! {
        #![proptest_config(config(ProptestConfig::default().cases, 6))]

        #[test]
        fn random_configurations_have_located_errors(data in prop::collection::vec(any::<u8>(), 0..40)) {
            super::configuration_grammar(&data);
        }

        #[test]
        fn random_hints_cause_no_panic_and_no_invalid_code(data in prop::collection::vec(any::<u8>(), 0..60)) {
            super::hints_grammar(&data);
        }
    }

    proptest! {
        // Each edit is followed by all requests.
        #![proptest_config(config(24, 2))]

        #[test]
        fn random_edits_cause_no_panic(data in prop::collection::vec(any::<[u8; 4]>(), 1..8)) {
            super::edits(&data.concat());
        }
    }

    #[test]
    fn the_properties_hold_for_correct_and_truncated_files() {
        let config = "[output]\nrust = \"out\"\n\n[[package]]\nname = \"demo\"\ndialect = \"px4\"\ninclude = [\"*.msg\"]\n";
        let catalogue = "# note\nmsgid \"\"\nmsgstr \"\"\n\"Language: uk\\n\"\n\n#, fuzzy\nmsgctxt \"a\"\nmsgid \"b\"\nmsgstr \"c\"\n";
        let converted = "[[hint]]\nmessage = \"Glider\"\nversions = [0, 1]\nnew.mode = { MODE_B = \"MODE_C\" }\n\
                         old.mode = { MODE_C = \"MODE_B\" }\nnew.mask = \"if old.MODE_B < mode and not is_on then 7 else count\"\n\
                         narrow = { sink = \"nearest\", count = \"neutral\" }\nsame = [\"list\"]\n";
        for (check, text) in
            [(configuration as fn(&[u8]), config), (translations, catalogue), (hints, converted)]
        {
            for end in (0..text.len()).step_by(extent(1, 7)).chain([text.len()]) {
                check(&text.as_bytes()[..end]);
            }
        }
    }
}
