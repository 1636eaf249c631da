//! Where each thing is described, and what refers to it.

use std::cell::OnceCell;
use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::Beside;
use super::markdown::{code, href, link};
use crate::emit::json_schema::{self, Target};
use crate::schema::{
    Dialect, Element, Enum, EnumRef, Form, Interface, Kind, Message, MessageId, Package, Schema, UorbLayout,
};
use crate::source::{SourceMap, Span};

/// Constants that PX4 knows by name; the facts of a message show them.
const KNOWN_CONSTANTS: [&str; 2] = ["MESSAGE_VERSION", "ORB_QUEUE_LENGTH"];

/// Names that mdBook or GitHub gives a meaning to where a page bears them.
const RESERVED_STEMS: [&str; 2] = ["readme", "index"];

/// A field of a message.
pub(super) type FieldRef = (MessageId, usize);

/// Something in a message that has a name and a place on its page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Field(usize),
    Constant(usize),
    Enum(usize),
}

/// The page that describes a message, and what its anchors there start with.
#[derive(Debug)]
struct Place {
    path: String,
    prefix: String,
}

/// All that is described, and where.
#[derive(Debug)]
pub(super) struct Site<'s> {
    pub(super) schema: &'s Schema,
    pub(super) sources: &'s SourceMap,
    beside: &'s Beside,
    /// By message; none for those that aren't listed.
    places: Vec<Option<Place>>,
    /// The fields that hold each message.
    holders: Vec<Vec<FieldRef>>,
    /// The fields that hold each enum.
    enum_holders: BTreeMap<EnumRef, Vec<FieldRef>>,
    /// By message, what tells its enums apart.
    enum_names: Vec<Vec<String>>,
    /// By package, what messages and topics are called.
    names: Vec<HashMap<&'s str, MessageId>>,
    /// By message, what its parts are called; gathered when first asked for.
    parts: Vec<OnceCell<HashMap<&'s str, Part>>>,
}

impl<'s> Site<'s> {
    pub(super) fn new(schema: &'s Schema, sources: &'s SourceMap, beside: &'s Beside) -> Self {
        let count = schema.messages.len();
        let mut site = Self {
            schema,
            sources,
            beside,
            places: (0..count).map(|_| None).collect(),
            holders: vec![Vec::new(); count],
            enum_holders: BTreeMap::new(),
            enum_names: schema.messages.iter().map(enum_names).collect(),
            names: vec![HashMap::new(); schema.packages.len()],
            parts: vec![OnceCell::new(); count],
        };
        for (index, package) in schema.packages.iter().enumerate() {
            site.place(index, package);
        }
        site.gather_holders();
        site
    }

    fn place(&mut self, index: usize, package: &'s Package) {
        let folder = &package.name;
        for id in &package.messages {
            let name = &self.schema.message(*id).name;
            let path = format!("{folder}/{}.md", stem(name));
            self.places[id.0 as usize] = Some(Place { path, prefix: String::new() });
        }
        for interface in &package.interfaces {
            for (id, part) in interface.parts.iter().zip(part_names(interface.kind)) {
                let prefix = format!("{}-", part.to_ascii_lowercase());
                self.places[id.0 as usize] = Some(Place { path: interface_path(package, interface), prefix });
            }
        }
        let names = &mut self.names[index];
        // Messages last: where a message and a topic share a name, the message is meant.
        for id in &package.messages {
            names.extend(self.schema.message(*id).topics.iter().map(|topic| (topic.as_str(), *id)));
        }
        names.extend(package.messages.iter().map(|id| (self.schema.message(*id).name.as_str(), *id)));
    }

    fn gather_holders(&mut self) {
        for (id, message) in self.listed() {
            for (index, field) in message.fields.iter().enumerate() {
                if let Element::Message(nested) = field.ty.element {
                    self.holders[nested.0 as usize].push((id, index));
                }
                if let Some(held) = field.enumeration {
                    self.enum_holders.entry(held).or_default().push((id, index));
                }
            }
        }
    }

    /// The packages that describe anything.
    pub(super) fn packages(&self) -> impl Iterator<Item = &'s Package> + use<'s> {
        self.schema.packages.iter().filter(|package| !package.is_empty())
    }

    /// All messages that have a place, parts of services and actions too.
    fn listed(&self) -> Vec<(MessageId, &'s Message)> {
        let ids = self.schema.packages.iter().flat_map(|package| {
            package.messages.iter().chain(package.interfaces.iter().flat_map(|interface| &interface.parts))
        });
        ids.map(|id| (*id, self.schema.message(*id))).collect()
    }

    /// The page of a message; empty where it has none.
    pub(super) fn path(&self, id: MessageId) -> &str {
        self.places[id.0 as usize].as_ref().map_or("", |place| &place.path)
    }

    /// The fields that hold a message.
    pub(super) fn holders(&self, id: MessageId) -> &[FieldRef] {
        &self.holders[id.0 as usize]
    }

    /// The fields that hold an enum.
    pub(super) fn enum_holders(&self, held: EnumRef) -> &[FieldRef] {
        self.enum_holders.get(&held).map_or(&[], Vec::as_slice)
    }

    /// The message that a package knows by a name or a topic.
    pub(super) fn message_named(&self, package: usize, name: &str) -> Option<MessageId> {
        self.names[package].get(name).copied()
    }

    /// What a message calls so.
    pub(super) fn part_named(&self, id: MessageId, name: &str) -> Option<Part> {
        self.parts[id.0 as usize].get_or_init(|| parts(self.schema.message(id))).get(name).copied()
    }

    /// The anchor of a part of a message.
    pub(super) fn anchor(&self, id: MessageId, part: Part) -> String {
        let message = self.schema.message(id);
        let prefix = self.places[id.0 as usize].as_ref().map_or("", |place| &place.prefix);
        let (kind, name) = match part {
            Part::Field(index) => ("field", message.fields[index].name.clone()),
            Part::Constant(index) => ("constant", message.constants[index].name.clone()),
            Part::Enum(index) => ("enum", self.enum_names[id.0 as usize][index].clone()),
        };
        format!("{prefix}{kind}-{}", name.to_ascii_lowercase())
    }

    /// The address of a part of a message, as seen from a page.
    pub(super) fn href(&self, from: &str, id: MessageId, part: Part) -> String {
        href(from, self.path(id), &self.anchor(id, part))
    }

    /// The memory layout of a message, where it means something: ROS has no uORB.
    pub(super) fn layout(&self, message: &'s Message) -> Option<&'s UorbLayout> {
        message.uorb.as_ref().filter(|_| message.kind == Kind::Message && self.is_px4(message))
    }

    /// Whether PX4 knows a message.
    pub(super) fn is_px4(&self, message: &Message) -> bool {
        self.schema.package_of(message).form == Form::Msg(Dialect::Px4)
    }

    /// What else is generated of `target`: what it is called, and a link to its file.
    pub(super) fn files(&self, from: &str, target: Target) -> Vec<(&'static str, String)> {
        let stem = json_schema::name(self.schema, target);
        let name = stem.rsplit('/').next().unwrap_or(&stem);
        let outputs = [
            ("JSON Schema", &self.beside.schemas, "schema"),
            ("Test vectors", &self.beside.vectors, "vectors"),
        ];
        let file = |(title, folder, kind): (_, &Option<String>, _)| {
            let to = href(from, &format!("{}/{stem}.{kind}.json", folder.as_ref()?), "");
            Some((title, link(&code(&format!("{name}.{kind}.json")), &to)))
        };
        outputs.into_iter().filter_map(file).collect()
    }

    /// The path of the source that holds `span`.
    pub(super) fn source(&self, span: Span) -> &'s str {
        self.sources.path(self.sources.source_of(span))
    }
}

/// The page of a service or action.
pub(super) fn interface_path(package: &Package, interface: &Interface) -> String {
    format!("{}/{}.{}.md", package.name, interface.name, interface.kind.name())
}

/// What the parts of a service or action are called.
pub(super) fn part_names(kind: Kind) -> impl Iterator<Item = &'static str> {
    kind.part_suffixes().iter().map(|suffix| suffix.trim_start_matches('_'))
}

/// Whether the facts of a message show a constant, so that no table need do so.
pub(super) fn is_fact(message: &Message, constant: usize) -> bool {
    let [version, queue_length] = KNOWN_CONSTANTS.map(|known| message.constants[constant].name == known);
    version && message.version.is_some() || queue_length && message.queue_length.is_some()
}

/// The file name of a message's page and picture, without extension.
pub(super) fn stem(name: &str) -> String {
    let is_reserved = RESERVED_STEMS.iter().any(|reserved| name.eq_ignore_ascii_case(reserved));
    if is_reserved { format!("{name}.msg") } else { name.to_owned() }
}

/// What tells each enum from the others of its message.
fn enum_names(message: &Message) -> Vec<String> {
    let mut known = BTreeSet::new();
    let name = |(index, found): (usize, &Enum)| {
        let name = found.prefixes.join("-");
        // The same constants may be held by fields of different types.
        if known.insert(name.clone()) { name } else { format!("{name}-{}", index + 1) }
    };
    message.enums.iter().enumerate().map(name).collect()
}

fn parts(message: &Message) -> HashMap<&str, Part> {
    let enums = message.enums.iter().enumerate().rev();
    let enums = enums
        .flat_map(|(index, found)| found.prefixes.iter().map(move |name| (name.as_str(), Part::Enum(index))));
    let constants = message.constants.iter().enumerate().filter(|(index, _)| !is_fact(message, *index));
    let constants = constants.map(|(index, constant)| (constant.name.as_str(), Part::Constant(index)));
    let fields = message.fields.iter().enumerate();
    let fields = fields.map(|(index, field)| (field.name.as_str(), Part::Field(index)));
    enums.chain(constants).chain(fields).collect()
}
