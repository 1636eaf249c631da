//! JSON Schemas, draft 2020-12. There is one file for each message, service part, set of error codes, component with
//! events, and type defined on a page. A message defined on a page has one file for each direction. For tools that
//! can't follow references between files, each package has a bundle.
//!
//! The schema of a `.msg` file is closed, and all fields are required. The schema of a definition on a page is closed
//! only if the page says so. All assertions have the same meaning in draft 7, so older tools can use the bundles. Draft
//! 7 tools check how many elements a tuple has, but not the elements themselves.
//!
//! # Annotations
//!
//! Units, frames, topics, hashes and similar data are members whose names start with `x-`. ajv in strict mode rejects
//! unknown keywords, so these members are not next to the schema keywords. Instead, these members are in an
//! `annotations` subschema in `$defs`. All drafts since 2019-09 allow `$defs` at any depth. Nothing refers to this
//! subschema, so validators ignore it:
//!
//! ```json
//! "voltage_v": {
//!   "title": "voltage_v",
//!   "type": ["number", "null"],
//!   "$defs": { "annotations": { "x-type": "float32", "x-unit": "V" } }
//! }
//! ```
//!
//! # Alternatives
//!
//! Each alternative repeats the type of the enclosing schema, because some code generators look at each alternative
//! separately and need its type. Disjoint alternatives use `oneOf`; overlapping alternatives use `anyOf`. `cargo xtask
//! interop` shows how validators and code generators handle the schemas.
//!
//! # Numbers
//!
//! NaN is represented as null, which is valid for all floats. Ranges are enforced, except for the value that means "no
//! data". Readers that store all numbers as 64-bit floats, such as JavaScript, can't distinguish the bounds of 64-bit
//! integers from adjacent values.
//!
//! # Texts
//!
//! A PX4 `char[N]` contains N bytes of UTF-8. JSON Schema counts characters, and N bytes contain at most N characters.
//! The schema therefore accepts every valid text, but also accepts some overlong texts with non-ASCII characters.
//!
//! ```
//! # use uavspec_schema::{Form, PackageInput, SourceMap, msg::Dialect, read};
//! # let mut sources = SourceMap::default();
//! # let id = sources.add("Wind.msg", "uint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@range 0, 60] Speed\n".into()).unwrap();
//! # let packages = [PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])];
//! # let (schema, diagnostics) = read(&sources, &packages);
//! use uavspec_emit::json_schema::{Options, emit};
//!
//! let files = emit(&schema, &Options { base: "https://example.org".to_owned() });
//! assert!(files.iter().any(|file| file.text.contains("https://example.org/")));
//! ```

mod address;
mod annotation;
mod bounds;
mod error_code;
mod event;
mod field;
mod json_type;
mod message;
mod tree;

use std::collections::{BTreeMap, BTreeSet};

use uavspec_schema::failure::Failure;
use uavspec_schema::json_type::Direction;
use uavspec_schema::{JsonMessageId, Package, Schema};

use self::address::Address;
pub(super) use self::address::Target;
pub(super) use self::json_type::BASE64;
use self::tree::{Member, Node, member};
use super::emitter::{Input, Output};
use super::file::{OutputFile, notice};

/// Default value of [`Options::base`]. RFC 6761 reserves `.invalid`, so the domain belongs to nobody. Validators
/// resolve relative references against such a URL. Many validators fail if `$id` is a relative reference or a URN.
pub const DEFAULT_BASE: &str = "https://schemas.invalid/";

/// The JSON Schema draft of all files.
pub(super) const DRAFT: &str = "https://json-schema.org/draft/2020-12/schema";

/// Options of the emitter.
#[derive(Clone, Debug, PartialEq, Eq, schemars::JsonSchema, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Options {
    /// URL prefix of every `$id`. Default: `https://schemas.invalid/`.
    pub base: String,
}

impl Default for Options {
    fn default() -> Self {
        Self { base: DEFAULT_BASE.to_owned() }
    }
}

impl Output for Options {
    fn emit(&self, input: Input<'_>) -> Result<Vec<OutputFile>, Failure> {
        Ok(emit(input.schema, self))
    }
}

/// Creates all schemas, sorted by path.
pub fn emit(schema: &Schema, options: &Options) -> Vec<OutputFile> {
    let mut emitter = Emitter { schema, options, definitions: BTreeMap::new() };
    for (index, package) in schema.packages.iter().enumerate() {
        for target in targets(schema, package, index) {
            emitter.define(target);
        }
    }
    let mut files: Vec<OutputFile> = emitter.definitions.keys().map(|target| emitter.file(*target)).collect();
    let bundles = schema.packages.iter().enumerate();
    files.extend(
        bundles.filter_map(|(index, package)| emitter.bundle(package, targets(schema, package, index))),
    );
    OutputFile::sort(&mut files);
    files
}

/// The absolute URL of a schema.
pub(super) fn id(schema: &Schema, target: Target, options: &Options) -> String {
    Address::of(schema, target).id(&options.base)
}

/// The path of a schema file, without extension.
pub(super) fn name(schema: &Schema, target: Target) -> String {
    Address::of(schema, target).stem()
}

/// All items of a package that have a schema.
pub(super) fn targets(schema: &Schema, package: &Package, index: usize) -> Vec<Target> {
    let mut targets: Vec<Target> = package.all_messages().map(Target::Message).collect();
    if !package.error_tables.is_empty() {
        targets.extend([Target::ErrorCode(index), Target::ErrorList(index)]);
    }
    targets.extend(package.json_types.iter().map(|id| Target::JsonType(*id)));
    let messages = package.json_messages.iter().map(|id| (*id, schema.json_message(*id)));
    targets.extend(messages.flat_map(|(id, message)| {
        message.parts.iter().map(move |part| Target::JsonPart(id, part.direction))
    }));
    targets.extend((0..package.components.len()).map(|component| Target::Events(index, component)));
    targets
}

struct Emitter<'s> {
    schema: &'s Schema,
    options: &'s Options,
    /// The members of each schema, except members that depend on the output file.
    definitions: BTreeMap<Target, Vec<Member<'s>>>,
}

impl<'s> Emitter<'s> {
    fn define(&mut self, target: Target) {
        let members = match target {
            Target::Message(id) => message::members(self.schema, self.schema.message(id)),
            Target::ErrorCode(index) => error_code::code_members(&self.schema.packages[index]),
            Target::ErrorList(index) => error_code::list_members(&self.schema.packages[index], index),
            Target::JsonType(id) => json_type::type_members(self.schema, self.schema.json_type(id)),
            Target::JsonPart(id, direction) => self.part_members(id, direction),
            Target::Events(index, component) => {
                let package = &self.schema.packages[index];
                event::members(package, &package.components[component])
            }
        };
        self.definitions.insert(target, members);
    }

    fn part_members(&self, id: JsonMessageId, direction: Direction) -> Vec<Member<'s>> {
        let message = self.schema.json_message(id);
        let part = message.parts.iter().find(|part| part.direction == direction);
        part.map_or_else(Vec::new, |part| json_type::part_members(self.schema, message, part))
    }

    fn definition(&self, target: Target) -> &[Member<'s>] {
        self.definitions.get(&target).map_or(&[], Vec::as_slice)
    }

    fn address(&self, target: Target) -> Address<'s> {
        Address::of(self.schema, target)
    }

    fn file(&self, target: Target) -> OutputFile {
        let here = self.address(target);
        let mut members = head(here.id(&self.options.base), &here.stem());
        members.extend_from_slice(self.definition(target));
        OutputFile {
            path: here.path(),
            text: tree::print(members, &|other| here.refer_to(self.address(other))),
        }
    }

    /// Creates the bundle of a package, with everything its messages refer to. The bundle itself accepts instances of
    /// any definition in the package; without this assertion, it would accept any value. If the package has messages
    /// defined on pages, the bundle accepts only these messages. Some page types are plain strings or numbers, so they
    /// would accept unrelated values.
    fn bundle(&self, package: &Package, own: Vec<Target>) -> Option<OutputFile> {
        if own.is_empty() {
            return None;
        }
        let definition = |target: Target| self.address(target).definition(package);
        let reference = |target: &Target| Node::Object(vec![member("$ref", Node::Reference(*target))]);
        let is_body = |target: &&Target| matches!(target, Target::JsonPart(..));
        let has_bodies = own.iter().any(|target| is_body(&target));
        let any: Node<'_> =
            own.iter().filter(|target| !has_bodies || is_body(target)).map(reference).collect();
        let foreign = self.foreign(&own);
        let entries = own.into_iter().chain(foreign);
        let entries =
            entries.map(|target| (definition(target).into(), Node::Shared(self.definition(target))));
        let from = format!("the definitions of {}", package.name);
        let mut members = head(address::bundle_id(package, &self.options.base), &from);
        members.push(member("title", package.name.as_str()));
        members.push(member("description", describe(package)));
        members.push(member("anyOf", any));
        members.push(member("$defs", Node::Object(entries.collect())));
        let text = tree::print(members, &|target| address::within_bundle(&definition(target)));
        Some(OutputFile { path: address::bundle_path(package), text })
    }

    /// The messages that `own` refers to, directly or indirectly, without `own` itself.
    fn foreign(&self, own: &[Target]) -> BTreeSet<Target> {
        let mut seen: BTreeSet<Target> = own.iter().copied().collect();
        let mut open: Vec<Target> = own.to_vec();
        while let Some(target) = open.pop() {
            let Target::Message(id) = target else { continue };
            let nested = self.schema.message(id).nested().map(Target::Message);
            open.extend(nested.filter(|nested| seen.insert(*nested)));
        }
        for target in own {
            seen.remove(target);
        }
        seen
    }
}

/// The first members of a file.
fn head<'s>(id: String, from: &str) -> Vec<Member<'s>> {
    vec![member("$schema", DRAFT), member("$id", id), member("$comment", notice(from))]
}

fn describe(package: &Package) -> String {
    let all = format!("All definitions of package {}", package.name);
    match (&package.origin, &package.revision) {
        (None, _) => format!("{all}."),
        (Some(origin), None) => format!("{all}, from {origin}."),
        (Some(origin), Some(revision)) => format!("{all}, from {origin}, {revision}."),
    }
}
