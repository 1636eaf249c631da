//! Texts about the symbol, the unit, the annotation or the rule under the cursor.

mod markup;

use std::ops::Range;

use lsp_types::{Contents, Hover, MarkupContent, MarkupKind};
use uavspec_lint::rule;
use uavspec_runtime::Number;
use uavspec_runtime::event::{Profile, Text};
use uavspec_schema::event::scalar_name;
use uavspec_schema::fingerprint::ros_name;
use uavspec_schema::json_type::{Definition, Member as JsonMember};
use uavspec_schema::msg::annotation::{Annotation, Note};
use uavspec_schema::msg::constraint::CONSTRAINTS;
use uavspec_schema::msg::statement::Statement;
use uavspec_schema::source::Span;
use uavspec_schema::{
    Constant, Dialect, Enum, EnumRef, ErrorCode, Event, EventArgument, EventComponent, EventEntry, EventEnum,
    Field, Form, JsonMessage, JsonType, Message, MessageId, Package, Schema, directive, unit,
};

use self::markup::Markup;
use super::snapshot::Document;
use super::symbol::{self, Symbol, has_prefix};

/// A function that returns the history of an item in published releases, for hover texts. The arguments are the full
/// ROS name of a message, such as `px4_msgs/msg/VehicleStatus`, and the name of a field or constant. The result lists
/// the releases that contain the item, and the changes, as lines of text.
pub type History<'a> = dyn Fn(&str, Option<&str>) -> Vec<String> + 'a;

/// The maximum number of listed members of an enum.
const MAX_MEMBERS: usize = 30;

/// The maximum number of listed changes in releases.
const MAX_CHANGES: usize = 10;

/// The text about the item at a byte offset.
pub(super) fn hover(document: &Document<'_>, history: &History<'_>, offset: usize) -> Option<Hover> {
    let (range, text) = match symbol::at(document, offset) {
        Some(found) => {
            let text = Describer { schema: &document.snapshot.schema, history }.symbol(&found.symbol)?;
            (document.snapshot.offsets(document.id, found.span), text)
        }
        None => of_directive(document, offset).or_else(|| of_annotation(document, offset))?,
    };
    let contents = Contents::MarkupContent(MarkupContent { kind: MarkupKind::Markdown, value: text });
    Some(Hover { contents, range: Some(document.lines.range(range)) })
}

/// The range of the rule that a directive names, and the text about this rule.
fn of_directive(document: &Document<'_>, offset: usize) -> Option<(Range<usize>, String)> {
    let line = document.lines.line_of(offset);
    let start = document.lines.start(line);
    let (found, _) = directive::find(document.lines.line(line), Span::default())?;
    let range = start + found.span.start as usize..start + found.span.end as usize;
    let rule = rule(found.rule).filter(|_| range.contains(&offset))?;
    let mut text = Markup::new(rule.id);
    text.paragraph(&rule.purpose());
    text.paragraph(rule.fix);
    Some((range, text.finish()))
}

/// The range of a unit or an annotation, and the text about it.
fn of_annotation(document: &Document<'_>, offset: usize) -> Option<(Range<usize>, String)> {
    let tree = document.tree()?;
    let lines = tree.parts.iter().flat_map(|part| &part.lines);
    let notes = lines.filter_map(|line| line.comment.as_ref()?.note.as_ref());
    let with_parameters = |note: &'_ Note<'_>| -> Vec<(Span, String)> {
        let all = std::iter::once(note).chain(&note.parameters);
        all.flat_map(|note| &note.annotations)
            .filter_map(|annotation| Some((annotation.span, about_annotation(annotation)?)))
            .collect()
    };
    let mut found = notes
        .flat_map(with_parameters)
        .map(|(span, text)| (document.snapshot.offsets(document.id, span), text));
    found.find(|(range, _)| range.contains(&offset))
}

fn about_annotation(annotation: &Annotation<'_>) -> Option<String> {
    let mut text;
    match &annotation.statement {
        Statement::Unit(symbol) => {
            text = Markup::new(&format!("[{symbol}]"));
            text.paragraph(match unit::lookup(symbol) {
                Some(unit) => unit.name,
                None if unit::is_known(symbol) => "a combination of units",
                None => "a unit that uavspec doesn't know",
            });
        }
        Statement::Constraint(kind, ..) => {
            text = Markup::new(kind.form);
            text.paragraph(&kind.words.replace(['{', '}'], ""));
        }
        Statement::Attribute(attribute, value) => {
            text = Markup::new(attribute.form);
            text.paragraph(&attribute.to_text(value));
        }
        Statement::Enum(_) => {
            text = Markup::new("[@enum PREFIX]");
            text.paragraph("The value is one of the constants with this prefix.");
        }
        Statement::Flags(_) => {
            text = Markup::new("[@flags PREFIX]");
            text.paragraph("The value is a mask of the constants with this prefix.");
        }
        Statement::Count(_) => {
            text = Markup::new("[@count field]");
            text.paragraph("The value is the number of used elements of an array.");
        }
        _ => return None,
    }
    Some(text.finish())
}

struct Describer<'a> {
    schema: &'a Schema,
    history: &'a History<'a>,
}

impl Describer<'_> {
    fn symbol(&self, symbol: &Symbol) -> Option<String> {
        let schema = self.schema;
        let text = match symbol {
            Symbol::Message(id) => self.message(schema.message(*id)),
            Symbol::Field(id, at) => self.field(*id, schema.message(*id).fields.get(*at)?),
            Symbol::Constant(id, at) => self.constant(*id, *at)?,
            Symbol::Prefix(id, prefix) => self.prefix(*id, prefix),
            Symbol::ErrorCode(package, code) => {
                let tables = schema.packages.get(*package)?.error_tables.iter();
                let codes = tables.flat_map(|table| &table.codes);
                self.error_code(*package, codes.into_iter().find(|found| found.code == *code)?)
            }
            Symbol::JsonType(id) => self.json_type(schema.json_type(*id)),
            Symbol::JsonMessage(id) => about_json_message(schema.json_message(*id)),
            Symbol::Event(package, component, event) => {
                let package = schema.packages.get(*package)?;
                let component = package.components.get(*component)?;
                about_event(package, component, component.events.get(*event)?)
            }
            Symbol::EventEnum(package, reference) => {
                about_event_enum(schema.packages.get(*package)?.event_enum(*reference))
            }
        };
        Some(text.finish())
    }

    fn message(&self, message: &Message) -> Markup {
        let mut text = Markup::new(&format!("{}/{}", self.schema.package_of(message).name, message.name));
        text.paragraph(&message.docs.text());
        text.fact_list("topics", &message.topics);
        text.fact("version", message.version);
        text.fact("queue length", message.queue_length);
        if self.is_px4(message) {
            let size = |size: usize| format!("{size} bytes");
            text.fact("uORB size", message.uorb.as_ref().map(|layout| size(layout.size)));
            text.fact(
                "hash",
                Some(message.hash).filter(|hash| *hash != 0).map(|hash| format!("{hash:#010x}")),
            );
        }
        let at_least = if message.cdr.is_fixed { "" } else { "at least " };
        text.fact("CDR size", Some(format!("{at_least}{} bytes", message.cdr.min)));
        text.fact("type hash", Some(&message.type_hash).filter(|hash| !hash.is_empty()));
        self.add_history(&mut text, message, None);
        text
    }

    fn field(&self, id: MessageId, field: &Field) -> Markup {
        let message = self.schema.message(id);
        let mut text = Markup::new(&format!("{} {}", self.schema.type_text(message, field.ty), field.name));
        text.paragraph(&field.description);
        let group = field.group.and_then(|group| message.groups.get(group));
        text.fact("group", group.map(|group| &group.summary).filter(|summary| !summary.is_empty()));
        text.fact("unit", field.unit.as_deref().map(unit_text));
        for kind in CONSTRAINTS {
            let found = field.constraint(kind).filter(|constraint| !constraint.is_unbounded());
            let stated = found.map(|constraint| {
                let value =
                    constraint.valid_values().or_else(|| constraint.stated.value().map(ToString::to_string));
                let when = if constraint.text.is_empty() {
                    String::new()
                } else {
                    format!(" ({})", constraint.text)
                };
                value.unwrap_or_else(|| "empty".to_owned()) + &when
            });
            text.fact(kind.name, stated);
        }
        field.attributes().for_each(|(attribute, value)| text.fact(attribute.name, Some(value)));
        text.fact("default", field.default.as_ref());
        let counted = field.counts.and_then(|at| message.fields.get(at));
        text.fact("counts the used elements of", counted.map(|array| &array.name));
        let slot = message.uorb.as_ref().filter(|_| self.is_px4(message)).and_then(|layout| {
            let slot = layout.slots.iter().find(|slot| slot.name == field.name && slot.field.is_some())?;
            Some(format!("offset {}, {} of {} bytes", slot.offset, slot.size, layout.size))
        });
        text.fact("uORB memory", slot);
        if let Some(reference) = field.enumeration {
            let owner = self.schema.message(reference.message);
            add_members(&mut text, owner, self.schema.enumeration(reference));
        }
        self.add_history(&mut text, message, Some(&field.name));
        text
    }

    fn constant(&self, id: MessageId, at: usize) -> Option<Markup> {
        let message = self.schema.message(id);
        let constant = message.constants.get(at)?;
        let mut text = Markup::new(&format!("{} = {}", constant.name, constant.value));
        text.paragraph(&constant.description);
        let number = match constant.value.number() {
            Some(Number::Int(value)) if value > 9 => Some(format!("{value:#x}")),
            _ => None,
        };
        text.fact("hexadecimal", number);
        text.fact_list("value of", &self.fields_with(id, at));
        let parameters =
            constant.parameters.iter().enumerate().filter(|(_, parameter)| !parameter.is_unused());
        let rows = parameters.map(|(at, parameter)| {
            (
                format!("parameter {}", at + 1),
                parameter.unit.clone().unwrap_or_default(),
                parameter.description.clone(),
            )
        });
        text.table("parameters", rows, MAX_MEMBERS);
        self.add_history(&mut text, message, Some(&constant.name));
        Some(text)
    }

    /// The fields whose enum contains a constant. The name of a field of another message includes that message.
    fn fields_with(&self, owner: MessageId, constant: usize) -> Vec<String> {
        let is_member = |reference: EnumRef| {
            let mut members = self.schema.enumeration(reference).members.iter();
            reference.message == owner && members.any(|member| member.constant == constant)
        };
        let ids = self.schema.packages.iter().flat_map(|package| &package.messages);
        let fields =
            ids.flat_map(|id| {
                let message = self.schema.message(*id);
                let fields = message.fields.iter().filter(|field| field.enumeration.is_some_and(is_member));
                let is_own = *id == owner;
                fields.map(move |field| {
                    if is_own { field.name.clone() } else { format!("{}.{}", message.name, field.name) }
                })
            });
        fields.collect()
    }

    fn prefix(&self, id: MessageId, prefix: &str) -> Markup {
        let message = self.schema.message(id);
        let mut text = Markup::new(&format!("{}.{prefix}", message.name));
        let constants = message.constants.iter().filter(|constant| has_prefix(&constant.name, prefix));
        let row = |constant: &Constant| {
            (constant.name.clone(), constant.value.to_string(), constant.description.clone())
        };
        text.table("constants", constants.map(row), MAX_MEMBERS);
        text
    }

    fn error_code(&self, package: usize, code: &ErrorCode) -> Markup {
        let name = code.abbreviation.as_deref().unwrap_or_default();
        let mut text = Markup::new(format!("{} {name}", code.code).trim_end());
        text.paragraph(&code.description);
        text.fact("severity", Some(code.severity()));
        text.fact("class", Some(code.class));
        text.fact("since", code.since.as_ref());
        let codes = self.schema.packages[package].error_tables.iter().flat_map(|table| &table.codes);
        let alternatives = codes.filter(|other| code.alternatives.contains(&other.code)).map(|other| {
            let name = other.abbreviation.clone().unwrap_or_default();
            (format!("{} {name}", other.code), other.severity().to_string(), other.description.clone())
        });
        text.table("alternatives", alternatives, MAX_MEMBERS);
        text
    }

    fn json_type(&self, ty: &JsonType) -> Markup {
        let mut text = Markup::new(&ty.name);
        text.paragraph(&ty.docs.text());
        match &ty.definition {
            Definition::Object(_) | Definition::Tuple(_) => {
                let row = |member: &JsonMember| {
                    let optional = if member.is_required { "" } else { ", optional" };
                    let ty = self.schema.expression_text(&member.typed.ty, &str::to_owned);
                    (member.name.clone(), format!("{ty}{optional}"), member.description.clone())
                };
                text.table("fields", ty.definition.members().iter().map(row), MAX_MEMBERS);
            }
            Definition::Named(typed) => {
                let expression = self.schema.expression_text(&typed.ty, &str::to_owned);
                text.fact("type", Some(expression));
                text.fact("unit", typed.limits.unit.as_deref().map(unit_text));
            }
            Definition::Set(_) => {}
        }
        text
    }

    fn add_history(&self, text: &mut Markup, message: &Message, item: Option<&str>) {
        let lines = (self.history)(&ros_name(self.schema, message), item);
        text.list("history", &lines, MAX_CHANGES);
    }

    fn is_px4(&self, message: &Message) -> bool {
        self.schema.package_of(message).form == Form::Msg(Dialect::Px4)
    }
}

/// Adds the constants of an enum.
fn add_members(text: &mut Markup, owner: &Message, found: &Enum) {
    let constants = found.members.iter().map(|member| (&owner.constants[member.constant], member.value));
    let shown = |(constant, value): (&Constant, i128)| {
        let value = if found.is_flags { format!("{value:#x}") } else { value.to_string() };
        (constant.name.clone(), value, constant.description.clone())
    };
    text.table(if found.is_flags { "flags" } else { "values" }, constants.map(shown), MAX_MEMBERS);
}

fn about_json_message(message: &JsonMessage) -> Markup {
    let mut text = Markup::new(&message.name);
    text.paragraph(&message.docs.text());
    let directions: Vec<String> = message.parts.iter().map(|part| part.direction.to_string()).collect();
    text.fact_list("directions", &directions);
    text
}

fn about_event(package: &Package, component: &EventComponent, event: &Event) -> Markup {
    let mut text = Markup::new(&format!("{}::{}", component.namespace, event.name));
    // Placeholders stay as written.
    let shown = |text| Text::new(text).show(Profile::Normal, &|_| None).to_string();
    text.paragraph(&shown(&event.message));
    text.paragraph(&shown(&event.description));
    text.fact("id", Some(event.id));
    text.fact("group", Some(&event.group));
    text.fact("type", Some(event.kind.name()).filter(|name| !name.is_empty()));
    let row = |(number, argument): (usize, &EventArgument)| {
        let ty = package.event_type(component, argument);
        (format!("{number}: {}", argument.name), ty, argument.description.clone())
    };
    text.table("arguments", (1..).zip(&event.arguments).map(row), MAX_MEMBERS);
    text
}

fn about_event_enum(found: &EventEnum) -> Markup {
    let mut text = Markup::new(&format!("{}: {}", found.name, scalar_name(found.scalar)));
    text.paragraph(&found.description);
    let row = |entry: &EventEntry| (entry.name.clone(), entry.value.to_string(), entry.description.clone());
    let title = if found.separator.is_some() { "flags" } else { "values" };
    text.table(title, found.entries.iter().map(row), MAX_MEMBERS);
    text
}

/// The symbol of a unit and its name.
fn unit_text(symbol: &str) -> String {
    unit::lookup(symbol).map_or_else(|| symbol.to_owned(), |unit| format!("{symbol} ({})", unit.name))
}
