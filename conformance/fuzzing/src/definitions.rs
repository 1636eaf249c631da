//! The fuzz targets for the generator: configurations, catalogues, hints, and the edits of documents in an editor.

mod configuration;
pub(super) mod grammar;
mod hints;
mod replay;

use std::path::Path;

use lsp_types::Position;
use uavspec_codegen::load::Config;
use uavspec_definitions::PX4_HINTS;
use uavspec_dynamic::Types;
use uavspec_dynamic::conversion::{Conversions, Converter, Request, answer};
use uavspec_schema::msg::Dialect;
use uavspec_schema::source::{SourceMap, Span};
use uavspec_schema::translation::catalogue;
use uavspec_schema::{Form, PackageInput, Schema, read};

use self::replay::{Edit, replay};

/// Reads a text that follows the grammar of `uavspec.toml`, like [`configuration`]. For a valid file, the plan must
/// contain all packages.
pub(super) fn configuration_grammar(data: &[u8]) {
    let text = configuration::text(data);
    configuration(text.as_bytes());
    let planned = Config::parse(Path::new("uavspec.toml"), text.clone()).and_then(Config::plan);
    let planned = planned.map_or(0, |plan| plan.packages.len());
    assert!(planned == 0 || planned == text.matches("[[package]]").count(), "{planned} packages: {text}");
}

/// Reads `uavspec.toml`. An error must name a line of the file.
pub(super) fn configuration(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else { return };
    let path = Path::new("uavspec.toml");
    let Err(failure) = Config::parse(path, text.to_owned()).and_then(Config::plan) else { return };
    let failure = failure.to_string();
    let line = failure.split_once("uavspec.toml:").and_then(|(_, rest)| rest.split(':').next()?.parse().ok());
    let lines = text.split('\n').count();
    assert!(line.is_none_or(|line: usize| (1..=lines).contains(&line)), "{lines} lines: {failure}");
}

/// Reads a translation catalogue. If it has no problems, printing it and reading it again must not change it.
pub(super) fn translations(data: &[u8]) {
    let Some((read, is_correct)) = read_catalogue(data.to_vec()) else { return };
    if !is_correct {
        return;
    }
    let printed = catalogue::print(&read);
    let again = read_catalogue(printed.clone().into_bytes());
    assert_eq!(again, Some((read, true)), "{printed}");
}

/// The catalogue, and a flag that is true if it has no problems.
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

/// The definitions that are converted with fuzzed hints.
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
pub(super) fn hints(data: &[u8]) {
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
        let options = uavspec_emit::rust::Options::default();
        let files =
            uavspec_emit::rust::emit_with_conversions(&schema, &sources, &answer.conversions, &options);
        let invalid = files.iter().find(|file| file.text.contains("compile_error!"));
        assert!(invalid.is_none(), "{invalid:?}");
    }
}

/// Reads hints that follow the grammar, like [`hints`].
pub(super) fn hints_grammar(data: &[u8]) {
    hints(hints::text(data).as_bytes());
}

/// Converts the initial message of each conversion that is fully decided. The result must have the target's type.
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

/// Texts that an editor inserts. One byte of an edit selects the text, so a few bytes cover much of the language.
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

/// Replays edits of documents in the language server. Each edit consists of four bytes: the document and the text, the
/// line, the column, and the length of the replaced text.
pub(super) fn edits(data: &[u8]) {
    let position = |line: u8, character: u8| Position { line: line.into(), character: character.into() };
    let edit = |bytes: &[u8]| Edit {
        document: usize::from(bytes[0] >> 6),
        range: [
            position(bytes[1], bytes[2]),
            position(bytes[1].saturating_add(bytes[3] >> 5), bytes[2].saturating_add(bytes[3] & 31)),
        ],
        text: INSERTED[usize::from(bytes[0] & 63) % INSERTED.len()],
    };
    // For each edit, all documents are read, so only a few edits are used.
    let edits: Vec<Edit<'_>> = data.chunks_exact(4).take(32).map(edit).collect();
    replay(&EDITED, &edits);
}

/// Asserts that a span is within its source, and doesn't split a character.
fn check_span(sources: &SourceMap, span: Span) {
    assert!(sources.contains(span), "{span:?}");
}

/// Edits of documents. Each edit consists of four bytes.
pub(super) fn edit_seeds() -> Vec<Vec<u8>> {
    let steps = (0..4_u8)
        .flat_map(|document| (0..24_u8).map(move |text| [document << 6 | text, text % 6, text, text % 64]));
    steps.collect::<Vec<_>>().chunks(16).map(<[[u8; 4]]>::concat).collect()
}

/// Files of `uavspec.toml`.
pub(super) fn configuration_seeds() -> Vec<Vec<u8>> {
    let own = include_bytes!("../../../definitions/uavspec.toml").to_vec();
    let lint = b"[[package]]\nname = \"demo\"\ndialect = \"ros2\"\ninclude = [\"*.msg\"]\nselect = [\"A\"]\n\n[lint]\n\
                 preset = \"strict\"\n\n[lint.levels]\nunit-missing = \"off\"\n\n[[lint.ignore]]\nrule = \"name-style\"\n\
                 path = \"a/*\"\nreason = \"old\"\n\n[output.rust]\npath = \"out\"\n";
    vec![own, lint.to_vec()]
}

/// Hints for conversions.
pub(super) fn hint_seeds() -> Vec<Vec<u8>> {
    let constants = "[[hint]]\nmessage = \"Glider\"\nversions = [0, 1]\nnew.mode = { MODE_B = \"MODE_C\" }\n\
                     old.mode = \"if mode == 2 then MODE_B else old.MODE_A\"\nrename = { sink = \"sink\" }\n";
    let policies = "[[hint]]\nold_message = \"Tow\"\nnew_message = \"Tow\"\ntopic = \"tow\"\n\n[[hint]]\nmessage = \"Glider\"\n\
                    narrow = { sink = \"nearest\", count = \"neutral\" }\nsame = [\"MODE_A\"]\n\
                    new.mask = \"count & ~0xff | 1 + 2 * 3\"\nnew.is_on = \"not is_on or sink / 2 >= nan and true\"\n";
    vec![constants.into(), policies.into(), PX4_HINTS.into()]
}

/// Translation catalogues.
pub(super) fn translation_seeds() -> Vec<Vec<u8>> {
    let entries = "# note\nmsgid \"\"\nmsgstr \"\"\n\"Language: uk\\n\"\n\n#. note\n#: a.msg:1\n#, fuzzy\n#| msgid \"was\"\n\
                   msgctxt \"px4/A\"\nmsgid \"b \\\"c\\\"\\n\"\nmsgstr \"\"\n\"d\\n\"\n\"e\"\n\n#~ msgid \"old\"\n#~ msgstr \"x\"\n\n# end\n";
    vec![entries.as_bytes().to_vec()]
}
