//! Where each definition is found: its file, its absolute address, its name in a bundle.

use std::fmt::Write as _;

use crate::schema::json_type::Direction;
use crate::schema::{JsonMessageId, JsonTypeId, Kind, MessageId, Package, Schema};

/// Ending of every file that holds a schema.
const EXTENSION: &str = ".schema.json";

/// Something that has a schema of its own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(in crate::emit) enum Target {
    /// A message, or a part of a service or action.
    Message(MessageId),
    /// An error code of the package with this index.
    ErrorCode(usize),
    /// A list of such codes.
    ErrorList(usize),
    /// A type of a page.
    JsonType(JsonTypeId),
    /// A message of a page in a direction.
    JsonPart(JsonMessageId, Direction),
}

/// The place of a [`Target`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Address<'s> {
    package: &'s str,
    /// Parts of services and actions have a folder of their own, so that no message is in their way.
    folder: Option<&'static str>,
    name: &'s str,
}

impl<'s> Address<'s> {
    pub(super) fn of(schema: &'s Schema, target: Target) -> Self {
        let package = |index: usize| schema.packages.get(index).map_or("", |package| package.name.as_str());
        match target {
            Target::Message(id) => {
                let message = schema.message(id);
                let folder = (message.kind != Kind::Message).then(|| message.kind.name());
                Self { package: package(message.package), folder, name: &message.name }
            }
            Target::ErrorCode(index) => Self { package: package(index), folder: None, name: "ErrorCode" },
            Target::ErrorList(index) => Self { package: package(index), folder: None, name: "ErrorList" },
            Target::JsonType(id) => {
                let found = schema.json_type(id);
                Self { package: package(found.package), folder: None, name: &found.name }
            }
            Target::JsonPart(id, direction) => {
                let message = schema.json_message(id);
                let part = message.parts.iter().find(|part| part.direction == direction);
                let name = part.map_or("", |part| part.name.as_str());
                Self { package: package(message.package), folder: None, name }
            }
        }
    }

    /// The path of the file.
    pub(super) fn path(self) -> String {
        format!("{}/{}", self.package, self.file())
    }

    /// The path of the file without its ending.
    pub(super) fn stem(self) -> String {
        let Self { package, folder, name } = self;
        folder.map_or_else(|| format!("{package}/{name}"), |folder| format!("{package}/{folder}/{name}"))
    }

    /// The absolute address under `base`.
    pub(super) fn id(self, base: &str) -> String {
        join(base, &encode(&self.path()))
    }

    /// The address of `other` as this file refers to it. Relative, so that references hold wherever
    /// the files are put, as long as they stay together.
    pub(super) fn refer_to(self, other: Address<'_>) -> String {
        let mut reference = String::new();
        if self.folder.is_some() {
            reference.push_str("../");
        }
        if self.package == other.package {
            reference.push_str(&encode(&other.file()));
        } else {
            reference.push_str("../");
            reference.push_str(&encode(&other.path()));
        }
        reference
    }

    /// The name among the `$defs` of the bundle of `package`. Other packages' messages have their full
    /// ROS name there, with dots: names can't clash, and tools make readable types of them.
    pub(super) fn definition(self, package: &Package) -> String {
        match self.folder {
            _ if self.package != package.name => {
                let folder = self.folder.unwrap_or(Kind::Message.name());
                format!("{}.{folder}.{}", self.package, self.name)
            }
            Some(folder) => format!("{folder}.{}", self.name),
            None => self.name.to_owned(),
        }
    }

    fn file(self) -> String {
        match self.folder {
            Some(folder) => format!("{folder}/{}{EXTENSION}", self.name),
            None => format!("{}{EXTENSION}", self.name),
        }
    }
}

/// The path of the bundle of `package`: beside its folder, where no message can be called the same.
pub(super) fn bundle_path(package: &Package) -> String {
    format!("{}.bundle{EXTENSION}", package.name)
}

/// The absolute address of the bundle of `package`.
pub(super) fn bundle_id(package: &Package, base: &str) -> String {
    join(base, &encode(&bundle_path(package)))
}

/// The address of a definition of a bundle, within the bundle.
pub(super) fn within_bundle(definition: &str) -> String {
    let pointer = definition.replace('~', "~0").replace('/', "~1");
    format!("#/$defs/{}", encode(&pointer))
}

fn join(base: &str, path: &str) -> String {
    format!("{}/{path}", base.trim_end_matches('/'))
}

/// Percent-encodes what an address can't hold; names of messages have none of it, those of packages
/// are the user's.
fn encode(path: &str) -> String {
    let mut encoded = String::with_capacity(path.len());
    for byte in path.bytes() {
        if byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'.' | b'_' | b'~' | b'/') {
            encoded.push(char::from(byte));
        } else {
            // Writing to a string doesn't fail.
            let _ = write!(encoded, "%{byte:02X}");
        }
    }
    encoded
}
