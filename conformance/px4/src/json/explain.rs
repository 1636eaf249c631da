//! Reports all findings in a JSON message.

use std::borrow::Cow;
use std::fmt::Write as _;

use uavspec_dynamic::{Field, Leaf, MessageType, Violation};
use uavspec_model::json::{Tree, pointer, shortened};
use uavspec_model::{Detail, Findings, Location, Rule};
use uavspec_schema::source::Span;
use uavspec_schema::{Element, MessageId, Shape};

use super::dialect::{Dialect, Dialects};
use super::value::{Expected, as_base64, is_timestamp};
use crate::ValueRules;
use crate::values::{Plans, SharedFields, detail, entries_in_use, is_of_value};

/// The maximum number of missing fields that a finding names.
const MAX_MISSING: usize = 8;

/// The maximum number of unknown fields to report separately for each object.
const MAX_UNKNOWN: usize = 16;

/// The origin of a message, for findings.
#[derive(Clone, Copy, Debug)]
pub struct MessageOrigin<'m> {
    /// The type.
    pub id: MessageId,
    /// The name in findings: the topic or type.
    pub name: &'m str,
    /// The location.
    pub location: Location,
    /// The key of the message in the record, if the record has other members.
    pub key: Option<&'m str>,
    /// True if the rosbridge dialects are allowed.
    pub is_rosbridge: bool,
    /// The only fields to check, if the schema of the message differs from the definition.
    pub shared: Option<&'m SharedFields>,
}

impl Plans<'_> {
    /// Reports all findings in a message. Returns the dialects that the message uses.
    pub fn explain(&self, origin: MessageOrigin<'_>, tree: &Tree<'_>, findings: &mut Findings) -> Dialects {
        self.explain_with_ignored(origin, tree, findings).0
    }

    /// Like `explain`, but also returns true if unused array entries had findings that were ignored. A single-pass
    /// reader can't know the number of used entries, since that number may follow the array.
    pub fn explain_with_ignored(
        &self,
        origin: MessageOrigin<'_>,
        tree: &Tree<'_>,
        findings: &mut Findings,
    ) -> (Dialects, bool) {
        let mut explaining = Explaining {
            rules: self.rules,
            origin,
            findings,
            dialects: Dialects::default(),
            path: String::new(),
            pointer: origin.key.map(|key| pointer(&[key])).unwrap_or_default(),
            elements: 0,
            is_unused: false,
            has_ignored: false,
            subject: origin.name.to_owned(),
        };
        let message_type = self.types.get(origin.id);
        match tree {
            Tree::Object(members) => explaining.members(tree, members, message_type),
            other => {
                let expected = format!("an object with the fields of {}", message_type.name());
                let detail = Detail::differs(expected, other).excerpt(other.excerpt());
                explaining.report(self.rules.json_type, message_type.span(), detail);
            }
        }
        (explaining.dialects, explaining.has_ignored)
    }

    /// The `timestamp` field of a message, if it has one.
    pub fn timestamp(&self, id: MessageId, tree: &Tree<'_>) -> Option<u64> {
        self.types.get(id).fields().iter().find(|field| is_timestamp(field))?;
        u64::try_from(tree.get("timestamp")?.as_integer()?).ok()
    }
}

struct Explaining<'m> {
    rules: &'static ValueRules,
    origin: MessageOrigin<'m>,
    findings: &'m mut Findings,
    dialects: Dialects,
    /// The path in the message, e.g. `events[2].id`.
    path: String,
    /// The path as a JSON pointer into the record.
    pointer: String,
    /// The number of indices in the path.
    elements: usize,
    /// True within an unused array entry, whose values are ignored.
    is_unused: bool,
    /// True if a finding was ignored because it was in an unused entry.
    has_ignored: bool,
    /// The subject of findings: the name of the message and the path without indices.
    subject: String,
}

impl Explaining<'_> {
    fn report(&mut self, rule: &'static Rule, definition: Span, detail: Detail) {
        // Without an index, the subject contains the whole path.
        let detail = if self.elements > 0 { detail.at(self.path.as_str()) } else { detail };
        let detail = detail.located(self.pointer.as_str());
        self.findings.report(rule, &self.subject, self.origin.location, Some(definition), || detail);
    }

    fn violation(&mut self, violation: &Violation<'_>, tree: &Tree<'_>, field: &Field, is_element: bool) {
        if self.is_unused && is_of_value(violation) {
            self.has_ignored = true;
            return;
        }
        let found = tree.to_string();
        let detail = detail(violation, &expected(field, is_element), &found).excerpt(excerpt(field, tree));
        self.report(self.rules.violated_by(violation), field.span, detail);
    }

    /// Runs `work` for a member: the path of its findings ends with `name`, and their JSON pointer ends with `key`.
    fn within(&mut self, key: &str, name: &str, work: impl FnOnce(&mut Self)) {
        let (path, subject, location) = (self.path.len(), self.subject.len(), self.pointer.len());
        if path > 0 {
            self.path.push('.');
        }
        self.path.push_str(name);
        self.subject.push('.');
        self.subject.push_str(name);
        self.pointer.push_str(&pointer(&[key]));
        work(self);
        self.path.truncate(path);
        self.subject.truncate(subject);
        self.pointer.truncate(location);
    }

    /// Checks the members of an object.
    fn members(
        &mut self,
        object: &Tree<'_>,
        members: &[(Cow<'_, str>, Tree<'_>)],
        message_type: MessageType<'_>,
    ) {
        // A nested message is checked only if its schema equals the definition.
        let shared = self.origin.shared.filter(|_| self.path.is_empty());
        let mut times = vec![0_u32; message_type.fields().len()];
        let mut unknown = 0;
        for (key, value) in members {
            let Some(index) = message_type.fields().iter().position(|field| *field.name == **key) else {
                if shared.is_some() {
                    continue;
                }
                unknown += 1;
                if unknown <= MAX_UNKNOWN {
                    let name = shortened(key).escape_debug().to_string();
                    let detail = Detail::new(format!(
                        "{} has no such field, but the message contains {value}",
                        message_type.name()
                    ))
                    .excerpt(format!("\"{name}\": {}", value.excerpt()));
                    self.within(key, &name, |within| {
                        within.report(within.rules.members, message_type.span(), detail);
                    });
                }
                continue;
            };
            times[index] = times[index].saturating_add(1);
            let field = &message_type.fields()[index];
            if shared.is_some_and(|shared| !shared.contains_key(&*field.name)) {
                continue;
            }
            // If an array is repeated, the count applies only to the first value. The repetition is a separate finding.
            let count = field.counted_by.filter(|_| times[index] == 1);
            let used = count.and_then(|count| in_use(object, &message_type.fields()[count]));
            self.within(key, &field.name, |within| within.field(value, message_type, field, used));
        }
        if unknown > MAX_UNKNOWN {
            let text = format!("{} more unknown fields", unknown - MAX_UNKNOWN);
            self.report(self.rules.members, message_type.span(), Detail::new(text).excerpt(object.excerpt()));
        }
        for (field, times) in message_type.fields().iter().zip(&times).filter(|(_, times)| **times > 1) {
            let detail = Detail::new(format!("the field appears {times} times")).expected("once");
            self.report_member(field, detail.excerpt(object.excerpt()));
        }
        let is_required = |field: &Field| shared.is_none_or(|shared| shared.get(&*field.name) == Some(&true));
        let absent =
            message_type.fields().iter().zip(times).filter(|(_, times)| *times == 0).map(|(field, _)| field);
        let missing: Vec<&Field> = absent.filter(|field| is_required(field)).collect();
        match missing[..] {
            [] => {}
            [field] => {
                let expected = expected(field, false).to_string();
                let detail = Detail::new(format!("the field is missing; expected {expected}"));
                self.report_member(field, detail.expected(expected).excerpt(object.excerpt()));
            }
            // Many fields of one message usually have one cause.
            [..] => {
                let names: Vec<&str> = missing.iter().take(MAX_MISSING).map(|field| &*field.name).collect();
                let more = missing.len().saturating_sub(MAX_MISSING);
                let more = if more > 0 { format!(" and {more} more") } else { String::new() };
                let text = format!("{} fields are missing: {}{more}", missing.len(), names.join(", "));
                let detail = Detail::new(text).excerpt(object.excerpt());
                self.report(self.rules.members, message_type.span(), detail);
            }
        }
    }

    /// Reports a field that is missing or repeated.
    fn report_member(&mut self, field: &Field, detail: Detail) {
        self.within(&field.name, &field.name, |within| {
            within.report(within.rules.members, field.span, detail);
        });
    }

    /// Checks the value of a field with all its elements. `used` is the number of elements in use.
    fn field(&mut self, tree: &Tree<'_>, message_type: MessageType<'_>, field: &Field, used: Option<usize>) {
        if field.shape == Shape::Single {
            return self.element(tree, message_type, field, false);
        }
        let is_rosbridge = self.origin.is_rosbridge;
        match tree {
            Tree::List(values) => {
                self.length(values.len(), tree, field);
                self.elements(values, message_type, field, used);
            }
            Tree::Text(text) => match as_base64(field, text, is_rosbridge, false) {
                Some(bytes) => {
                    self.dialects.insert(Dialect::Base64);
                    self.length(bytes.len(), tree, field);
                    let values: Vec<Tree<'_>> = bytes.iter().map(|byte| Tree::Int((*byte).into())).collect();
                    self.elements(&values, message_type, field, used);
                }
                None => self.mistyped(tree, field, false),
            },
            _ => self.mistyped(tree, field, false),
        }
    }

    fn length(&mut self, found: usize, tree: &Tree<'_>, field: &Field) {
        if let Err(violation) = field.value_type().check_length(found) {
            self.violation(&violation, tree, field, false);
        }
    }

    fn elements(
        &mut self,
        values: &[Tree<'_>],
        message_type: MessageType<'_>,
        field: &Field,
        used: Option<usize>,
    ) {
        let is_unused = self.is_unused;
        let (length, location) = (self.path.len(), self.pointer.len());
        self.elements += 1;
        for (index, value) in values.iter().enumerate() {
            // Writing to a string can't fail.
            let _ = write!(self.path, "[{index}]");
            let _ = write!(self.pointer, "/{index}");
            self.is_unused = is_unused || used.is_some_and(|used| index >= used);
            self.element(value, message_type, field, true);
            self.path.truncate(length);
            self.pointer.truncate(location);
        }
        self.elements -= 1;
        self.is_unused = is_unused;
    }

    /// Checks a single value, or an element of an array.
    fn element(&mut self, tree: &Tree<'_>, message_type: MessageType<'_>, field: &Field, is_element: bool) {
        let leaf = match tree {
            Tree::Null => Leaf::Null,
            Tree::Bool(value) => Leaf::Bool(*value),
            Tree::Int(value) => Leaf::Int(*value),
            Tree::Float(value, _) => Leaf::Float(*value),
            Tree::Huge(text) => {
                let which = match field.element {
                    Element::Scalar(scalar) if scalar.is_float() => scalar.name(),
                    _ => "any number",
                };
                let (expected, found) = (expected(field, is_element).to_string(), shortened(text));
                let text = format!("expected {expected}, found {found}, which is too large for {which}");
                let detail = Detail::new(text).expected(expected).actual(found);
                return self.report(self.rules.json_type, field.span, detail.excerpt(excerpt(field, tree)));
            }
            Tree::Token(_) => {
                self.dialects.insert(Dialect::BareNan);
                let expected = expected(field, is_element).to_string();
                let text = format!(
                    "expected {expected}, found {tree}, which isn't JSON (Python's json module writes it)"
                );
                let detail = Detail::new(text).expected(expected).actual(tree.to_string());
                return self.report(self.rules.json_type, field.span, detail.excerpt(excerpt(field, tree)));
            }
            Tree::Text(text) => match as_base64(field, text, self.origin.is_rosbridge, is_element) {
                Some(bytes) => {
                    self.dialects.insert(Dialect::Base64);
                    return self.bytes(&bytes, tree, field);
                }
                None => Leaf::Text(text),
            },
            Tree::List(values) => return self.list(values, tree, field, is_element),
            Tree::Object(members) => match field.element {
                Element::Message(id) => return self.members(tree, members, message_type.nested(id)),
                _ => return self.mistyped(tree, field, is_element),
            },
        };
        if let Err(violation) = field.value_type().check_leaf(leaf) {
            self.violation(&violation, tree, field, is_element);
        }
    }

    /// Checks an array that appears in place of a single value. ROS 2 writes text in this form.
    fn list(&mut self, values: &[Tree<'_>], tree: &Tree<'_>, field: &Field, is_element: bool) {
        let byte = |value: &Tree<'_>| u8::try_from(value.as_integer()?).ok();
        if !matches!(field.element, Element::Text(_)) || !self.origin.is_rosbridge {
            return self.mistyped(tree, field, is_element);
        }
        self.dialects.insert(Dialect::NumbersForText);
        let bytes: Option<Vec<u8>> = values.iter().map(byte).collect();
        if let Some(bytes) = bytes {
            return self.bytes(&bytes, tree, field);
        }
        let found = values.iter().find(|value| byte(value).is_none()).unwrap_or(tree);
        let detail = Detail::differs("integers from 0 to 255", found);
        self.report(self.rules.json_type, field.span, detail.excerpt(excerpt(field, tree)));
    }

    /// Checks bytes that represent text.
    fn bytes(&mut self, bytes: &[u8], tree: &Tree<'_>, field: &Field) {
        if let Err(violation) = field.value_type().check_array(bytes) {
            self.violation(&violation, tree, field, false);
        }
    }

    fn mistyped(&mut self, tree: &Tree<'_>, field: &Field, is_element: bool) {
        let detail = Detail::differs(expected(field, is_element), tree).excerpt(excerpt(field, tree));
        self.report(self.rules.json_type, field.span, detail);
    }
}

/// The number of entries in use according to the field that counts them. `None` if that field is not an integer.
fn in_use(object: &Tree<'_>, field: &Field) -> Option<usize> {
    Some(entries_in_use(object.get(&field.name)?.as_integer()?, &field.special))
}

/// The expected JSON type of a value or element, as text.
fn expected(field: &Field, is_element: bool) -> Expected<'_> {
    Expected { field, is_element }
}

/// The excerpt of a value or element for findings.
fn excerpt(field: &Field, tree: &Tree<'_>) -> String {
    format!("\"{}\": {}", field.name, tree.excerpt())
}
