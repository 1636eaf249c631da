//! Reads the types that a file declares in the `ros2msg` format.
//!
//! The text of the type itself comes first. Before the text of each nested type, there is a line of `=` characters and
//! a line with the type's name, `MSG: package/Name`. Types that ROS 2 derives from a service or an action have the text
//! of the service or the action instead. This text is alone, or follows a line `SRV: package/srv/Name`.
//!
//! Comments are removed first: they aren't part of a type, and may contain annotations that refer to missing
//! messages.

use std::collections::{BTreeMap, BTreeSet};

use uavspec_dynamic::{MessageType, Types};
use uavspec_lint::release::{Entry, Section, entries, sections, select};
use uavspec_model::text::utf8;
use uavspec_runtime::Number;
use uavspec_schema::diagnostic::{Level, Problem};
use uavspec_schema::fingerprint::{ros_name, type_hash};
use uavspec_schema::msg::{Dialect, Kind};
use uavspec_schema::{Form, Message, MessageId, PackageInput, Schema, SourceMap, derived_from, read_formats};

use super::newest_ros2;

/// The package of a type whose name contains no package.
const NO_PACKAGE: &str = "unnamed";

/// A type with its nested types.
#[derive(Debug)]
pub struct Stated {
    /// The definitions, without comments.
    pub schema: Schema,
    types: Types,
    /// The id of the type in the schema.
    pub id: MessageId,
    /// The ROS type hash.
    pub type_hash: String,
    /// The value of `MESSAGE_VERSION`, if it is defined.
    pub version: Option<u32>,
    /// The names of the types that the schema lacks and that were taken from the built-in definitions.
    pub added: Vec<String>,
}

impl Stated {
    /// Parses the text of the schema `name`, which may be a DDS name. The error is a one-line message.
    pub(super) fn read(name: &str, text: &[u8]) -> Result<Self, String> {
        let text = utf8(text)?;
        let name = &plain_name(name);
        let stated = files(name, text)?;
        let standard = missing(&stated);
        let standard = added(&stated, &standard);
        let added = standard.iter().map(|file| format!("{}/{}", file.package, file.name)).collect();
        let files: Vec<File<'_>> = stated.into_iter().chain(standard).collect();
        let mut sources = SourceMap::default();
        let mut packages: BTreeMap<&str, PackageInput> = BTreeMap::new();
        for file in &files {
            let File { package, name, kind, .. } = file;
            let path = format!("{package}/{name}.{}", kind.name());
            let source = sources
                .add(path, without_comments(file.text).into_bytes())
                .map_err(|diagnostic| diagnostic.problem.to_string())?;
            let input = packages.entry(package);
            let form = Form::Msg(Dialect::Ros2);
            input.or_insert_with(|| PackageInput::new(*package, form, Vec::new())).sources.push(source);
        }
        let packages: Vec<PackageInput> = packages.into_values().collect();
        let (mut schema, diagnostics) = read_formats(&sources, &packages);
        // Names that violate the ROS 2 naming style are accepted.
        let is_fatal = |problem: &Problem| {
            problem.level() == Level::Error && !matches!(problem, Problem::NameStyleRos { .. })
        };
        if let Some(diagnostic) = diagnostics.iter().find(|diagnostic| is_fatal(&diagnostic.problem)) {
            let source = sources.source_of(diagnostic.span);
            let line = sources.position(diagnostic.span).line;
            return Err(format!("{}:{line}: {}", sources.path(source), diagnostic.problem));
        }
        schema.add_derived();
        let id = root(&schema, name).ok_or("it doesn't define the type in its name")?;
        let stated = Self {
            id,
            type_hash: type_hash(&schema, id),
            version: version(schema.message(id)),
            types: Types::new(&schema),
            schema,
            added,
        };
        match stated.root().defect() {
            Some(defect) => Err(format!("it {defect}")),
            None => Ok(stated),
        }
    }

    /// The type of the schema.
    pub fn root(&self) -> MessageType<'_> {
        self.types.get(self.id)
    }
}

/// Converts a DDS type name such as `px4_msgs::msg::dds_::VehicleStatus_` to a ROS 2 name.
pub fn plain_name(name: &str) -> String {
    match name.strip_suffix('_') {
        Some(dds) if dds.contains("::dds_::") => dds.replacen("::dds_::", "::", 1).replace("::", "/"),
        _ => name.replace("::", "/"),
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

/// A definition in the text of a schema.
#[derive(Debug)]
struct File<'t> {
    package: &'t str,
    name: &'t str,
    kind: Kind,
    text: &'t str,
}

/// The definitions in the text of the schema `name`. Some writers repeat nested types.
fn files<'t>(name: &'t str, text: &'t str) -> Result<Vec<File<'t>>, String> {
    if text.lines().any(|line| line.starts_with("IDL: ")) {
        return Err("it contains IDL, which isn't supported".to_owned());
    }
    let mut names = BTreeSet::new();
    let mut files = Vec::new();
    for Section { heading, text } in sections(text, &[Kind::Message, Kind::Service, Kind::Action]) {
        let (kind, name) = match heading {
            Some(heading) => heading,
            // The text of a service or an action defines all types that ROS 2 derives from it.
            None if text.trim().is_empty() && derived_from(name).is_some() => continue,
            None => derived_from(name).filter(|_| has_parts(text)).unwrap_or((Kind::Message, name)),
        };
        let (package, name) =
            parts_of(name).ok_or_else(|| format!("`{}` is not a type name", name.escape_debug()))?;
        if names.insert((package, name, kind)) {
            files.push(File { package, name, kind, text });
        }
    }
    Ok(files)
}

/// True if the text defines a service or an action.
fn has_parts(text: &str) -> bool {
    text.lines().any(|line| line.trim_end() == "---")
}

/// The text of the ROS 2 definitions that files refer to but don't contain, including nested definitions.
fn missing(files: &[File<'_>]) -> String {
    let known: BTreeSet<_> = files.iter().map(|file| (file.package, file.name)).collect();
    let referred = files.iter().flat_map(|file| file.text.lines()).filter_map(|line| {
        let ty = line.split_whitespace().next()?;
        parts_of(ty.split('[').next()?).filter(|(package, _)| *package != NO_PACKAGE)
    });
    let missing = referred.filter(|name| !known.contains(name));
    let missing: BTreeSet<String> = missing.map(|(package, name)| format!("{package}/msg/{name}")).collect();
    if missing.is_empty() {
        return String::new();
    }
    select(newest_ros2(), &missing.iter().map(String::as_str).collect())
}

/// The definitions in a text that files lack.
fn added<'t>(files: &[File<'_>], text: &'t str) -> Vec<File<'t>> {
    let known: BTreeSet<_> = files.iter().map(|file| (file.package, file.name)).collect();
    let messages = entries(text)
        .filter(|entry| entry.kind == Kind::Message && !known.contains(&(entry.package, entry.name)));
    messages.map(|Entry { kind, package, name, text }| File { package, name, kind, text }).collect()
}

/// The message with this full name; otherwise, a message with the same package and name.
fn root(schema: &Schema, name: &str) -> Option<MessageId> {
    let (package, short) = parts_of(name)?;
    let ids = || (0..).map(MessageId).take(schema.messages.len());
    let is_named = |id: &MessageId| {
        let message = schema.message(*id);
        message.name == short && schema.package_of(message).name == package
    };
    let is_full = |id: &MessageId| ros_name(schema, schema.message(*id)) == name;
    ids().filter(is_named).find(is_full).or_else(|| ids().find(is_named))
}

/// The package and the name of `package/msg/Name`, `package/srv/Name`, `package/action/Name`, `package/Name` or `Name`.
fn parts_of(name: &str) -> Option<(&str, &str)> {
    let (package, name) = name.rsplit_once('/').unwrap_or((NO_PACKAGE, name));
    let package =
        ["/msg", "/srv", "/action"].iter().find_map(|kind| package.strip_suffix(kind)).unwrap_or(package);
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
        assert_eq!(
            root.fields().iter().map(|field| &*field.name).collect::<Vec<_>>(),
            ["timestamp", "marks", "wind"]
        );
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
