//! Decides how a field of the target gets its value.

use std::collections::BTreeSet;

use uavspec_runtime::Scalar;
use uavspec_schema::msg::attribute::FRAME;
use uavspec_schema::msg::constraint::INVALID;
use uavspec_schema::value::Value;
use uavspec_schema::{Element, Field, Shape};

use super::constants;
use super::direction::{self, Direction};
use super::neutral::neutral;
use crate::conversion::expression::{Expression, Name, Names, Node, NodeKind, Side, ValueKind, typed};
use crate::conversion::hints::{Decisions, HintValue, Key, Mistake, constant};
use crate::conversion::plan::{
    Conversion, Copy, Elements, Loss, LossKind, Narrowing, Neutral, Step, Undecided,
};

pub(super) struct FieldBuilder<'f, 'a> {
    pub(super) direction: &'f Direction<'a>,
    pub(super) decisions: &'f Decisions<'f>,
    /// The index of the field.
    pub(super) target: usize,
    pub(super) conversion: &'f mut Conversion,
    /// Constants that name values of fields.
    pub(super) used: &'f mut BTreeSet<&'a str>,
    pub(super) mistakes: &'f mut Vec<Mistake>,
}

/// The outcome of comparing two types.
enum Compared {
    Elements(Elements),
    Narrow,
    /// The types can't be converted.
    Other,
}

impl<'a> FieldBuilder<'_, 'a> {
    pub(super) fn step(&mut self) -> Step {
        let target = self.field();
        let hinted = self.decisions.values.get(target.name.as_str()).copied();
        if let Some((key, HintValue::Expression(node))) = hinted {
            return self.hinted(key, node);
        }
        if let Some(source) = self.source() {
            return self.copied(source);
        }
        if let Some((_, HintValue::Constants(_))) = hinted {
            self.undecide(None, "has no corresponding field on the other side", "compute its value");
        }
        self.added()
    }

    fn field(&self) -> &'a Field {
        &self.direction.to.message.fields[self.target]
    }

    /// The source of the field: the field with the same name, the field that a hint renames to it,
    /// or a renamed field with the same comment.
    fn source(&mut self) -> Option<usize> {
        let target = self.field();
        let fields = &self.direction.from.message.fields;
        if let Some(name) = self.decisions.renamed.get(target.name.as_str()) {
            return fields.iter().position(|field| field.name == *name);
        }
        let source = self.direction.sources.get(&self.target).copied()?;
        let name = &fields[source].name;
        // A hint that computes or renames the source field excludes it as the counterpart of this field.
        let is_claimed = *name != target.name && self.decisions.renamed.values().any(|other| other == name);
        if is_claimed {
            return None;
        }
        // Similar names are not enough: `altitude_filtered` and `altitude_reference` are different quantities.
        let has_same_comment =
            !target.description.is_empty() && fields[source].description == target.description;
        if *name == target.name || has_same_comment {
            return Some(source);
        }
        let (old, new) = self.direction.old_and_new(name, &target.name);
        let side = if self.direction.is_forward { "new" } else { "old" };
        self.undecide(
            Some(source),
            &format!("may be `{name}` under another name"),
            &format!(
                "write rename = {{ {old} = \"{new}\" }} if so; otherwise give its value: {side}.{} = 0",
                target.name
            ),
        );
        None
    }

    fn undecide(&mut self, source: Option<usize>, problem: &str, help: &str) {
        let target = self.field();
        let message = format!("`{}.{}` {problem}", self.direction.to.message.name, target.name);
        let from = &self.direction.from.message;
        let other = source.map_or(from.span.part(0..0), |at| from.fields[at].span);
        let (old, new) = self.direction.old_and_new(other, target.span);
        self.conversion.undecided.push(Undecided {
            span: new,
            old: Some(old),
            message,
            help: help.to_owned(),
        });
    }

    fn neutral(&self) -> Result<Neutral, String> {
        neutral(self.direction.to.schema, self.direction.to.message, self.field())
    }

    /// The step for a field without a source.
    fn added(&mut self) -> Step {
        match self.neutral() {
            Ok(value) => Step::Fill(value),
            Err(reason) => {
                let side = if self.direction.is_forward { "new" } else { "old" };
                let help = format!("give its value: {side}.{} = …", self.field().name);
                self.undecide(None, &format!("has no neutral value: {reason}"), &help);
                Step::Fill(Neutral::Default)
            }
        }
    }

    fn copied(&mut self, at: usize) -> Step {
        let (source, target) = (&self.direction.from.message.fields[at], self.field());
        self.compare_meanings(at);
        let mapped = constants::map(self.direction, (source, target), self.decisions);
        self.used.extend(mapped.used);
        let mut elements = match self.compare_types(source, target) {
            Compared::Elements(elements) => elements,
            Compared::Narrow => {
                let Some(policy) = self.narrowing(source, target) else {
                    let (old, new) = self.types(source, target);
                    let help = format!("choose a policy: narrow = {{ {} = \"nearest\" }}", target.name);
                    self.undecide(
                        Some(at),
                        &format!("has a narrower type on one side: {old} and {new}"),
                        &help,
                    );
                    return Step::Fill(Neutral::Default);
                };
                let text = format!("`{}` is converted to a type with fewer values", source.name);
                self.lose(at, LossKind::Narrowed, text);
                Elements::Narrow(policy)
            }
            Compared::Other => {
                let (old, new) = self.types(source, target);
                let side = if self.direction.is_forward { "new" } else { "old" };
                let help = format!("give its value: {side}.{} = …", target.name);
                self.undecide(Some(at), &format!("changed its type: {old} and {new}"), &help);
                return Step::Fill(Neutral::Default);
            }
        };
        self.conversion.undecided.extend(mapped.undecided);
        if !mapped.merged.is_empty() {
            let list: Vec<String> = mapped.merged.iter().map(|name| format!("`{name}`")).collect();
            let text = format!("`{}`: {} have the same counterpart", source.name, list.join(", "));
            self.lose(at, LossKind::Merged, text);
        }
        if let Some(values) = mapped.elements {
            if matches!(elements, Elements::Narrow(_)) || target.ty.element.is_float() {
                self.undecide(
                    Some(at),
                    "changed its type and the numbers of its constants",
                    "compute its value",
                );
            }
            elements = values;
        }
        let known = self.conversion.undecided.len();
        let mut rest = self.rest(at);
        // Both conversions use the neutral value. If it is absent, only one finding is reported.
        let is_reported = self.conversion.undecided.len() > known;
        if matches!(elements, Elements::Narrow(Narrowing::Neutral)) && !is_reported {
            rest = self.replacement(at).unwrap_or(rest);
        }
        Step::Copy(Copy { source: at, elements, rest, limit: None })
    }

    fn lose(&mut self, source: usize, kind: LossKind, text: String) {
        self.conversion.losses.push(Loss { source: Some(source), kind, text });
    }

    /// The old and the new type.
    fn types(&self, source: &Field, target: &Field) -> (String, String) {
        let (from, to) = (self.direction.from, self.direction.to);
        let texts =
            (from.schema.type_text(from.message, source.ty), to.schema.type_text(to.message, target.ty));
        self.direction.old_and_new(texts.0, texts.1)
    }

    /// The policy for a target type that lacks values of the source type. Only integers can be
    /// replaced by the neutral value.
    fn narrowing(&self, source: &Field, target: &Field) -> Option<Narrowing> {
        let hints = &self.decisions.narrow;
        let policy = *hints.get(target.name.as_str()).or_else(|| hints.get(source.name.as_str()))?;
        let (Element::Scalar(from), Element::Scalar(to)) = (source.ty.element, target.ty.element) else {
            return None;
        };
        (!to.is_float() || policy == Narrowing::Nearest && (from.is_float() || to.is_float()))
            .then_some(policy)
    }

    /// The default, which replaces numbers that the target type can't represent. `None` if there is no default. Reports
    /// a field without a neutral value. Also reports an array with a default, because its elements have no common
    /// default.
    fn replacement(&mut self, at: usize) -> Option<Neutral> {
        let target = self.field();
        let problem = match (&target.default, target.ty.shape) {
            (Some(Value::Int(value)), Shape::Single) => return Some(Neutral::Int(*value)),
            (Some(_), _) => "its elements have no common default".to_owned(),
            (None, _) => self.neutral().err()?,
        };
        let problem = format!("has no neutral value for numbers that don't fit: {problem}");
        let help = format!("choose the other policy: narrow = {{ {} = \"nearest\" }}", target.name);
        self.undecide(Some(at), &problem, &help);
        None
    }

    /// Reports a changed unit, frame or value for missing data.
    fn compare_meanings(&mut self, at: usize) {
        let (source, target) = (&self.direction.from.message.fields[at], self.field());
        let same = &self.decisions.same;
        if same.contains(&source.name.as_str()) || same.contains(&target.name.as_str()) {
            return;
        }
        let special = |field: &Field| {
            let stated = &field.constraint(&INVALID)?.stated;
            stated.value().map(Value::to_string)
        };
        let frame = |field: &Field| field.attribute(&FRAME).map(str::to_owned);
        let is_changed = |(before, after): &(String, String)| before != after;
        let units = source.unit.clone().zip(target.unit.clone()).filter(is_changed);
        let frames = frame(source).zip(frame(target));
        let frames = frames.filter(|(before, after)| !self.is_same_frame(before, after));
        let missing = special(source).zip(special(target)).filter(is_changed);
        for (name, change) in [("unit", units), ("frame", frames), ("value for missing data", missing)] {
            let Some((before, after)) = change else { continue };
            let (old, new) = self.direction.old_and_new(before, after);
            let side = if self.direction.is_forward { "new" } else { "old" };
            let field = &target.name;
            self.undecide(
                Some(at),
                &format!("has a different {name}: {new} instead of {old}"),
                &format!("compute it: {side}.{field} = \"…\", or keep the numbers: same = [\"{field}\"]"),
            );
        }
    }

    /// True if two frames are equal, or if both are references, such as `@frame`, to the same renamed field or
    /// constant. Hints about the field take precedence.
    fn is_same_frame(&self, source: &str, target: &str) -> bool {
        if let (Some(from), Some(to)) = (source.strip_prefix('@'), target.strip_prefix('@')) {
            if let Some(name) = self.decisions.renamed.get(to) {
                return *name == from;
            }
            if self.decisions.values.contains_key(to) {
                return from == to;
            }
        }
        let (old, new) = self.direction.old_and_new(source, target);
        self.direction.pair.is_same_frame(old, new)
    }

    fn compare_types(&self, source: &Field, target: &Field) -> Compared {
        let is_single = |field: &Field| field.ty.shape == Shape::Single;
        if is_single(source) != is_single(target) {
            return Compared::Other;
        }
        match (source.ty.element, target.ty.element) {
            (Element::Text(_), Element::Text(_)) => Compared::Elements(Elements::Text),
            (Element::Scalar(from), Element::Scalar(to)) => scalars(from, to),
            (Element::String { wide, .. }, Element::String { wide: other, bound }) if wide == other => {
                Compared::Elements(Elements::String(bound))
            }
            (Element::Message(from_id), Element::Message(to_id)) => {
                let (old, new) = self.direction.old_and_new(from_id, to_id);
                // The placeholder is replaced by the nested conversion.
                let is_pair = self.direction.pairs.contains_key(&(old, new));
                if is_pair { Compared::Elements(Elements::Same) } else { Compared::Other }
            }
            _ => Compared::Other,
        }
    }

    /// The value for elements that only the target has. Reports elements that only the source has.
    fn rest(&mut self, at: usize) -> Neutral {
        let (source, target) = (&self.direction.from.message.fields[at], self.field());
        let max = |shape: Shape| shape.bound().unwrap_or(u32::MAX);
        let (from, to) = (source.ty.written().shape, target.ty.written().shape);
        let (before, after) = (max(from), max(to));
        if before > after {
            self.lose(at, LossKind::Cut, format!("`{}` is truncated to {after} elements", source.name));
        }
        let string_bound = |field: &Field| match field.ty.element {
            Element::String { bound, .. } => Some(bound.unwrap_or(u32::MAX)),
            Element::Scalar(_) | Element::Text(_) | Element::Message(_) => None,
        };
        if let (Some(before), Some(after)) = (string_bound(source), string_bound(target))
            && before > after
        {
            self.lose(at, LossKind::Cut, format!("`{}` is truncated to {after} characters", source.name));
        }
        let is_array = |shape| matches!(shape, Shape::Array(_));
        if is_array(to) && !is_array(from) && to != from {
            self.lose(at, LossKind::Cut, format!("the number of elements of `{}` is lost", source.name));
        }
        let is_filled = is_array(to) && (after > before || !is_array(from));
        match self.neutral() {
            Ok(value) => value,
            Err(reason) if is_filled => {
                let help = "give the field a value for missing data in the definition";
                self.undecide(Some(at), &format!("has more elements, and {reason}"), help);
                Neutral::Default
            }
            Err(_) => Neutral::Default,
        }
    }

    /// The value that a hint gives.
    fn hinted(&mut self, key: &Key, node: &Node) -> Step {
        // A hint that contains only a field name copies the field, which may be an array or a string.
        if let NodeKind::Name(name) = &node.kind
            && let Some(at) =
                self.direction.from.message.fields.iter().position(|field| field.name == name.text)
        {
            return self.copied(at);
        }
        let target = self.field();
        let Element::Scalar(scalar) = target.ty.element else {
            let is_text = target.is_text();
            let problem = if is_text {
                "a text can't be computed"
            } else {
                "only numbers and booleans can be computed"
            };
            return self.mistaken(key, problem);
        };
        if matches!(target.ty.shape, Shape::Bounded(_) | Shape::Sequence) {
            return self.mistaken(key, "a sequence can't be computed");
        }
        if target.ty.shape != Shape::Single
            && !matches!(node.kind, NodeKind::Bool(_) | NodeKind::Int(_) | NodeKind::Float(_))
        {
            return self.mistaken(key, "the elements of an array can't be computed");
        }
        let expression = match typed(node, self) {
            Ok(expression) => expression,
            Err((span, message)) => {
                self.mistakes.push(Mistake { span, message, help: "correct the expression".to_owned() });
                return Step::Fill(Neutral::Default);
            }
        };
        let expected = kind(scalar);
        let expression = match (expected, expression.kind()) {
            (ValueKind::Float, ValueKind::Int) => expression.into_float(),
            (expected, found) if expected == found => expression,
            (expected, found) => {
                return self.mistaken(key, &format!("expected {}, found {}", expected.name(), found.name()));
            }
        };
        self.use_constants();
        Step::Compute(expression)
    }

    /// Marks the constants of a computed field as decided.
    fn use_constants(&mut self) {
        let target = self.field();
        if let Some(source) = self.direction.sources.get(&self.target) {
            let source = &self.direction.from.message.fields[*source];
            self.used.extend(constants::map(self.direction, (source, target), self.decisions).used);
        }
    }

    fn mistaken(&mut self, key: &Key, problem: &str) -> Step {
        let message = format!("`{}`: {problem}", key.text);
        let help = "correct the value of the field".to_owned();
        self.mistakes.push(Mistake { span: key.span, message, help });
        Step::Fill(Neutral::Default)
    }
}

/// Compares two scalar types.
fn scalars(from: Scalar, to: Scalar) -> Compared {
    if from == to {
        return Compared::Elements(Elements::Same);
    }
    if from == Scalar::Bool || to == Scalar::Bool {
        return Compared::Other;
    }
    match (from.integer_bounds(), to.integer_bounds()) {
        (Some(one), Some(other)) if one == other => Compared::Elements(Elements::Same),
        (Some((low, high)), Some((min, max))) if min <= low && high <= max => {
            Compared::Elements(Elements::Widen)
        }
        (Some((low, high)), None) => {
            let exact: i128 = if to == Scalar::Float32 { 1 << 24 } else { 1 << 53 };
            if -exact <= low && high <= exact {
                Compared::Elements(Elements::Widen)
            } else {
                Compared::Narrow
            }
        }
        (None, Some(_)) => Compared::Other,
        (None, None) if to == Scalar::Float64 => Compared::Elements(Elements::Widen),
        (Some(_), Some(_)) | (None, None) => Compared::Narrow,
    }
}

/// The kind of the values of a type.
fn kind(scalar: Scalar) -> ValueKind {
    match scalar {
        Scalar::Bool => ValueKind::Bool,
        scalar if scalar.is_float() => ValueKind::Float,
        _ => ValueKind::Int,
    }
}

/// The value of a constant.
fn find<'s>(side: direction::Side<'s>, name: &Name) -> Option<&'s Value> {
    constant((side.schema, side.message), &name.text).map(|found| &found.value)
}

impl Names for FieldBuilder<'_, '_> {
    fn value(&self, name: &Name) -> Result<Expression, String> {
        let (from, to) = (self.direction.from, self.direction.to);
        let field = from.message.fields.iter().position(|field| field.name == name.text);
        if let Some(at) = field.filter(|_| name.side.is_none()) {
            let ty = from.message.fields[at].ty;
            return match (ty.element, ty.shape) {
                (Element::Scalar(scalar), Shape::Single) => Ok(Expression::Field(at, kind(scalar))),
                _ => Err(format!("`{}` is not a number or a boolean", name.text)),
            };
        }
        let value = |value: &Value| match value {
            Value::Bool(value) => Ok(Expression::Bool(*value)),
            Value::Int(value) => Ok(Expression::Int(*value)),
            Value::Float(value) => Ok(Expression::Float(*value)),
            Value::Text(_) | Value::List(_) => Err(format!("`{}` is not a number", name.text)),
        };
        let (old, new) = self.direction.old_and_new(from, to);
        let found = match name.side {
            Some(Side::Old) => find(old, name),
            Some(Side::New) => find(new, name),
            None => match (find(from, name), find(to, name)) {
                (Some(one), Some(other)) if one.to_string() != other.to_string() => {
                    return Err(format!("`{0}` has two values; write `old.{0}` or `new.{0}`", name.text));
                }
                (one, other) => one.or(other),
            },
        };
        found.map_or_else(|| Err(format!("no field or constant `{}`", name.text)), value)
    }
}
