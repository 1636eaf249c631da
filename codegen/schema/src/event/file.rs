//! Reads a file with event metadata.

use jsonc_parser::ast::{ObjectProp, Value};
use uavspec_runtime::Scalar;
use uavspec_runtime::event::MAX_SUB_ID;

use super::json::{Located, Members, Reader};
use super::{EventEntry, EventEnum, EventKind, scalar};
use crate::diagnostic::{Diagnostic, Problem};
use crate::limits::MAX_NAME_LEN;
use crate::name::is_identifier;
use crate::source::{SourceId, SourceMap};
use crate::span::Span;

/// The number of shown characters of a name that is too long.
const SHOWN_OF_NAME: usize = 20;

/// The known versions of the format.
const VERSIONS: [u32; 2] = [1, 2];

/// A file with event metadata.
#[derive(Debug)]
pub struct EventFile {
    /// The whole file.
    pub span: Span,
    pub(crate) components: Vec<ComponentSource>,
}

/// A component as written in a file.
#[derive(Debug)]
pub(crate) struct ComponentSource {
    pub(crate) id: u8,
    pub(crate) namespace: Located,
    pub(crate) enums: Vec<EventEnum>,
    pub(crate) events: Vec<EventSource>,
    pub(crate) mode_groups: Vec<(u8, Vec<u32>)>,
    pub(crate) protocols: Vec<String>,
    pub(crate) span: Span,
}

/// An event as written in a file.
#[derive(Debug)]
pub(crate) struct EventSource {
    pub(crate) sub_id: u32,
    pub(crate) name: Located,
    pub(crate) group: String,
    pub(crate) kind: Option<(EventKind, Span)>,
    pub(crate) message: Located,
    pub(crate) description: Option<Located>,
    pub(crate) arguments: Vec<ArgumentSource>,
    pub(crate) instance_argument: Option<(u32, Span)>,
    pub(crate) span: Span,
}

/// An argument as written in a file.
#[derive(Debug)]
pub(crate) struct ArgumentSource {
    pub(crate) name: Located,
    pub(crate) ty: Located,
    pub(crate) description: Option<Located>,
}

/// Parses a file with event metadata.
pub(crate) fn parse(sources: &SourceMap, id: SourceId) -> (EventFile, Vec<Diagnostic>) {
    let span = sources.span(id);
    let mut parser = Parser { reader: Reader::new(span) };
    let components = parser.file(sources.text(id)).unwrap_or_default();
    (EventFile { span, components }, parser.reader.diagnostics)
}

struct Parser {
    reader: Reader,
}

impl Parser {
    fn file(&mut self, text: &str) -> Option<Vec<ComponentSource>> {
        let value = self.reader.parse(text)?;
        let known = ["version", "translation", "components"];
        let members = self.reader.members(&value, "event metadata", &known)?;
        if let Some(version) = self.reader.require(&members, "version")
            && let Some(number) = self.reader.number(version, "version")
            && !VERSIONS.contains(&number)
        {
            let span = self.span(version);
            self.reader.report(Problem::EventVersion { version: number }, span);
        }
        let components = self.reader.require(&members, "components")?;
        self.each(components, "components", Self::component)
    }

    /// Reads each member of an object with arbitrary member names.
    fn each<'v, 's, T>(
        &mut self,
        value: &'v Value<'s>,
        what: &str,
        mut read: impl FnMut(&mut Self, &Located, &'v ObjectProp<'s>) -> Option<T>,
    ) -> Option<Vec<T>> {
        let members = self.reader.object(value, what)?;
        Some(members.iter().filter_map(|member| read(self, &self.reader.key(member), member)).collect())
    }

    /// Like [`Self::each`], for a member that may be absent.
    fn each_of<'v, 's, T>(
        &mut self,
        members: &Members<'v, 's>,
        name: &str,
        read: impl FnMut(&mut Self, &Located, &'v ObjectProp<'s>) -> Option<T>,
    ) -> Vec<T> {
        members.get(name).and_then(|value| self.each(value, name, read)).unwrap_or_default()
    }

    fn span(&self, value: &Value<'_>) -> Span {
        self.reader.span(jsonc_parser::common::Ranged::range(value))
    }

    /// Parses the name of a member as a number from `min` to `max`. Reports any other name.
    fn number<N: TryFrom<i128>>(
        &mut self,
        key: &Located,
        what: &'static str,
        (min, max): (i128, i128),
    ) -> Option<N> {
        let number = key.text.parse::<i128>().ok().filter(|number| (min..=max).contains(number));
        let number = number.and_then(|number| N::try_from(number).ok());
        if number.is_none() {
            self.reader.report(Problem::EventNumber { text: key.text.clone(), what, min, max }, key.span);
        }
        number
    }

    /// Checks a name. An invalid name doesn't prevent reading, unless it is too long. Long names are rejected, because
    /// each event repeats the name of its group, and each mistake repeats a name.
    fn name(
        &mut self,
        name: Option<Located>,
        what: &'static str,
        is_valid: impl Fn(&str) -> bool,
        form: &'static str,
    ) -> Option<Located> {
        let Located { text, span } = name?;
        if text.len() > MAX_NAME_LEN {
            let name = text.chars().take(SHOWN_OF_NAME).chain(['…']).collect();
            self.reader.report(Problem::EventName { name, what, form: "at most 255 bytes" }, span);
            return None;
        }
        if !is_valid(&text) {
            self.reader.report(Problem::EventName { name: text.clone(), what, form }, span);
        }
        Some(Located { text, span })
    }

    fn component(&mut self, key: &Located, member: &ObjectProp<'_>) -> Option<ComponentSource> {
        let id = self.number(key, "a component id", (0, 255));
        let known = ["namespace", "enums", "event_groups", "supported_protocols", "navigation_mode_groups"];
        let members = self.reader.members(&member.value, "a component", &known)?;
        let namespace = self.reader.required_text(&members, "namespace");
        let namespace = self.name(namespace, "a namespace", is_lower_name, LOWER_NAME);
        let enums = self.each_of(&members, "enums", Self::enumeration);
        let groups = self.each_of(&members, "event_groups", Self::group);
        let protocols = members.get("supported_protocols").and_then(|value| {
            let list = self.reader.list(value, "supported_protocols")?;
            Some(list.iter().filter_map(|value| self.reader.string(value, "a protocol")).collect::<Vec<_>>())
        });
        let mode_groups = members.get("navigation_mode_groups").and_then(|value| self.mode_groups(value));
        Some(ComponentSource {
            id: id?,
            namespace: namespace?,
            enums,
            events: groups.into_iter().flatten().collect(),
            mode_groups: mode_groups.unwrap_or_default(),
            protocols: protocols.into_iter().flatten().map(|protocol| protocol.text).collect(),
            span: key.span,
        })
    }

    fn mode_groups(&mut self, value: &Value<'_>) -> Option<Vec<(u8, Vec<u32>)>> {
        let members = self.reader.members(value, "navigation_mode_groups", &["groups"])?;
        let groups = self.reader.require(&members, "groups")?;
        self.each(groups, "groups", |parser, key, member| {
            let modes = parser.reader.list(&member.value, "a group of modes")?;
            let modes = modes.iter().filter_map(|mode| parser.reader.number(mode, "a mode")).collect();
            Some((parser.number(key, "the bit of a group of modes", (0, 63))?, modes))
        })
    }

    fn enumeration(&mut self, name: &Located, member: &ObjectProp<'_>) -> Option<EventEnum> {
        let is_type = |name: &str| is_identifier(name) && name.ends_with("_t");
        let form = "letters, digits and `_`, with `_t` at the end";
        let name = self.name(Some(name.clone()), "an enum", is_type, form);
        let known = ["type", "description", "is_bitfield", "separator", "entries"];
        let members = self.reader.members(&member.value, "an enum", &known)?;
        let ty = self.reader.required_text(&members, "type");
        let found = ty.as_ref().and_then(|ty| scalar(&ty.text)).filter(|scalar| !scalar.is_float());
        if let Some(ty) = ty.filter(|_| found.is_none()) {
            self.reader.report(Problem::EventEnumType { name: ty.text }, ty.span);
        }
        let scalar = found?;
        let description = self.line(&members, "description");
        let is_bits = members.get("is_bitfield").and_then(|value| self.reader.flag(value, "is_bitfield"));
        let separator = self.reader.text(&members, "separator").map(|separator| separator.text);
        let is_bits = is_bits.unwrap_or_default();
        let mut entries = self
            .each_of(&members, "entries", |parser, key, member| parser.entry(key, member, scalar, is_bits));
        // If several entries have the same value, use the first one.
        entries.sort_by_key(|entry| entry.value);
        let mut first: Option<EventEntry> = None;
        entries.retain(|entry| {
            let is_repeated = first.as_ref().is_some_and(|first| first.value == entry.value);
            if is_repeated {
                let name = entry.value.to_string();
                self.reader.report(Problem::DuplicateMember { name, what: "an enum" }, entry.span);
            } else {
                first = Some(entry.clone());
            }
            !is_repeated
        });
        let name = name?;
        Some(EventEnum {
            name: name.text,
            scalar,
            description,
            separator: is_bits.then(|| separator.unwrap_or_else(|| "|".to_owned())),
            entries,
            span: name.span,
        })
    }

    fn entry(
        &mut self,
        key: &Located,
        member: &ObjectProp<'_>,
        scalar: Scalar,
        is_bits: bool,
    ) -> Option<EventEntry> {
        let value: Option<i128> = self.number(key, "a value of the enum", scalar.integer_bounds()?);
        if let Some(value) = value.filter(|value| is_bits && value.count_ones() != 1) {
            self.reader.report(Problem::EventBit { value }, key.span);
        }
        let members = self.reader.members(&member.value, "an entry", &["name", "description", "comment"])?;
        let name = self.reader.required_text(&members, "name");
        let name = self.name(name, "an entry", is_lower_name, LOWER_NAME);
        self.reader.require(&members, "description");
        let description = self.line(&members, "description");
        Some(EventEntry { value: value?, name: name?.text, description, span: key.span })
    }

    /// Reads the one-line text of an optional member. Empty if the member is absent.
    fn line(&mut self, members: &Members<'_, '_>, name: &'static str) -> String {
        let Some(line) = self.reader.text(members, name) else { return String::new() };
        if line.text.contains('\n') {
            self.reader.report(Problem::EventLine { what: name }, line.span);
        }
        line.text
    }

    fn group(&mut self, group: &Located, member: &ObjectProp<'_>) -> Option<Vec<EventSource>> {
        let group = self.name(Some(group.clone()), "a group of events", is_lower_name, LOWER_NAME)?;
        let members = self.reader.members(&member.value, "a group of events", &["events"])?;
        Some(self.each_of(&members, "events", |parser, key, member| parser.event(key, member, &group.text)))
    }

    fn event(&mut self, key: &Located, member: &ObjectProp<'_>, group: &str) -> Option<EventSource> {
        let sub_id = self.number(key, "the lower 24 bits of an event id", (0, i128::from(MAX_SUB_ID)));
        let known = ["name", "message", "description", "type", "instance_arg_index", "arguments"];
        let members = self.reader.members(&member.value, "an event", &known)?;
        let name = self.reader.required_text(&members, "name");
        let name = self.name(name, "an event", is_identifier, NAME);
        let message = self.reader.required_text(&members, "message");
        let description = self.reader.text(&members, "description");
        let kind = self.reader.text(&members, "type").and_then(|ty| {
            let kinds = [EventKind::Summary, EventKind::AppendChecks];
            let kind = kinds.into_iter().find(|kind| kind.name() == ty.text);
            if kind.is_none() {
                self.reader
                    .report(Problem::EventType { name: ty.text.clone(), group: group.to_owned() }, ty.span);
            }
            Some((kind?, ty.span))
        });
        let instance = members
            .get("instance_arg_index")
            .and_then(|value| Some((self.reader.number(value, "instance_arg_index")?, self.span(value))));
        let arguments = match members.get("arguments") {
            Some(value) => self.arguments(value),
            None => Some(Vec::new()),
        };
        Some(EventSource {
            sub_id: sub_id?,
            name: name?,
            group: group.to_owned(),
            kind,
            message: message?,
            description,
            arguments: arguments?,
            instance_argument: instance,
            span: key.span,
        })
    }

    /// Reads the arguments. Returns `None` if one of them can't be read, because the offsets of later arguments are
    /// then unknown.
    fn arguments(&mut self, value: &Value<'_>) -> Option<Vec<ArgumentSource>> {
        let list = self.reader.list(value, "arguments")?;
        let arguments: Vec<Option<ArgumentSource>> = list.iter().map(|value| self.argument(value)).collect();
        arguments.into_iter().collect()
    }

    fn argument(&mut self, value: &Value<'_>) -> Option<ArgumentSource> {
        let members = self.reader.members(value, "an argument", &["name", "type", "description"])?;
        let name = self.reader.required_text(&members, "name");
        let name = self.name(name, "an argument", is_identifier, NAME);
        let ty = self.reader.required_text(&members, "type");
        let description = self.reader.text(&members, "description");
        Some(ArgumentSource { name: name?, ty: ty?, description })
    }
}

/// The syntax of event and argument names.
const NAME: &str = "letters, digits and `_`, and start with a letter";

/// The syntax of namespace, group and entry names.
const LOWER_NAME: &str = "lower-case letters, digits and `_`, and start with a letter";

fn is_lower_name(name: &str) -> bool {
    is_identifier(name) && !name.bytes().any(|byte| byte.is_ascii_uppercase())
}
