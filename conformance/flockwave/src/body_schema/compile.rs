//! Compiles type and message definitions to schemas.

use std::collections::HashMap;

use regex_lite::Regex;
use uavspec_schema::json_type::{self as written, Definition, Expression, Limits, Member, SetValues};
use uavspec_schema::value::Value;
use uavspec_schema::{JsonTypeId, Schema};

use super::bodies::{Body, DefinedSchemas};
use super::defined::{Field, Length, List, Object, Pattern, Test, Text, Tuple, ValueSchema};

/// The only supported string format.
const BASE64: &str = "base64";

impl DefinedSchemas {
    /// Compiles all messages of the definitions. If two packages define the same message, the first package's
    /// definition applies.
    pub fn new(schema: &Schema) -> Self {
        let mut compiler =
            Compiler { schema, defined_schemas: DefinedSchemas::default(), known: HashMap::new() };
        for message in &schema.json_messages {
            let mut bodies = [None, None, None];
            for part in &message.parts {
                let object = compiler.body(&part.body);
                let name = format!("{}/{}", schema.packages[message.package].name, part.name);
                compiler.defined_schemas.named.insert(name, ValueSchema::Object(object));
                bodies[part.direction as usize] = Some(Body { object, span: part.span });
            }
            compiler.defined_schemas.messages.entry(message.name.clone()).or_insert(bodies);
        }
        for package in &schema.packages {
            for id in &package.json_types {
                let body = compiler.named(*id, &[]);
                let name = format!("{}/{}", package.name, schema.json_type(*id).name);
                compiler.defined_schemas.named.insert(name, body);
            }
        }
        compiler.defined_schemas
    }
}

struct Compiler<'s> {
    schema: &'s Schema,
    defined_schemas: DefinedSchemas,
    /// The named objects and tuples, which may be recursive.
    known: HashMap<JsonTypeId, Reference>,
}

/// The index of an object or a tuple.
#[derive(Clone, Copy)]
pub(super) enum Reference {
    Object(usize),
    Tuple(usize),
}

impl From<Reference> for ValueSchema {
    fn from(reference: Reference) -> Self {
        match reference {
            Reference::Object(index) => Self::Object(index),
            Reference::Tuple(index) => Self::Tuple(index),
        }
    }
}

impl Compiler<'_> {
    fn body(&mut self, body: &written::Object) -> usize {
        let index = self.defined_schemas.objects.len();
        self.defined_schemas.objects.push(Object::default());
        self.fill(index, "", body);
        index
    }

    /// Fills the slot that is reserved for an object.
    fn fill(&mut self, index: usize, name: &str, object: &written::Object) {
        let fields = self.fields(&object.fields);
        self.defined_schemas.objects[index] = Object::new(name, fields, object.is_closed);
    }

    fn fields(&mut self, members: &[Member]) -> Vec<Field> {
        let field = |member: &Member| Field {
            name: member.name.as_str().into(),
            is_required: member.is_required,
            schema: self.expression(&member.typed.ty, &[&member.typed.limits]),
            span: member.span,
        };
        members.iter().map(field).collect()
    }

    /// The schema of an expression, including all limits that apply to it.
    fn expression(&mut self, expression: &Expression, limits: &[&Limits]) -> ValueSchema {
        match expression {
            Expression::Any => ValueSchema::Any,
            Expression::Null => ValueSchema::Null,
            Expression::Boolean => ValueSchema::Bool,
            Expression::Integer => {
                let (low, high) = bounds(limits);
                // Bounds that aren't integers are rounded inwards.
                #[allow(clippy::cast_possible_truncation)] // the cast saturates
                ValueSchema::Integer(
                    low.map_or(i128::MIN, |low| low.integer.unwrap_or(low.float.ceil() as i128)),
                    high.map_or(i128::MAX, |high| high.integer.unwrap_or(high.float.floor() as i128)),
                )
            }
            Expression::Number => {
                let (low, high) = bounds(limits);
                ValueSchema::Number(low.map(|low| low.float), high.map(|high| high.float))
            }
            Expression::String => ValueSchema::Text(text(limits)),
            Expression::ErrorCode => ValueSchema::Integer(0, u32::MAX.into()),
            Expression::ErrorList => {
                self.expression(&Expression::List(Box::new(Expression::ErrorCode)), limits)
            }
            Expression::Named(id) => self.named(*id, limits),
            Expression::List(element) => ValueSchema::List(List {
                element: Box::new(self.within(element, limits)),
                length: length(limits),
                is_unique: limits.iter().any(|limits| limits.is_unique),
            }),
            Expression::Map(value) => ValueSchema::Map(Box::new(self.within(value, limits))),
            Expression::Either(all) => {
                ValueSchema::Either(all.iter().map(|one| self.expression(one, limits)).collect())
            }
            Expression::OneOf(constants) => ValueSchema::Constants(constants.clone()),
        }
    }

    /// The schema of list elements or map values.
    fn within(&mut self, inner: &Expression, limits: &[&Limits]) -> ValueSchema {
        let limits: Vec<Limits> = limits.iter().map(|limits| limits.of_elements()).collect();
        self.expression(inner, &limits.iter().collect::<Vec<_>>())
    }

    fn named(&mut self, id: JsonTypeId, limits: &[&Limits]) -> ValueSchema {
        if let Some(reference) = self.known.get(&id) {
            return (*reference).into();
        }
        let schema = self.schema;
        let found = schema.json_type(id);
        match &found.definition {
            Definition::Object(object) => {
                let index = self.defined_schemas.objects.len();
                self.defined_schemas.objects.push(Object::default());
                self.known.insert(id, Reference::Object(index));
                self.fill(index, &found.name, object);
                ValueSchema::Object(index)
            }
            Definition::Tuple(elements) => {
                let index = self.defined_schemas.tuples.len();
                self.defined_schemas.tuples.push(Tuple::default());
                self.known.insert(id, Reference::Tuple(index));
                let elements = self.fields(elements);
                let required = elements.iter().filter(|element| element.is_required).count();
                self.defined_schemas.tuples[index] = Tuple { elements, required };
                ValueSchema::Tuple(index)
            }
            Definition::Set(set) => match &set.values {
                SetValues::Integers(_) if set.is_open => ValueSchema::Integer(i128::MIN, i128::MAX),
                SetValues::Strings(_) if set.is_open => ValueSchema::Text(Text::ANY),
                SetValues::Integers(values) => {
                    ValueSchema::Integers(values.iter().map(|value| value.value).collect())
                }
                SetValues::Strings(values) => {
                    ValueSchema::Constants(values.iter().map(|value| value.value.clone()).collect())
                }
            },
            // Definitions of this kind aren't recursive, so this recursion ends.
            Definition::Named(typed) => {
                let all: Vec<&Limits> = limits.iter().copied().chain([&typed.limits]).collect();
                self.expression(&typed.ty, &all)
            }
        }
    }
}

/// A lower or upper bound.
#[derive(Clone, Copy)]
struct Bound {
    float: f64,
    integer: Option<i128>,
}

/// The tightest bounds among these limits.
fn bounds(limits: &[&Limits]) -> (Option<Bound>, Option<Bound>) {
    let bound = |value: &Value| {
        let integer = if let Value::Int(integer) = value { Some(*integer) } else { None };
        Some(Bound { float: value.as_f64()?, integer })
    };
    let ranges = || limits.iter().filter_map(|limits| limits.range.as_ref());
    let lows = ranges().filter_map(|range| bound(range.low.as_ref()?));
    let highs = ranges().filter_map(|range| bound(range.high.as_ref()?));
    let by_value = |one: &Bound, other: &Bound| one.float.total_cmp(&other.float);
    (lows.max_by(by_value), highs.min_by(by_value))
}

/// The tightest length range among these limits.
fn length(limits: &[&Limits]) -> Length {
    let size = |length: u32| usize::try_from(length).unwrap_or(usize::MAX);
    let min = limits.iter().filter_map(|limits| limits.min).max().map_or(0, size);
    let max = limits.iter().filter_map(|limits| limits.max).min().map_or(usize::MAX, size);
    Length { min, max }
}

fn text(limits: &[&Limits]) -> Text {
    let pattern = |written: &String| {
        // Ignore a pattern that exceeds the size limit of the regex engine.
        let test = without(written).or_else(|| Regex::new(written).ok().map(Test::Regex))?;
        Some(Pattern { written: written.clone(), test })
    };
    Text {
        length: length(limits),
        patterns: limits.iter().filter_map(|limits| pattern(limits.pattern.as_ref()?)).collect(),
        is_base64: limits.iter().any(|limits| limits.format.as_deref() == Some(BASE64)),
    }
}

/// The excluded characters of a pattern such as `^[^/]+$`.
fn without(pattern: &str) -> Option<Test> {
    let excluded = pattern.strip_prefix("^[^")?.strip_suffix("]+$")?;
    let is_plain = |c: char| !matches!(c, '\\' | '[' | ']' | '-' | '&' | '~' | '^');
    (!excluded.is_empty() && excluded.chars().all(is_plain))
        .then(|| Test::Without(excluded.chars().collect()))
}
