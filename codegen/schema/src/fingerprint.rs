//! Fingerprints of definitions: PX4's message hash and the ROS type hash (RIHS01).
//!
//! ```
//! # use uavspec_schema::{Form, PackageInput, SourceMap, msg::Dialect, read};
//! # let mut sources = SourceMap::default();
//! # let id = sources.add("Wind.msg", "uint64 timestamp  # [us] Time\nfloat32 speed  # [m/s] [@range 0, 60] Speed\n".into()).unwrap();
//! # let packages = [PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])];
//! # let (schema, diagnostics) = read(&sources, &packages);
//! use uavspec_schema::fingerprint::ros_name;
//!
//! assert_eq!(ros_name(&schema, &schema.messages[0]), "px4_msgs/msg/Wind");
//! ```

use std::collections::BTreeSet;
use std::fmt::{self, Write as _};

use sha2::{Digest as _, Sha256};
use uavspec_runtime::Scalar;

use super::id::MessageId;
use super::layout::EMPTY_MEMBER;
use super::model::{Element, Interface, Message, Package, Schema, Type, shape_text};
use crate::msg::Kind;
use crate::msg::ast::Shape;
use crate::parallel::in_parts;

/// The 32-bit FNV-1a hash.
struct Fnv1a(u32);

impl Fnv1a {
    const OFFSET_BASIS: u32 = 0x811c_9dc5;
    const PRIME: u32 = 0x0100_0193;
}

impl fmt::Write for Fnv1a {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            self.0 = (self.0 ^ u32::from(byte)).wrapping_mul(Self::PRIME);
        }
        Ok(())
    }
}

/// PX4's hash of the fields of a message.
pub(crate) fn message_hash(schema: &Schema, message: &Message) -> u32 {
    let mut hash = Fnv1a(Fnv1a::OFFSET_BASIS);
    // Hashing can't fail.
    let _ = write_fields(schema, message, &mut hash);
    hash.0
}

/// The text that PX4's message hash covers: a line with type and name for each field. Nested fields follow the field
/// that contains them.
pub fn hashed_text(schema: &Schema, message: &Message) -> String {
    let mut text = String::new();
    // Writing to a string can't fail.
    let _ = write_fields(schema, message, &mut text);
    text
}

fn write_fields(schema: &Schema, message: &Message, output: &mut impl fmt::Write) -> fmt::Result {
    // Use an explicit stack, because the input determines the nesting depth.
    let mut open = vec![message.fields.iter()];
    while let Some(fields) = open.last_mut() {
        let Some(field) = fields.next() else {
            open.pop();
            continue;
        };
        match field.ty.element {
            Element::Message(id) => {
                let nested = schema.message(id);
                output.write_str(&nested.name)?;
                open.push(nested.fields.iter());
            }
            Element::Scalar(scalar) => output.write_str(scalar.name())?,
            Element::Text(_) | Element::String { .. } => {
                let single = Type { shape: Shape::Single, ..field.ty };
                output.write_str(&schema.type_text(message, single))?;
            }
        }
        writeln!(output, "{} {}", shape_text(field.ty.shape), field.name)?;
    }
    Ok(())
}

/// The type numbers in a ROS type description (`type_description_interfaces/msg/FieldType`).
mod type_id {
    use uavspec_runtime::Scalar;

    pub(super) const NESTED: u32 = 1;
    pub(super) const STRING: u32 = 17;
    pub(super) const WSTRING: u32 = 18;
    pub(super) const BOUNDED_STRING: u32 = 21;
    pub(super) const BOUNDED_WSTRING: u32 = 22;
    pub(super) const ARRAY: u32 = 48;
    pub(super) const BOUNDED_SEQUENCE: u32 = 96;
    pub(super) const UNBOUNDED_SEQUENCE: u32 = 144;

    pub(super) fn of(scalar: Scalar) -> u32 {
        match scalar {
            Scalar::Int8 => 2,
            // ROS 2 converts `char` to `uint8` before hashing.
            Scalar::UInt8 | Scalar::Char => 3,
            Scalar::Int16 => 4,
            Scalar::UInt16 => 5,
            Scalar::Int32 => 6,
            Scalar::UInt32 => 7,
            Scalar::Int64 => 8,
            Scalar::UInt64 => 9,
            Scalar::Float32 => 10,
            Scalar::Float64 => 11,
            Scalar::Bool => 15,
            Scalar::Byte => 16,
        }
    }
}

/// A field of a type description.
struct DescribedField {
    name: String,
    type_id: u32,
    capacity: u32,
    string_capacity: u32,
    nested: String,
}

impl DescribedField {
    fn scalar(name: &str, scalar: Scalar) -> Self {
        Self {
            name: name.to_owned(),
            type_id: type_id::of(scalar),
            capacity: 0,
            string_capacity: 0,
            nested: String::new(),
        }
    }

    fn nested(name: &str, type_name: String) -> Self {
        Self {
            name: name.to_owned(),
            type_id: type_id::NESTED,
            capacity: 0,
            string_capacity: 0,
            nested: type_name,
        }
    }

    fn shaped(mut self, shape: Shape) -> Self {
        let (offset, capacity) = match shape {
            Shape::Single => (0, 0),
            Shape::Array(length) => (type_id::ARRAY, length),
            Shape::Bounded(bound) => (type_id::BOUNDED_SEQUENCE, bound),
            Shape::Sequence => (type_id::UNBOUNDED_SEQUENCE, 0),
        };
        self.type_id += offset;
        self.capacity = capacity;
        self
    }
}

/// The full ROS name of a message: `package/kind/Name`.
pub fn ros_name(schema: &Schema, message: &Message) -> String {
    let package = &schema.package_of(message).ros_package;
    format!("{package}/{}/{}", message.kind.name(), message.name)
}

/// The full ROS name of a service or action.
pub fn interface_name(package: &Package, interface: &Interface) -> String {
    format!("{}/{}/{}", package.ros_package, interface.kind.name(), interface.name)
}

fn described_fields(schema: &Schema, message: &Message) -> Vec<DescribedField> {
    if message.fields.is_empty() {
        return vec![DescribedField::scalar(EMPTY_MEMBER, Scalar::UInt8)];
    }
    message
        .fields
        .iter()
        .map(|field| {
            let ty = field.ty.written();
            let described = match ty.element {
                Element::Scalar(scalar) => DescribedField::scalar(&field.name, scalar),
                Element::Text(_) => DescribedField::scalar(&field.name, Scalar::Char),
                Element::String { wide, bound } => DescribedField {
                    type_id: match (wide, bound) {
                        (false, None) => type_id::STRING,
                        (true, None) => type_id::WSTRING,
                        (false, Some(_)) => type_id::BOUNDED_STRING,
                        (true, Some(_)) => type_id::BOUNDED_WSTRING,
                    },
                    string_capacity: bound.unwrap_or(0),
                    ..DescribedField::nested(&field.name, String::new())
                },
                Element::Message(id) => {
                    DescribedField::nested(&field.name, ros_name(schema, schema.message(id)))
                }
            };
            described.shaped(ty.shape)
        })
        .collect()
}

/// Writes the canonical JSON of a type description, which is the input of the hash. The JSON is ASCII, with the
/// separators `", "` and `": "`.
fn write_description(out: &mut String, type_name: &str, fields: &[DescribedField]) {
    let _ = write!(out, "{{\"type_name\": \"{type_name}\", \"fields\": [");
    for (index, field) in fields.iter().enumerate() {
        let separator = if index == 0 { "" } else { ", " };
        let DescribedField { name, type_id, capacity, string_capacity, nested } = field;
        let _ = write!(
            out,
            "{separator}{{\"name\": \"{name}\", \"type\": {{\"type_id\": {type_id}, \"capacity\": {capacity}, \
             \"string_capacity\": {string_capacity}, \"nested_type_name\": \"{nested}\"}}}}"
        );
    }
    out.push_str("]}");
}

/// A type description, and the descriptions that it refers to by name.
struct Description {
    type_name: String,
    fields: Vec<DescribedField>,
    referenced: Vec<(String, Vec<DescribedField>)>,
}

impl Description {
    fn hash(mut self) -> String {
        self.referenced.sort_by(|left, right| left.0.cmp(&right.0));
        self.referenced.dedup_by(|left, right| left.0 == right.0);
        let mut json = String::from("{\"type_description\": ");
        write_description(&mut json, &self.type_name, &self.fields);
        json.push_str(", \"referenced_type_descriptions\": [");
        for (index, (type_name, fields)) in self.referenced.iter().enumerate() {
            json.push_str(if index == 0 { "" } else { ", " });
            write_description(&mut json, type_name, fields);
        }
        json.push_str("]}");
        let hash: String = Sha256::digest(json.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect();
        format!("RIHS01_{hash}")
    }
}

/// All messages that `roots` refer to, directly or indirectly.
fn referenced(schema: &Schema, roots: impl IntoIterator<Item = MessageId>) -> BTreeSet<MessageId> {
    let mut found = BTreeSet::new();
    let mut open: Vec<MessageId> = roots.into_iter().collect();
    while let Some(id) = open.pop() {
        open.extend(schema.message(id).nested().filter(|nested| found.insert(*nested)));
    }
    found
}

fn describe_all(
    schema: &Schema,
    ids: impl IntoIterator<Item = MessageId>,
) -> Vec<(String, Vec<DescribedField>)> {
    let describe = |id| {
        let message = schema.message(id);
        (ros_name(schema, message), described_fields(schema, message))
    };
    ids.into_iter().map(describe).collect()
}

/// Sets the hashes of all messages and services. `known` returns PX4's hash and the ROS type hash of a definition, given its
/// package and its full ROS name. Unknown hashes are calculated.
pub fn add_hashes(schema: &mut Schema, known: impl Fn(&Package, &str) -> Option<(u32, String)> + Sync) {
    let ids: Vec<MessageId> = (0..).map(MessageId).take(schema.messages.len()).collect();
    let hashes = |id: &MessageId| {
        let message = schema.message(*id);
        known(schema.package_of(message), &ros_name(schema, message))
            .unwrap_or_else(|| (message_hash(schema, message), type_hash(schema, *id)))
    };
    let of_messages = in_parts(&ids, |ids| ids.iter().map(hashes).collect::<Vec<_>>());
    let mut of_interfaces = Vec::new();
    for (at, package) in schema.packages.iter().enumerate() {
        of_interfaces.extend(package.interfaces.iter().map(|interface| {
            let hashes = known(package, &interface_name(package, interface));
            hashes.map(|(_, hash)| hash).or_else(|| service_hash(schema, interface, at))
        }));
    }
    for (message, hashes) in schema.messages.iter_mut().zip(of_messages.into_iter().flatten()) {
        (message.hash, message.type_hash) = hashes;
    }
    let interfaces = schema.packages.iter_mut().flat_map(|package| &mut package.interfaces);
    for (interface, hash) in interfaces.zip(of_interfaces) {
        interface.type_hash = hash;
    }
}

/// The ROS type hash of a message.
pub fn type_hash(schema: &Schema, id: MessageId) -> String {
    let message = schema.message(id);
    Description {
        type_name: ros_name(schema, message),
        fields: described_fields(schema, message),
        referenced: describe_all(schema, referenced(schema, [id])),
    }
    .hash()
}

/// The ROS type hash of a service, or `None` for an action. The description of a service contains the request, the
/// response and an introspection event with both.
pub(crate) fn service_hash(schema: &Schema, interface: &Interface, package: usize) -> Option<String> {
    let (Kind::Service, [request, response]) = (interface.kind, interface.parts.as_slice()) else {
        return None;
    };
    let service = format!("{}/srv/{}", schema.packages[package].ros_package, interface.name);
    Some(hash_of_service(schema, service, [*request, *response]))
}

/// The ROS type hash of the service that an event belongs to, or `None` for other messages.
pub fn service_hash_of_event(schema: &Schema, event: &Message) -> Option<String> {
    let name = ros_name(schema, event);
    let service = name.strip_suffix("_Event").filter(|_| event.kind != Kind::Message)?;
    // Skip the first field, which contains information about the client.
    let mut parts = event.nested().skip(1);
    Some(hash_of_service(schema, service.to_owned(), [parts.next()?, parts.next()?]))
}

fn hash_of_service(schema: &Schema, service: String, parts: [MessageId; 2]) -> String {
    let names = parts.map(|id| ros_name(schema, schema.message(id)));
    let event = format!("{service}_Event");
    let info = "service_msgs/msg/ServiceEventInfo".to_owned();
    let time = "builtin_interfaces/msg/Time".to_owned();
    let at_most_one = Shape::Bounded(1);
    let mut roots = referenced(schema, parts);
    roots.extend(parts);
    let mut described = describe_all(schema, roots);
    described.push((
        event.clone(),
        vec![
            DescribedField::nested("info", info.clone()),
            DescribedField::nested("request", names[0].clone()).shaped(at_most_one),
            DescribedField::nested("response", names[1].clone()).shaped(at_most_one),
        ],
    ));
    described.push((
        info,
        vec![
            DescribedField::scalar("event_type", Scalar::UInt8),
            DescribedField::nested("stamp", time.clone()),
            DescribedField::scalar("client_gid", Scalar::UInt8).shaped(Shape::Array(16)),
            DescribedField::scalar("sequence_number", Scalar::Int64),
        ],
    ));
    described.push((
        time,
        vec![DescribedField::scalar("sec", Scalar::Int32), DescribedField::scalar("nanosec", Scalar::UInt32)],
    ));
    let [request, response] = names;
    let fields = vec![
        DescribedField::nested("request_message", request),
        DescribedField::nested("response_message", response),
        DescribedField::nested("event_message", event),
    ];
    Description { type_name: service, fields, referenced: described }.hash()
}
