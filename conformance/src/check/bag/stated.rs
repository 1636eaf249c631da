//! Reads the types that a file declares in the `ros2msg` format.
//!
//! The text of the type itself comes first. Before the text of each nested type, there is a line of `=` characters and
//! a line with the type's name, `MSG: package/Name`.
//!
//! Comments are removed first: they aren't part of a type, and may contain annotations that refer to missing
//! messages.

use std::collections::{BTreeMap, BTreeSet};

use uavspec_codegen::diagnostic::{Level, Problem};
use uavspec_codegen::dynamic::{MessageType, Types};
use uavspec_codegen::msg::{Dialect, Kind};
use uavspec_codegen::release::sections;
use uavspec_codegen::schema::fingerprint::type_hash;
use uavspec_codegen::schema::{Form, Message, MessageId};
use uavspec_codegen::{PackageInput, SourceMap, read_formats};
use uavspec_runtime::Number;

use crate::check::topic::plain;
use crate::text::utf8;

/// The package of a type whose name contains no package.
const NO_PACKAGE: &str = "unnamed";

/// A type with its nested types.
#[derive(Debug)]
pub(super) struct Stated {
    types: Types,
    root: MessageId,
    type_hash: String,
    version: Option<u32>,
}

impl Stated {
    /// Parses the text of the schema `name`, which may be a DDS name. The error is a one-line message.
    pub(super) fn read(name: &str, text: &[u8]) -> Result<Self, String> {
        let text = utf8(text)?;
        let name = &plain(name);
        let root = parts_of(name).ok_or("its name is not a type name")?;
        let event = Event::of(name, text);
        let texts = event.as_ref().map_or_else(|| definitions(text), Event::definitions);
        let mut sources = SourceMap::default();
        let mut packages: BTreeMap<&str, PackageInput> = BTreeMap::new();
        let mut names = BTreeSet::new();
        for (name, text) in texts {
            let (package, name) = match name {
                None => root,
                Some(name) => {
                    parts_of(name).ok_or_else(|| format!("`{}` is not a type name", name.escape_debug()))?
                }
            };
            // Some writers repeat nested types.
            if !names.insert((package, name)) {
                continue;
            }
            let path = format!("{package}/{name}.msg");
            let source = sources
                .add(path, without_comments(text).into_bytes())
                .map_err(|diagnostic| diagnostic.problem.to_string())?;
            let form = Form::Msg(Dialect::Ros2);
            let input = packages.entry(package);
            input.or_insert_with(|| PackageInput::new(package, form, Vec::new())).sources.push(source);
        }
        let packages: Vec<PackageInput> = packages.into_values().collect();
        let (schema, diagnostics) = read_formats(&sources, &packages);
        // Names that violate the ROS 2 naming style are accepted.
        let is_fatal = |problem: &Problem| {
            problem.level() == Level::Error && !matches!(problem, Problem::NameStyleRos { .. })
        };
        if let Some(diagnostic) = diagnostics.iter().find(|diagnostic| is_fatal(&diagnostic.problem)) {
            let source = sources.source_of(diagnostic.span);
            let line = sources.position(diagnostic.span).line;
            return Err(format!("{}:{line}: {}", sources.path(source), diagnostic.problem));
        }
        let is_root = |id: &&MessageId| schema.message(**id).name == root.1;
        let messages = schema.packages.iter().filter(|package| package.name == root.0);
        let found = messages.flat_map(|package| &package.messages).find(is_root).copied();
        let root = found.ok_or("it doesn't define the type in its name")?;
        let stated = Self {
            root,
            type_hash: type_hash(&schema, root),
            version: version(schema.message(root)),
            types: Types::new(&schema),
        };
        match stated.root().defect() {
            Some(defect) => Err(format!("it {defect}")),
            None => Ok(stated),
        }
    }

    /// The ROS type hash.
    pub(super) fn type_hash(&self) -> &str {
        &self.type_hash
    }

    /// The value of `MESSAGE_VERSION`, if it is defined.
    pub(super) fn version(&self) -> Option<u32> {
        self.version
    }

    /// The type of the schema.
    pub(super) fn root(&self) -> MessageType<'_> {
        self.types.get(self.root)
    }
}

/// The version that PX4 assigns to a message. In ROS 2, the version is an ordinary constant.
fn version(message: &Message) -> Option<u32> {
    let constant = message.constants.iter().find(|constant| constant.name == "MESSAGE_VERSION")?;
    match constant.value.number()? {
        Number::Int(version) => u32::try_from(version).ok(),
        Number::Float(_) => None,
    }
}

/// Removes comments. A `#` within a string doesn't start a comment.
fn without_comments(text: &str) -> String {
    let mut bare = String::with_capacity(text.len());
    for line in text.split_inclusive('\n') {
        let mut quote = None;
        let end = line.char_indices().find(|(_, character)| {
            match (quote, character) {
                (None, '#') => return true,
                (None, '"' | '\'') => quote = Some(*character),
                (Some(open), _) if open == *character => quote = None,
                _ => {}
            }
            false
        });
        bare.push_str(end.map_or(line, |(at, _)| &line[..at]));
        if end.is_some() {
            bare.push('\n');
        }
    }
    bare
}

/// The text of each type. The first type has no name.
fn definitions(text: &str) -> Vec<(Option<&str>, &str)> {
    let sections = sections(text, &[Kind::Message]);
    sections.into_iter().map(|section| (section.heading.map(|(_, name)| name), section.text)).collect()
}

/// The event of a service. rosbag2 records the text of the `.srv` file for it.
struct Event<'t> {
    /// The definition of the event.
    text: String,
    /// The names of the request and the response.
    parts: [String; 2],
    request: &'t str,
    response: &'t str,
    /// The definitions of nested types.
    nested: Vec<(Option<&'t str>, &'t str)>,
}

impl<'t> Event<'t> {
    /// Splits the text of a service. `None` for other types, and for the definition of the event itself.
    fn of(name: &str, text: &'t str) -> Option<Self> {
        let service = name.strip_suffix("_Event").filter(|service| service.contains("/srv/"))?;
        let mut nested = definitions(text);
        let (_, own) = nested.remove(0);
        let mut at = 0;
        let separator = own.split_inclusive('\n').find(|line| {
            at += line.len();
            line.trim_end() == "---"
        })?;
        let (request, response) = (&own[..at - separator.len()], &own[at..]);
        let (_, short) = parts_of(service)?;
        let text = format!(
            "service_msgs/ServiceEventInfo info\n{short}_Request[<=1] request\n{short}_Response[<=1] response\n"
        );
        let parts = ["_Request", "_Response"].map(|suffix| format!("{service}{suffix}"));
        Some(Self { text, parts, request, response, nested })
    }

    /// The text of each type, as in a schema of the event itself.
    fn definitions(&self) -> Vec<(Option<&str>, &str)> {
        let [request, response] = &self.parts;
        let own = [(None, &*self.text), (Some(&**request), self.request), (Some(&**response), self.response)];
        // The text of the service doesn't need these types. Its own definition of a type takes precedence.
        own.into_iter().chain(self.nested.iter().copied()).chain(EVENT_TYPES).collect()
    }
}

/// The types that the event of each service contains.
const EVENT_TYPES: [(Option<&str>, &str); 2] = [
    (
        Some("service_msgs/ServiceEventInfo"),
        "uint8 event_type\nbuiltin_interfaces/Time stamp\nchar[16] client_gid\nint64 sequence_number\n",
    ),
    (Some("builtin_interfaces/Time"), "int32 sec\nuint32 nanosec\n"),
];

/// The package and the name of `package/msg/Name`, `package/srv/Name`, `package/Name` or `Name`.
fn parts_of(name: &str) -> Option<(&str, &str)> {
    let (package, name) = name.rsplit_once('/').unwrap_or((NO_PACKAGE, name));
    let package = ["/msg", "/srv"].iter().find_map(|kind| package.strip_suffix(kind)).unwrap_or(package);
    let is_word = |word: &str| {
        word.starts_with(|first: char| first.is_ascii_alphabetic())
            && word.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'_')
    };
    (is_word(package) && is_word(name)).then_some((package, name))
}

#[cfg(test)]
mod tests {
    use super::*;

    const GLIDER: &str =
        "uint64 timestamp  # [@enum Other.KIND] it isn't there\nMark[2] marks\nair_msgs/Wind wind\n";
    const MARK: &str = "int16 height\n# ====\n";
    const WIND: &str = "float32[3] speed\n";

    fn line() -> String {
        "=".repeat(80)
    }

    #[test]
    fn reads_types_of_several_packages() {
        let line = line();
        let text = format!(
            "{GLIDER}{line}\nMSG: sky_msgs/Mark\n{MARK}\r\n{line}\r\nMSG: air_msgs/msg/Wind\r\n{WIND}{line}\n\
             MSG: sky_msgs/Mark\nthis is not read\n"
        );
        let stated = Stated::read("sky_msgs/msg/Glider", text.as_bytes()).expect("a type");
        let root = stated.root();
        assert_eq!((root.package(), root.name()), ("sky_msgs", "Glider"));
        assert_eq!(root.field_names().collect::<Vec<_>>(), ["timestamp", "marks", "wind"]);
        let alone = Stated::read("Wind", WIND.as_bytes()).expect("a type");
        assert_eq!(alone.root().name(), "Wind");
    }

    #[test]
    fn removes_comments_and_keeps_strings() {
        let text = "string NAME='a # b' # 'c\nint8 a#b\nstring s \"it's # text\"\n# all";
        assert_eq!(without_comments(text), "string NAME='a # b' \nint8 a\nstring s \"it's # text\"\n\n");
    }

    #[test]
    fn reports_an_invalid_definition() {
        let missing =
            Stated::read("sky_msgs/msg/Glider", GLIDER.as_bytes()).expect_err("a nested type is missing");
        assert!(missing.starts_with("sky_msgs/Glider.msg:2: "), "{missing}");
        for (name, text) in [
            ("sky_msgs/msg/Mark", &b"int16 height\n\xff"[..]),
            ("sky msgs/Mark", b"int16 height\n"),
            ("", b"int16 height\n"),
            ("sky_msgs/Mark", b"module sky { struct Mark { short height; }; };"),
            ("sky_msgs/Mark", b"uint8[4000000000] all\n"),
            ("sky_msgs/Mark", b"Mark deeper\n"),
            ("sky_msgs/Mark", b"\0\x01\x02\x03"),
        ] {
            assert!(Stated::read(name, text).is_err(), "{name} {:?}", String::from_utf8_lossy(text));
        }
        let odd = format!("{WIND}{}\nMSG: no type\n{MARK}", line());
        assert_eq!(Stated::read("Wind", odd.as_bytes()).expect_err("a name"), "`no type` is not a type name");
    }
}
