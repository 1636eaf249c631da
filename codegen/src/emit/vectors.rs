//! Test vectors: for each message values that it may have and others that it may not, as JSON and as
//! bytes, with the rule that is broken; and the same for error codes, and for the types and messages of pages.
//!
//! There are two files for each type. `<package>/<Name>.vectors.json` tests codecs and validators:
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
//! - `json` and the bytes are the same message: each encodes to, and decodes from, the other. Members
//!   are absent where a case has no such form.
//! - `uorb` is the whole payload in memory, `cdr` is little-endian with its header, both in hexadecimal.
//! - `decoded` stands in the place of `json` where the bytes are right, but a little-endian encoder gives
//!   others: big-endian ones, and those with other padding.
//! - An invalid case breaks `rule` and no other. If it has bytes, decoding them need not fail: the rule
//!   tells whether what is wrong is the payload, or a value in it.
//! - What pages define is JSON alone. The rules that its cases break, `SHAPE-TYPE`, `SHAPE-REQUIRED`, `SHAPE-FURTHER`,
//!   `SHAPE-RANGE`, `SHAPE-LENGTH`, `SHAPE-UNIQUE`, `SHAPE-PATTERN` and `SHAPE-VALUE`, say which part of the shape it is.
//! - An id says what is tried, not what comes of it. It stays when fields are added to the message.
//!
//! `vectors.schema.json` describes these files.
//!
//! `json-schema-test-suite/tests/draft2020-12/<package>/<Name>.json` is for validators of JSON Schema, in
//! the form and the folders of that suite: a group whose schema refers to the published one by its
//! `$id`. What counts there is what the schema says: it lets undocumented values of an enum through, and
//! null in the place of any float. The neighbours of 64-bit integers that 64-bit floats can't tell from
//! those are left out there.
//!
//! Messages that no value satisfies, that are longer than 64 KiB or nest more than 32 levels have no cases.
//!
//! ```
//! # use uavspec_codegen::{PackageInput, SourceMap, msg::Dialect, read, schema::Form};
//! # let mut sources = SourceMap::default();
//! # let id = sources.add("Wind.msg", "uint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@range 0, 60] Speed\n".into()).unwrap();
//! # let packages = [PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])];
//! # let (schema, diagnostics) = read(&sources, &packages);
//! use uavspec_codegen::emit::vectors::{Options, emit};
//!
//! let files = emit(&schema, &Options::default());
//! let vectors = files.iter().find(|file| file.path == "px4/Wind.vectors.json").unwrap();
//! assert!(vectors.text.contains("PX-RANGE-01"));
//! ```

mod bytes;
mod case;
mod error_code;
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

use self::case::Case;
use self::message::is_uorb;
pub use self::options::Options;
use self::print::{Head, quote};
#[cfg(feature = "files")]
use super::emitter::{Input, Others, Output};
use super::file::OutputFile;
use super::json_schema::{self, Target};
use crate::dynamic::Types;
#[cfg(feature = "files")]
use crate::failure::Failure;
use crate::schema::json_type::Direction;
use crate::schema::{JsonMessageId, Message, MessageId, Package, Schema};

/// Where the files in the form of the JSON Schema Test Suite are.
const SUITE: &str = "json-schema-test-suite/tests/draft2020-12";

#[cfg(feature = "files")]
impl Output for Options {
    /// The vectors refer to the schemas that are emitted beside them.
    fn complete(&mut self, others: &Others<'_>) {
        let base = self.base.take();
        self.base = base.or_else(|| others.text("json_schema", "base").map(str::to_owned));
    }

    fn emit(&self, input: Input<'_>) -> Result<Vec<OutputFile>, Failure> {
        Ok(emit(input.schema, self))
    }
}

/// Emits all vectors, sorted by path.
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
                Target::JsonPart(id, direction) => {
                    (emitter.head(target, Vec::new()), emitter.part(id, direction))
                }
            };
            files.extend(emitter.files(target, &head, &cases));
        }
    }
    files.sort_by(|left, right| left.path.cmp(&right.path));
    files
}

/// A valid message of each type as JSON, by its id: values are typical, and no two fields side by side have the
/// same. None where no value satisfies the type.
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

/// What tells whether two sides mean the same message.
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
