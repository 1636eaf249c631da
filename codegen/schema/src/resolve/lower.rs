//! Lowers syntax trees to messages: fields, constants, groups, topics and annotations.

use std::collections::{BTreeSet, HashMap};

use uavspec_runtime::Scalar;

use super::package::PackageSource;
use super::resolver::{PendingEnum, Resolver, id};
use crate::diagnostic::{Diagnostic, Problem};
use crate::documentation::ItemDocs;
use crate::msg::annotation::Note;
use crate::msg::ast::{self, Item, Line, Part};
use crate::msg::constraint::{self, Argument, ConstraintKind};
use crate::msg::statement::{Prefix, Statement};
use crate::name::is_identifier;
use crate::source::Span;
use crate::value::Value;
use crate::{
    Constant, Constraint, Dialect, Element, Field, Form, Kind, Parameter, Stated, Type, documentation,
};

impl<'s> Resolver<'s> {
    /// Sets the fields, constants, groups and topics of each message.
    pub(super) fn lower(&mut self, packages: &[PackageSource<'s>]) {
        self.claimed = vec![BTreeSet::new(); self.schema.messages.len()];
        for index in 0..self.schema.messages.len() {
            let origin = self.origins[index];
            let source = &packages[origin.package];
            let Form::Msg(dialect) = source.input.form else { continue };
            let part = &source.files[origin.file].3.parts[origin.part];
            self.lower_part(index, part, dialect);
        }
    }

    fn lower_part(&mut self, index: usize, part: &Part<'s>, dialect: Dialect) {
        let commentary = documentation::read(part, dialect);
        let duplicates = self.duplicates(part);
        // Read constants first, because annotations may refer to constants on later lines.
        self.constants = part
            .lines
            .iter()
            .filter_map(constant)
            .map(|found| (found.name.text, found.value.clone()))
            .collect();
        let items = part.lines.iter().filter(|line| line.item.is_some());
        for (line, docs) in items.zip(commentary.items) {
            match line.item.as_deref() {
                Some(Item::Field(field)) if !duplicates.contains(&field.name.span) => {
                    self.field(index, line, field, docs);
                }
                Some(Item::Constant(constant)) if !duplicates.contains(&constant.name.span) => {
                    self.constant(index, line, constant, docs);
                }
                _ => {}
            }
        }
        let message = &mut self.schema.messages[index];
        message.docs = commentary.docs;
        message.groups = commentary.groups;
        if dialect == Dialect::Px4 && message.kind == Kind::Message {
            self.topics(index, &commentary.topics);
            self.known_constants(index);
        }
        self.counts(index, part);
    }

    /// The locations of duplicate declarations.
    fn duplicates(&mut self, part: &Part<'s>) -> BTreeSet<Span> {
        let mut fields: HashMap<&str, Span> = HashMap::new();
        let mut constants: HashMap<&str, Span> = HashMap::new();
        let mut duplicates = BTreeSet::new();
        for item in part.lines.iter().filter_map(|line| line.item.as_deref()) {
            let (known, name, whole) = match item {
                Item::Field(field) => (&mut fields, field.name, field.ty.span.to(field.name.span)),
                Item::Constant(constant) => {
                    (&mut constants, constant.name, constant.name.span.to(constant.value_span))
                }
            };
            let Some(first) = known.get(name.text) else {
                known.insert(name.text, whole);
                continue;
            };
            let problem = match item {
                Item::Field(_) => Problem::DuplicateField { name: name.text.to_owned() },
                Item::Constant(_) => Problem::DuplicateConstant { name: name.text.to_owned() },
            };
            self.diagnostics
                .push(Diagnostic::new(problem, name.span).with_related(*first, "first definition"));
            duplicates.insert(name.span);
        }
        duplicates
    }

    fn field(&mut self, index: usize, line: &Line<'s>, field: &ast::Field<'s>, docs: ItemDocs) {
        let Some(ty) = self.field_type(index, &field.ty) else { return };
        let span = field.ty.span.to(field.name.span);
        let mut lowered = Field {
            default: field.default.clone(),
            description: docs.description,
            group: docs.group,
            ..Field::new(field.name.text.to_owned(), ty, span)
        };
        if let Some(note) = note(line) {
            self.annotate(index, &mut lowered, note);
        }
        self.schema.messages[index].fields.push(lowered);
    }

    fn field_type(&mut self, index: usize, ty: &ast::Type<'s>) -> Option<Type> {
        let package = self.schema.package_of(&self.schema.messages[index]);
        // In ROS 2, `char` is a number.
        let is_px4 = package.form == Form::Msg(Dialect::Px4);
        if let (true, ast::Element::Scalar(Scalar::Char), ast::Shape::Array(length)) =
            (is_px4, ty.element, ty.shape)
        {
            return Some(Type { element: Element::Text(length), shape: ast::Shape::Single });
        }
        let element = match ty.element {
            ast::Element::Scalar(scalar) => Element::Scalar(scalar),
            ast::Element::String { wide, bound } => Element::String { wide, bound },
            ast::Element::Message { package, name } => {
                Element::Message(self.reference(index, package, name, ty.span)?)
            }
        };
        Some(Type { element, shape: ty.shape })
    }

    fn annotate(&mut self, index: usize, field: &mut Field, note: &Note<'s>) {
        for annotation in &note.annotations {
            match &annotation.statement {
                Statement::Unit(unit) => field.unit = Some((*unit).to_owned()),
                Statement::Constraint(kind, argument, text) => {
                    let found = self.constraint(kind, argument, text, field.ty, annotation.span);
                    constraint::replace(&mut field.constraints, kind, found);
                }
                Statement::Attribute(attribute, text) => {
                    field.attributes.insert(attribute.name, (*text).to_owned());
                }
                // Counts are resolved later, because the array may be declared on a later line. The other annotations
                // appear only on pages.
                Statement::Count(_)
                | Statement::Length { .. }
                | Statement::Unique
                | Statement::Pattern(_)
                | Statement::Format(_) => {}
                Statement::Enum(prefixes) | Statement::Flags(prefixes) => {
                    field.enum_prefixes = prefixes.iter().map(prefix_text).collect();
                    field.is_enum_exact = annotation.is_exact;
                    let is_flags = matches!(annotation.statement, Statement::Flags(_));
                    if let Some(owner) = self.enum_owner(index, prefixes, annotation.span) {
                        let prefixes: Vec<String> =
                            prefixes.iter().map(|prefix| prefix.prefix.to_owned()).collect();
                        self.claimed[owner.0 as usize].extend(prefixes.iter().cloned());
                        let field = self.schema.messages[index].fields.len();
                        self.pending.push(PendingEnum {
                            message: index,
                            field,
                            owner,
                            prefixes,
                            is_flags,
                            span: annotation.span,
                        });
                    }
                }
            }
        }
    }

    /// A constraint on values of a type, or `None` if it refers to an unknown constant.
    fn constraint(
        &mut self,
        kind: &'static ConstraintKind,
        argument: &Argument<'s>,
        text: &str,
        ty: Type,
        span: Span,
    ) -> Option<Constraint> {
        let stated = match argument {
            Argument::Stated(stated) => stated.clone(),
            Argument::Name(name) => {
                let Some(value) = self.constants.get(name).cloned() else {
                    let problem = Problem::UnknownConstant { name: (*name).to_owned() };
                    self.report(Diagnostic::new(problem, span));
                    return None;
                };
                Stated::Value(value)
            }
        };
        for value in stated.values() {
            self.check_value(value, ty, span);
        }
        Some(Constraint { kind, stated, text: text.to_owned() })
    }

    /// Reports a value that doesn't fit the type.
    fn check_value(&mut self, value: &Value, ty: Type, span: Span) {
        if let Some(scalar) = ty.element.scalar()
            && !can_hold(scalar, value)
        {
            let problem =
                Problem::AnnotationValueType { text: value.to_string(), type_name: scalar.name().to_owned() };
            self.report(Diagnostic::new(problem, span));
        }
    }

    fn constant(&mut self, index: usize, line: &Line<'s>, constant: &ast::Constant<'s>, docs: ItemDocs) {
        let parameters = note(line).map_or(&[][..], |note| note.parameters.as_slice());
        let parameters = parameters.iter().map(|note| self.parameter(index, note)).collect();
        self.schema.messages[index].constants.push(Constant {
            name: constant.name.text.to_owned(),
            ty: constant.ty,
            value: constant.value.clone(),
            description: docs.description,
            parameters,
            group: docs.group,
            span: constant.name.span.to(constant.value_span),
        });
    }

    fn parameter(&mut self, index: usize, note: &Note<'s>) -> Parameter {
        let mut parameter = Parameter {
            unit: None,
            constraints: Vec::new(),
            enum_prefixes: Vec::new(),
            description: note.text.as_ref().to_owned(),
        };
        let number = Type { element: Element::Scalar(Scalar::Float64), shape: ast::Shape::Single };
        for annotation in &note.annotations {
            match &annotation.statement {
                Statement::Unit(unit) => parameter.unit = Some((*unit).to_owned()),
                Statement::Constraint(kind, argument, text) => {
                    let found = self.constraint(kind, argument, text, number, annotation.span);
                    constraint::replace(&mut parameter.constraints, kind, found);
                }
                Statement::Enum(prefixes) | Statement::Flags(prefixes) => {
                    parameter.enum_prefixes = prefixes.iter().map(prefix_text).collect();
                    self.claimed[index].extend(prefixes.iter().map(|prefix| prefix.prefix.to_owned()));
                }
                Statement::Attribute(..)
                | Statement::Count(_)
                | Statement::Length { .. }
                | Statement::Unique
                | Statement::Pattern(_)
                | Statement::Format(_) => {}
            }
        }
        parameter
    }

    fn topics(&mut self, index: usize, listed: &[(&str, Span)]) {
        let mut topics: Vec<String> = Vec::new();
        let mut first: HashMap<&str, Span> = HashMap::new();
        for (topic, span) in listed {
            let name = (*topic).to_owned();
            if !is_identifier(topic) {
                self.report(Diagnostic::new(Problem::InvalidTopic { topic: name }, *span));
            } else if let Some(earlier) = first.get(topic) {
                let diagnostic = Diagnostic::new(Problem::DuplicateTopic { topic: name }, *span);
                self.report(diagnostic.with_related(*earlier, "first listed here"));
            } else {
                first.insert(topic, *span);
                topics.push(name);
            }
        }
        let message = &mut self.schema.messages[index];
        if listed.is_empty() {
            topics.push(default_topic(&message.name));
        }
        message.topics = topics;
    }

    /// Reads `MESSAGE_VERSION` and `ORB_QUEUE_LENGTH`, which have a special meaning in PX4.
    fn known_constants(&mut self, index: usize) {
        for (what, min) in [("MESSAGE_VERSION", 0), ("ORB_QUEUE_LENGTH", 1)] {
            let message = &mut self.schema.messages[index];
            let Some(constant) = message.constants.iter().find(|constant| constant.name == what) else {
                continue;
            };
            let value = constant
                .value
                .as_int()
                .and_then(|value| u32::try_from(value).ok())
                .filter(|value| *value >= min);
            let span = constant.span;
            match what {
                "MESSAGE_VERSION" => message.version = value,
                _ => message.queue_length = value,
            }
            if value.is_none() {
                self.report(Diagnostic::new(Problem::InvalidVersion { what, min }, span));
            }
        }
    }

    /// Finds the fields that count the used elements of an array, by annotation or, without an annotation, by name.
    fn counts(&mut self, index: usize, part: &Part<'s>) {
        let fields = &self.schema.messages[index].fields;
        let places: HashMap<Span, usize> =
            fields.iter().enumerate().map(|(at, field)| (field.span, at)).collect();
        let arrays: HashMap<String, usize> = fields
            .iter()
            .enumerate()
            .filter(|(_, field)| field.ty.shape != ast::Shape::Single || field.is_text())
            .map(|(at, field)| (field.name.clone(), at))
            .collect();
        for line in &part.lines {
            let (Some(Item::Field(field)), Some(note)) = (line.item.as_deref(), note(line)) else { continue };
            let Some(at) = places.get(&field.ty.span.to(field.name.span)) else { continue };
            for annotation in &note.annotations {
                if let Statement::Count(target) = annotation.statement {
                    self.count(index, *at, target, &arrays, annotation.span);
                }
            }
        }
        for field in &mut self.schema.messages[index].fields {
            let counted = field.name.strip_prefix("num_").or_else(|| field.name.strip_suffix("_count"));
            if field.counts.is_none() && is_count(field.ty) {
                field.counts = counted.and_then(|counted| arrays.get(counted)).copied();
            }
        }
    }

    fn count(
        &mut self,
        index: usize,
        field: usize,
        target: &str,
        arrays: &HashMap<String, usize>,
        span: Span,
    ) {
        let message = &mut self.schema.messages[index];
        let ty = message.fields[field].ty;
        let problem = match arrays.get(target) {
            None => Problem::UnknownCountTarget { name: target.to_owned() },
            Some(_) if !is_count(ty) => Problem::CountOnNonInteger {
                type_name: self.schema.type_text(self.schema.message(id(index)), ty),
            },
            Some(array) => {
                message.fields[field].counts = Some(*array);
                return;
            }
        };
        self.report(Diagnostic::new(problem, span));
    }
}

fn constant<'l, 's>(line: &'l Line<'s>) -> Option<&'l ast::Constant<'s>> {
    match line.item.as_deref() {
        Some(Item::Constant(constant)) => Some(constant),
        _ => None,
    }
}

fn note<'l, 's>(line: &'l Line<'s>) -> Option<&'l Note<'s>> {
    line.comment.as_ref()?.note.as_ref()
}

fn prefix_text(prefix: &Prefix<'_>) -> String {
    prefix.message.map_or_else(|| prefix.prefix.to_owned(), |message| format!("{message}.{}", prefix.prefix))
}

fn is_count(ty: Type) -> bool {
    let is_integer = matches!(ty.element, Element::Scalar(scalar) if scalar.integer_bounds().is_some());
    is_integer && ty.shape == ast::Shape::Single
}

fn can_hold(scalar: Scalar, value: &Value) -> bool {
    match (scalar.integer_bounds(), value) {
        (Some((min, max)), Value::Int(value)) => (min..=max).contains(value),
        (Some(_), Value::Float(value)) => value.fract() == 0.0,
        (None, _) => scalar != Scalar::Bool || matches!(value, Value::Int(0 | 1) | Value::Bool(_)),
        (Some(_), _) => false,
    }
}

/// The default topic of a message. PX4 inserts `_` before each capital letter except the first.
pub fn default_topic(name: &str) -> String {
    let mut topic = String::with_capacity(name.len() + 4);
    for (at, character) in name.char_indices() {
        if at > 0 && character.is_ascii_uppercase() {
            topic.push('_');
        }
        topic.push(character.to_ascii_lowercase());
    }
    topic
}
