//! Locations of schemas: file path, absolute URL, and name in a bundle.

use uavspec_schema::json_type::Direction;
use uavspec_schema::prose::percent_encoded;
use uavspec_schema::{JsonMessageId, JsonTypeId, Kind, MessageId, Package, Schema};

/// Extension of all schema files.
const EXTENSION: &str = ".schema.json";

/// An item with a schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Target {
    /// A message, or a part of a service or action.
    Message(MessageId),
    /// An error code of the package with this index.
    ErrorCode(usize),
    /// A list of error codes of the package with this index.
    ErrorList(usize),
    /// A type defined on a page.
    JsonType(JsonTypeId),
    /// A message defined on a page, in one direction.
    JsonPart(JsonMessageId, Direction),
    /// The events of a component, by package index and component index.
    Events(usize, usize),
}

/// The location of a [`Target`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Address<'s> {
    package: &'s str,
    /// Subfolder for parts of services and actions, which prevents name clashes between parts and messages.
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
            Target::Events(index, component) => {
                let name = &schema.packages[index].components[component].namespace;
                Self { package: package(index), folder: None, name }
            }
            Target::JsonPart(id, direction) => {
                let message = schema.json_message(id);
                let part = message.parts.iter().find(|part| part.direction == direction);
                let name = part.map_or("", |part| part.name.as_str());
                Self { package: package(message.package), folder: None, name }
            }
        }
    }

    /// Path of the file.
    pub(super) fn path(self) -> String {
        format!("{}/{}", self.package, self.file())
    }

    /// Path of the file without extension.
    pub(super) fn stem(self) -> String {
        let Self { package, folder, name } = self;
        folder.map_or_else(|| format!("{package}/{name}"), |folder| format!("{package}/{folder}/{name}"))
    }

    /// Absolute URL under `base`.
    pub(super) fn id(self, base: &str) -> String {
        join(base, &percent_encoded(&self.path()))
    }

    /// The URL of `other`, relative to this file. References therefore remain valid if all files are moved together.
    pub(super) fn refer_to(self, other: Address<'_>) -> String {
        let mut reference = String::new();
        if self.folder.is_some() {
            reference.push_str("../");
        }
        if self.package == other.package {
            reference.push_str(&percent_encoded(&other.file()));
        } else {
            reference.push_str("../");
            reference.push_str(&percent_encoded(&other.path()));
        }
        reference
    }

    /// The `$defs` name in the bundle of `package`. Messages of other packages use their full ROS name, with dots as
    /// separators. Full names are unique, and code generators derive readable type names from them.
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

/// The path of the bundle of `package`. The bundle is outside the package folder, so its name can't clash with a
/// message.
pub(super) fn bundle_path(package: &Package) -> String {
    format!("{}.bundle{EXTENSION}", package.name)
}

/// Absolute URL of the bundle of `package`.
pub(super) fn bundle_id(package: &Package, base: &str) -> String {
    join(base, &percent_encoded(&bundle_path(package)))
}

/// The URL of a definition inside its bundle.
pub(super) fn within_bundle(definition: &str) -> String {
    let pointer = definition.replace('~', "~0").replace('/', "~1");
    format!("#/$defs/{}", percent_encoded(&pointer))
}

fn join(base: &str, path: &str) -> String {
    format!("{}/{path}", base.trim_end_matches('/'))
}
