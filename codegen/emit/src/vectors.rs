//! Test vectors: valid and invalid values of each message, as JSON and as bytes. Each invalid case names the violated
//! rule. There are also vectors for error codes, and for types and messages defined on pages.
//!
//! Each type has two files. `<package>/<Name>.vectors.json` tests codecs and validators:
//!
//! ```json
//! {
//!   "form": 1, "type": "px4/Wind", "hash": 305419896, "schema": "https://…/px4/Wind.schema.json",
//!   "cases": [
//!     {"id": "speed-above-range", "description": "…", "valid": false, "rule": "PX-RANGE-01",
//!      "json": {"timestamp": 0, "speed": 60.000004}, "uorb": "0000…", "cdr": "0001…"}
//!   ]
//! }
//! ```
//!
//! - `json` and the bytes represent the same message: the JSON encodes to the bytes, and the bytes decode to the JSON.
//!   A form that can't represent the message is omitted.
//! - `uorb` is the complete payload in memory. `cdr` is little-endian and includes the header. Both payloads are
//!   hexadecimal.
//! - `decoded` replaces `json` if the bytes are valid, but differ from the output of a little-endian encoder. Examples
//!   are big-endian payloads and payloads with different padding.
//! - An invalid case violates exactly one rule. If the case has bytes, they may still decode without error: the rule
//!   determines whether the payload or a value in it is invalid.
//! - Definitions on pages have JSON cases only. The rules `SHAPE-TYPE`, `SHAPE-REQUIRED`, `SHAPE-FURTHER`,
//!   `SHAPE-RANGE`, `SHAPE-LENGTH`, `SHAPE-UNIQUE`, `SHAPE-PATTERN` and `SHAPE-VALUE` name the violated part of the
//!   schema.
//! - Events have `json` with the decoded event, `arguments` with their 25 bytes, and `texts` with the message and the
//!   description for each profile, in English.
//! - An id describes the input, not the result. Adding fields to the message doesn't change the ids.
//!
//! `vectors.schema.json` describes these files.
//!
//! `json-schema-test-suite/tests/draft2020-12/<package>/<Name>.json` is for JSON Schema validators. The files have the
//! format and folder structure of the JSON Schema Test Suite. The test group in each file has a schema that refers to
//! the published schema by `$id`. In these files, a case is valid if the schema accepts it. Undocumented enum values
//! and null floats are therefore valid. Integers are omitted if 64-bit floats can't distinguish them from a bound of
//! their type.
//!
//! There are no cases for messages that have no valid value, are longer than 64 KiB, or are nested more than 32 levels
//! deep.
//!
//! ```
//! # use uavspec_schema::{Form, PackageInput, SourceMap, msg::Dialect, read};
//! # let mut sources = SourceMap::default();
//! # let id = sources.add("Wind.msg", "uint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@range 0, 60] Speed\n".into()).unwrap();
//! # let packages = [PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])];
//! # let (schema, diagnostics) = read(&sources, &packages);
//! use uavspec_emit::vectors::{Options, emit};
//!
//! let files = emit(&schema, &Options::default());
//! let vectors = files.iter().find(|file| file.path == "px4/Wind.vectors.json").unwrap();
//! assert!(vectors.text.contains("PX-RANGE-01"));
//! ```

mod bytes;
mod case;
mod error_code;
mod event;
mod field;
mod form;
mod json_type;
mod message;
mod number;
mod options;
mod part;
mod print;
mod sample;
mod typical;

use uavspec_dynamic::Types;
use uavspec_schema::failure::Failure;
use uavspec_schema::json_type::Direction;
use uavspec_schema::{JsonMessageId, Message, MessageId, Package, Schema};

use self::case::Case;
use self::message::is_uorb;
pub use self::options::Options;
use self::print::{Head, quote};
use super::emitter::{Input, Others, Output};
use super::file::OutputFile;
use super::json_schema::{self, Target};

/// Folder for files in the format of the JSON Schema Test Suite.
const SUITE: &str = "json-schema-test-suite/tests/draft2020-12";

impl Output for Options {
    /// Uses the base of the emitted schemas by default, because the vectors refer to these schemas.
    fn complete(&mut self, others: &Others<'_>) {
        let base = self.base.take();
        self.base = base.or_else(|| others.text("json_schema", "base").map(str::to_owned));
    }

    fn emit(&self, input: Input<'_>) -> Result<Vec<OutputFile>, Failure> {
        Ok(emit(input.schema, self))
    }
}

/// Creates all vectors, sorted by path.
pub fn emit(schema: &Schema, options: &Options) -> Vec<OutputFile> {
    let parts = sample::parts(schema);
    let types = Types::new(schema);
    let emitter = Emitter { schema, options };
    let mut files = vec![form::file(options)];
    for (index, package) in schema.packages.iter().enumerate() {
        for target in json_schema::targets(schema, package, index) {
            let (head, cases) = match target {
                Target::Message(id) => (emitter.message(id), message::cases(schema, id, &parts, &types)),
                Target::ErrorCode(_) => (emitter.head(target, Vec::new()), error_code::codes(package)),
                Target::ErrorList(_) => (emitter.head(target, Vec::new()), error_code::lists(package)),
                Target::JsonType(id) => (emitter.head(target, Vec::new()), json_type::of_type(schema, id)),
                Target::Events(_, component) => {
                    (emitter.head(target, Vec::new()), event::cases(package, &package.components[component]))
                }
                Target::JsonPart(id, direction) => {
                    (emitter.head(target, Vec::new()), emitter.part(id, direction))
                }
            };
            files.extend(emitter.files(target, &head, &cases));
        }
    }
    OutputFile::sort(&mut files);
    files
}

/// A valid JSON message for each type, indexed by message id. Values are typical, and adjacent fields have different
/// values. `None` if the type has no valid value.
pub fn typical(schema: &Schema) -> Vec<Option<String>> {
    let parts = sample::parts(schema);
    let typical = |message| field::message_typical(schema, message, &parts, &mut typical::Typical::default());
    schema.messages.iter().map(typical).collect()
}

struct Emitter<'s> {
    schema: &'s Schema,
    options: &'s Options,
}

impl Emitter<'_> {
    fn files(&self, target: Target, head: &Head, cases: &[Case]) -> impl Iterator<Item = OutputFile> {
        let name = json_schema::name(self.schema, target);
        let vectors = OutputFile { path: format!("{name}.vectors.json"), text: print::vectors(head, cases) };
        let suite = print::suite(head, cases);
        let suite = suite.map(|text| OutputFile { path: format!("{SUITE}/{name}.json"), text });
        [vectors].into_iter().chain(suite)
    }

    fn part(&self, id: JsonMessageId, direction: Direction) -> Vec<Case> {
        let part = self.schema.json_message(id).parts.iter().find(|part| part.direction == direction);
        part.map_or_else(Vec::new, |part| json_type::of_object(self.schema, &part.body))
    }

    fn message(&self, id: MessageId) -> Head {
        let message = self.schema.message(id);
        let package = self.schema.package_of(message);
        self.head(Target::Message(id), facts(package, message))
    }

    fn head(&self, target: Target, facts: Vec<(&'static str, String)>) -> Head {
        Head {
            facts,
            title: json_schema::name(self.schema, target),
            schema: json_schema::id(self.schema, target, &self.options.schemas()),
        }
    }
}

/// Facts that identify the definition, such as hashes.
fn facts(package: &Package, message: &Message) -> Vec<(&'static str, String)> {
    let mut facts = Vec::new();
    if let Some(version) = message.version {
        facts.push(("version", version.to_string()));
    }
    if is_uorb(package, message) {
        facts.push(("hash", message.hash.to_string()));
    }
    facts.push(("type_hash", quote(&message.type_hash)));
    facts
}
