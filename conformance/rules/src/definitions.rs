//! The definitions against which captures and sessions are checked.
//!
//! ```
//! use uavspec_rules::definitions::Definitions;
//!
//! let definitions = Definitions::built_in();
//! let id = definitions.message_of_type("px4_msgs/msg/FailsafeFlags");
//! assert_eq!(id, definitions.message_of_type("px4/FailsafeFlags"));
//! assert_eq!(definitions.schema.message(id.unwrap()).topics, ["failsafe_flags"]);
//! ```

mod choice;
mod index;
mod library;
mod released;
mod shared;
mod stated;

use std::collections::{BTreeSet, HashMap};
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use uavspec_codegen::load::{self, read_definitions_for_captures};
use uavspec_definitions::{Dir, FLOCKWAVE, I18N, PX4, PX4_EVENTS};
use uavspec_dynamic::Types;
use uavspec_flockwave::body_schema::{BodySchemas, DefinedSchemas, SchemaError, Schemas};
use uavspec_lint::release;
use uavspec_model::Recent;
use uavspec_model::text::terminal;
pub use uavspec_px4::event::EventMetadata;
use uavspec_schema::fingerprint::{interface_name, ros_name, service_hash_of_event};
use uavspec_schema::msg::{Dialect, Kind};
use uavspec_schema::source::Span;
use uavspec_schema::translation::{self, Translations};
use uavspec_schema::{
    Failure, Form, Interface, Message, MessageId, Package, PackageInput, Schema, SourceMap, derived_from,
    read,
};

pub use self::choice::{Clues, FormatClue, JsonClue, TypeClue};
use self::index::Index;
pub use self::index::{Family, ReleaseId, Row, newest_ros2, read_schema};
pub use self::library::{Library, PX4_ROS_PACKAGE, ros_package};
pub(crate) use self::released::{ReleasedType, released_type};
use self::shared::FormatPlans;
pub use self::shared::{CapturedEvents, FormatPlan, Shared};
pub use self::stated::{Stated, plain_name};
use crate::limits::MAX_PLANS;

/// The prefix of the line that states the version of a message in a release.
const VERSION: &str = "uint32 MESSAGE_VERSION=";

/// The length of the line before the definition of a nested message in a bag.
const SEPARATOR: usize = 80;

/// The topic whose message defines the constants of vehicle states, which apply to other topics as well.
pub const VEHICLE_STATUS: &str = "vehicle_status";

/// The topic whose message defines the constants of battery states, which apply to other topics as well.
pub const BATTERY_STATUS: &str = "battery_status";

/// Definitions, with lookup tables for checks.
#[derive(Debug)]
pub struct Definitions {
    /// The path of the definitions, or a name for the built-in definitions.
    pub name: String,
    sources: SourceMap,
    /// The schema.
    pub schema: Schema,
    /// The paths of definitions that were left out, because they refer to other packages.
    pub(crate) left_out: Vec<String>,
    /// The built-in packages that provide what the path lacks.
    pub(crate) built_in: Vec<String>,
    /// True if the user gave the definitions. False for the built-in definitions and for the definitions of a release.
    pub is_given: bool,
    by_topic: HashMap<String, MessageId>,
    /// The messages of other releases that replace messages of the main release.
    replaced: HashMap<MessageId, MessageId>,
    /// The main releases.
    releases: Vec<LoadedRelease>,
    /// The releases of packages, by package name.
    origins: HashMap<String, LoadedRelease>,
    /// The full ROS names of the types for which the capture doesn't show which definition applies.
    undecided: BTreeSet<String>,
    types: OnceLock<Types>,
    defined_schemas: OnceLock<DefinedSchemas>,
    schemas: Arc<Schemas>,
    /// The event metadata for captures that don't contain their own.
    pub events: Arc<EventMetadata>,
    /// The data that captures share, even if they are checked against different definitions.
    pub shared: Arc<Shared>,
    plans: Recent<FormatPlans, MAX_PLANS>,
}

/// A release that definitions were read from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LoadedRelease {
    /// The family.
    pub family: Family,
    /// The name on the command line, such as `px4@1.16`.
    pub label: String,
    /// The name in text.
    pub title: String,
}

/// A line of a definition, displayed as `file:number`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line<'d> {
    /// The file.
    pub file: &'d str,
    /// The line number, from 1.
    pub number: usize,
    /// The text.
    pub text: &'d str,
}

impl fmt::Display for Line<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}:{}", self.file, self.number)
    }
}

impl Definitions {
    /// The built-in definitions.
    pub fn built_in() -> Self {
        let mut sources = SourceMap::default();
        let px4 = Self::built_in_px4(&mut sources);
        let flockwave = embedded("flockwave", Form::Table, &FLOCKWAVE, &mut sources);
        let events = sources.add("definitions/px4_events/px4.json", PX4_EVENTS.to_vec());
        let events = PackageInput::new("px4_events", Form::Events, events.into_iter().collect());
        // Tests ensure that the built-in definitions have no errors.
        let (schema, _) = read(&sources, &[px4, events, flockwave]);
        Self::new(Self::built_in_name(), sources, schema)
    }

    fn built_in_name() -> String {
        format!("the definitions of uavspec {}", env!("CARGO_PKG_VERSION"))
    }

    /// The package of the built-in PX4 messages.
    fn built_in_px4(sources: &mut SourceMap) -> PackageInput {
        embedded("px4", Form::Msg(Dialect::Px4), &PX4, sources)
    }

    /// Loads definitions from a path: a `uavspec.toml`, a folder that contains one, or files of PX4 messages or ROS 2
    /// interfaces. The dialect is detected.
    pub fn load(path: &Path) -> Result<Self, Failure> {
        Self::load_as(path, None)
    }

    /// Like `load`, but with a given dialect.
    fn load_as(path: &Path, dialect: Option<Dialect>) -> Result<Self, Failure> {
        let load::Definitions { sources, schema, left_out, built_in } =
            read_definitions_for_captures(path, dialect)?;
        let loaded = Self::new(path.to_string_lossy().into_owned(), sources, schema);
        Ok(Self { left_out, built_in, is_given: true, ..loaded })
    }

    /// Like [`Self::built_in`], with the translations of the texts.
    pub fn built_in_translated() -> (Self, Translations) {
        let definitions = Self::built_in();
        let mut sources = SourceMap::default();
        let catalogues = I18N
            .files()
            .filter_map(|file| sources.add(terminal::path(file.path()), file.contents().to_vec()).ok());
        let ids: Vec<_> = catalogues.collect();
        // `cargo xtask lint` ensures that the catalogues have no errors.
        let (translations, _) = translation::resolve(&sources, &definitions.schema, &ids);
        (definitions, translations)
    }

    fn new(name: String, sources: SourceMap, mut schema: Schema) -> Self {
        schema.add_derived();
        let mut by_topic = HashMap::new();
        for id in schema.packages.iter().flat_map(|package| &package.messages) {
            for topic in &schema.message(*id).topics {
                by_topic.entry(topic.clone()).or_insert(*id);
            }
        }
        Self {
            name,
            sources,
            schema,
            left_out: Vec::new(),
            built_in: Vec::new(),
            is_given: false,
            by_topic,
            replaced: HashMap::new(),
            releases: Vec::new(),
            origins: HashMap::new(),
            undecided: BTreeSet::new(),
            types: OnceLock::new(),
            defined_schemas: OnceLock::new(),
            schemas: Arc::default(),
            events: built_in_events(),
            shared: Arc::default(),
            plans: Recent::default(),
        }
    }

    /// Replaces messages with the messages that have the same ROS names in these packages.
    fn with_replacements(mut self, packages: &[String]) -> Self {
        let mut originals: HashMap<String, MessageId> = HashMap::new();
        let mut replacements = Vec::new();
        for package in &self.schema.packages {
            let is_replacement = packages.contains(&package.name);
            for id in &package.messages {
                let name = ros_name(&self.schema, self.schema.message(*id));
                if is_replacement {
                    replacements.push((name, *id));
                } else {
                    originals.insert(name, *id);
                }
            }
        }
        let replaced = replacements.into_iter().filter_map(|(name, id)| Some((*originals.get(&name)?, id)));
        self.replaced = replaced.collect();
        self
    }

    /// True if these definitions contain a package of messages, and not only because other packages refer to it.
    pub fn defines(&self, package: &Package) -> bool {
        let is_added = package.is_dependency || self.built_in.contains(&package.name);
        !is_added && matches!(package.form, Form::Msg(_))
    }

    /// The main releases of these definitions. Empty if they aren't the definitions of a release.
    pub fn releases(&self) -> &[LoadedRelease] {
        &self.releases
    }

    /// The release of a message.
    pub fn release_of(&self, id: MessageId) -> Option<&LoadedRelease> {
        self.origins.get(&self.schema.package_of(self.schema.message(id)).name)
    }

    /// The message that replaces a message, or the message itself.
    fn current(&self, id: MessageId) -> MessageId {
        self.replaced.get(&id).copied().unwrap_or(id)
    }

    /// Loads JSON Schemas from these folders, for Flockwave message types that have no definition.
    ///
    /// # Errors
    /// Fails if a schema can't be read or used.
    pub fn with_schemas(self, folders: &[PathBuf]) -> Result<Self, SchemaError> {
        if folders.is_empty() {
            return Ok(self);
        }
        let schemas = Arc::new(Schemas::load(folders, self.defined_schemas())?);
        Ok(Self { schemas, ..self })
    }

    /// The message of a PX4 topic in a log. PX4 appends versions only to names in ROS, so the whole name counts.
    pub fn message_of_logged_topic(&self, topic: &str) -> Option<MessageId> {
        self.by_topic.get(topic).map(|id| self.current(*id))
    }

    /// The message of a PX4 topic. The name of a versioned topic may end with its version.
    pub fn message_of_topic(&self, topic: &str) -> Option<MessageId> {
        let unversioned = || self.message_of_logged_topic(unversioned(topic)?);
        self.message_of_logged_topic(topic).or_else(unversioned)
    }

    /// The message of a type: `px4/FailsafeFlags`, or in ROS 2 notation `px4_msgs/msg/FailsafeFlags`. The parts of services
    /// and actions are messages, and so are derived types such as `px4_msgs/srv/VehicleCommand_Event`.
    pub fn message_of_type(&self, ty: &str) -> Option<MessageId> {
        let (package, name) = ty.split_once('/')?;
        let is_in_package = |known: &Package| known.name == package || known.ros_package == package;
        let interface = [Kind::Service, Kind::Action]
            .into_iter()
            .find_map(|kind| Some((kind, name.strip_prefix(kind.name())?.strip_prefix('/')?)));
        if let Some((kind, name)) = interface {
            let is_found = |message: &Message| {
                message.kind == kind && message.name == name && is_in_package(self.schema.package_of(message))
            };
            let index = self.schema.messages.iter().position(is_found)?;
            return u32::try_from(index).ok().map(MessageId);
        }
        let name = name.strip_prefix("msg/").unwrap_or(name);
        let packages = self.schema.packages.iter();
        packages
            .filter(|known| is_in_package(known))
            .flat_map(|known| &known.messages)
            .find(|id| self.schema.message(**id).name == name)
            .map(|id| self.current(*id))
    }

    /// The type hash that captures contain for a message. For the event message of a service, this is the hash of the
    /// service.
    pub fn captured_hash(&self, message: &Message) -> String {
        service_hash_of_event(&self.schema, message).unwrap_or_else(|| message.type_hash.clone())
    }

    /// True if a capture may contain this type hash for a message. For the event message of a service, captures contain
    /// the hash of the service.
    pub fn has_type_hash(&self, message: &Message, stated: &str) -> bool {
        let hashes = [&message.type_hash, &self.captured_hash(message)];
        hashes.iter().any(|hash| hash.eq_ignore_ascii_case(stated))
    }

    /// True if a release defines a message with the same fields and this version. A type hash doesn't cover the version.
    pub(crate) fn has_version_elsewhere(&self, id: MessageId, version: &str) -> bool {
        let message = self.schema.message(id);
        if self.release_of(id).is_none() {
            return false;
        }
        let index = Index::built_in();
        let name = ros_name(&self.schema, message);
        let rows = index.of_name(&name).filter(|row| row.type_hash == message.type_hash);
        let mut releases = rows.flat_map(|row| row.releases.iter());
        releases.any(|release| {
            let text = index.release(release).text();
            let mut lines = release::entries(text)
                .filter(|entry| entry.name == message.name)
                .flat_map(|entry| entry.text.lines());
            lines.any(|line| line.strip_prefix(VERSION) == Some(version))
        })
    }

    /// True if the definition of a message was chosen only by its size, and other definitions have the same size.
    pub fn is_undecided(&self, id: MessageId) -> bool {
        self.undecided.contains(&ros_name(&self.schema, self.schema.message(id)))
    }

    /// The types of all messages, with their codecs; created lazily.
    pub fn types(&self) -> &Types {
        self.types.get_or_init(|| Types::new(&self.schema))
    }

    /// The body schemas of all Flockwave messages, created lazily. Definitions without Flockwave messages, such as PX4
    /// definitions, use the built-in schemas.
    pub fn defined_schemas(&self) -> &DefinedSchemas {
        self.defined_schemas.get_or_init(|| {
            if self.schema.json_messages.is_empty() {
                DefinedSchemas::new(&Self::built_in().schema).foreign()
            } else {
                DefinedSchemas::new(&self.schema)
            }
        })
    }

    /// The body schemas of Flockwave messages.
    pub fn body_schemas(&self) -> BodySchemas<'_> {
        BodySchemas { defined_schemas: self.defined_schemas(), schemas: &self.schemas }
    }

    /// The text of a message's definition and of its nested messages, as bags store it. For a message that ROS 2 derives
    /// from a service or an action, this is the text of the service or the action.
    pub fn bag_text(&self, id: MessageId) -> String {
        let root = self.schema.message(id);
        let (mut text, mut known, mut waiting) = (String::new(), BTreeSet::from([id]), vec![id]);
        if let Some(interface) = self.interface_of(root) {
            if interface.kind == Kind::Service {
                let name = interface_name(self.schema.package_of(root), interface);
                text.extend([&*"=".repeat(SEPARATOR), "\nSRV: ", &name, "\n"]);
            }
            push_lines(&mut text, self.sources.slice(interface.span));
            let nested = interface.parts.iter().flat_map(|part| self.schema.message(*part).nested());
            waiting = nested.filter(|nested| known.insert(*nested)).collect();
        }
        while let Some(id) = waiting.pop() {
            let message = self.schema.message(id);
            if !text.is_empty() {
                let name = ros_name(&self.schema, message).replacen("/msg/", "/", 1);
                text.extend([&*"=".repeat(SEPARATOR), "\nMSG: ", &name, "\n"]);
            }
            push_lines(&mut text, self.sources.slice(message.span));
            waiting.extend(message.nested().filter(|nested| known.insert(*nested)));
        }
        text
    }

    /// The service or action that a message belongs to.
    fn interface_of(&self, message: &Message) -> Option<&Interface> {
        let name = ros_name(&self.schema, message);
        let (kind, origin) = derived_from(&name)?;
        let package = self.schema.package_of(message);
        package.interfaces.iter().find(|found| found.kind == kind && interface_name(package, found) == origin)
    }

    /// The line of a definition.
    pub fn line(&self, span: Span) -> Line<'_> {
        let id = self.sources.source_of(span);
        let number = self.sources.position(span).line;
        let text = self.sources.text(id).lines().nth(number - 1).unwrap_or_default();
        Line { file: self.sources.path(id), number, text }
    }
}

/// Adds a text that ends with a line feed.
fn push_lines(text: &mut String, lines: &str) {
    text.push_str(lines);
    if !text.ends_with('\n') {
        text.push('\n');
    }
}

/// The built-in event metadata.
fn built_in_events() -> Arc<EventMetadata> {
    static EVENTS: OnceLock<Arc<EventMetadata>> = OnceLock::new();
    // `cargo xtask lint` ensures that the metadata has no errors.
    Arc::clone(EVENTS.get_or_init(|| Arc::new(EventMetadata::built_in(PX4_EVENTS))))
}

/// A package whose files are embedded in the program.
fn embedded(name: &str, form: Form, folder: &Dir<'_>, sources: &mut SourceMap) -> PackageInput {
    let mut files: Vec<_> = folder.files().collect();
    files.sort_by_key(|file| file.path());
    let ids = files.into_iter().filter_map(|file| {
        let path = format!("definitions/{name}/{}", terminal::path(file.path()));
        sources.add(path, file.contents().to_vec()).ok()
    });
    PackageInput::new(name, form, ids.collect())
}

/// The name of a topic without the version at its end: `vehicle_status` of `vehicle_status_v1`.
pub fn unversioned(topic: &str) -> Option<&str> {
    let (name, version) = topic.rsplit_once("_v")?;
    (!version.is_empty() && version.bytes().all(|byte| byte.is_ascii_digit())).then_some(name)
}

/// The folder of the topics that PX4 sends to applications. A namespace may precede it.
pub const FROM_PX4: &str = "/fmu/out/";

/// The folders of the topics that PX4 exchanges with applications. A namespace may precede them.
pub const FOLDERS: [&str; 2] = ["/fmu/in/", FROM_PX4];

/// True if a topic is in one of these folders.
pub fn is_exchanged(topic: &str) -> bool {
    FOLDERS.iter().any(|folder| topic.contains(folder))
}

/// The version in the name of a topic that PX4 exchanges with applications; 0 if the name doesn't end with a version.
pub fn version_of_topic(topic: &str) -> Option<u32> {
    is_exchanged(topic).then(|| match unversioned(topic) {
        Some(name) => topic[name.len()..].trim_start_matches("_v").parse().ok(),
        None => Some(0),
    })?
}

/// The name of a topic with its version at the end. PX4 appends the version of the message, if it isn't 0.
pub fn versioned(topic: &str, version: Option<u32>) -> String {
    match version {
        None | Some(0) => topic.to_owned(),
        Some(version) => format!("{topic}_v{version}"),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use uavspec_flockwave::session::{OPERATION, OPERATIONS, PARTS, parts};
    use uavspec_schema::JsonMessage;
    use uavspec_schema::json_type::{Direction, JsonPart};

    use super::*;

    /// The fields of a body.
    fn fields(message: &JsonMessage, direction: Direction) -> BTreeSet<&str> {
        let part = message.parts.iter().find(|part| part.direction == direction);
        part.into_iter().flat_map(JsonPart::fields).map(|field| field.name.as_str()).collect()
    }

    #[test]
    fn reply_parts_match_the_definitions() {
        let definitions = Definitions::built_in();
        let messages = &definitions.schema.json_messages;
        for message in messages {
            let reply = fields(message, Direction::Response);
            let is_operation = OPERATION.reply_fields.iter().all(|part| reply.contains(part));
            // LOG-DATA concerns only one UAV, so its receipt isn't in a map.
            let is_operation = is_operation && message.name != "LOG-DATA";
            assert_eq!(OPERATIONS.contains(&message.name.as_str()), is_operation, "{}", message.name);
            if let Some(parts) = parts(&message.name) {
                assert!(
                    fields(message, Direction::Request).contains(parts.request_field),
                    "{}",
                    message.name
                );
                assert_eq!(reply, parts.reply_fields.iter().copied().collect(), "{}", message.name);
            }
        }
        let names: BTreeSet<&str> = messages.iter().map(|message| message.name.as_str()).collect();
        assert!(PARTS.iter().all(|(name, _)| names.contains(name)));
        assert!(OPERATIONS.iter().all(|name| names.contains(name)));
    }

    #[test]
    fn built_in_definitions_are_complete() {
        let definitions = Definitions::built_in();
        let battery = definitions.message_of_topic("battery_status").expect("a topic");
        assert_eq!(definitions.schema.message(battery).name, "BatteryStatus");
        assert_eq!(definitions.message_of_topic("battery_status_v1"), Some(battery));
        assert_eq!(definitions.message_of_topic("battery_status_vx"), None);
        assert_eq!(
            definitions.line(definitions.schema.message(battery).span).to_string(),
            "definitions/px4/BatteryStatus.msg:1"
        );
        for ty in ["px4/BatteryStatus", "px4_msgs/msg/BatteryStatus"] {
            assert_eq!(definitions.message_of_type(ty), Some(battery), "{ty}");
        }
        for ty in ["BatteryStatus", "px4/msg", "px4/", "ros/BatteryStatus"] {
            assert_eq!(definitions.message_of_type(ty), None, "{ty}");
        }
        let codes = definitions.schema.packages.iter().flat_map(|package| &package.error_tables);
        assert!(codes.map(|table| table.codes.len()).sum::<usize>() > 60);
    }
}
