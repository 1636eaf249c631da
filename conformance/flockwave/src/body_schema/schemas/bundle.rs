//! Copies a schema together with all schemas that it refers to.
//!
//! Only these are compiled. So other schemas of the same files may be invalid, or use another draft, and the meaning of
//! references doesn't depend on the compiler.

use std::collections::HashMap;

use jsonschema::Draft;
use serde_json::{Map, Value, json};

use super::Problem;
use super::expansion::{Part, Size};
use super::files::own_draft;
use super::places::{Place, Places};

/// The maximum number of values in all copies. Files that share large schemas contain more values after copying.
const MAX_COPIED: usize = 150_000;

/// The number of values that a pattern counts like. A pattern takes more memory than other values.
const PATTERN: usize = 10;

/// The role of a keyword.
enum Keyword {
    /// The value is a reference.
    Reference,
    /// The value is a schema, or a list of schemas.
    Schemas,
    /// The value is an object whose values are schemas.
    Map,
    /// The value is data.
    Data,
    /// The keyword doesn't affect other values: it only describes, names or contains schemas.
    None,
}

impl Keyword {
    fn of(name: &str, draft: Draft) -> Self {
        match name {
            "$ref" | "$dynamicRef" | "$recursiveRef" if draft.is_known_keyword(name) => Self::Reference,
            "$schema" | "$id" | "id" | "$anchor" | "$dynamicAnchor" | "$recursiveAnchor" | "$defs"
            | "definitions" => Self::None,
            _ if !draft.is_known_keyword(name) => Self::None,
            "additionalItems"
            | "additionalProperties"
            | "allOf"
            | "anyOf"
            | "contains"
            | "contentSchema"
            | "else"
            | "if"
            | "items"
            | "not"
            | "oneOf"
            | "prefixItems"
            | "propertyNames"
            | "then"
            | "unevaluatedItems"
            | "unevaluatedProperties" => Self::Schemas,
            "dependencies" | "dependentSchemas" | "patternProperties" | "properties" => Self::Map,
            _ => Self::Data,
        }
    }
}

/// The number of values that may still be copied.
pub(super) struct Budget(usize);

impl Default for Budget {
    fn default() -> Self {
        Self(MAX_COPIED)
    }
}

#[cfg(test)]
impl Budget {
    /// The number of values that were copied.
    pub(super) fn spent(&self) -> usize {
        MAX_COPIED - self.0
    }
}

/// A schema, with copies of the schemas that it refers to.
pub(super) struct Bundle<'f, 'p> {
    places: &'p Places<'f>,
    budget: &'p mut Budget,
    /// The schemas. The first one is the schema itself.
    pub parts: Vec<Part<'f>>,
    /// The number of patterns.
    pub patterns: usize,
    by_value: HashMap<*const Value, usize>,
}

/// The address of a part.
pub(super) fn address(part: usize) -> String {
    format!("uavspec://part/{part}")
}

impl<'f, 'p> Bundle<'f, 'p> {
    /// Copies the schema of a file.
    pub(super) fn new(places: &'p Places<'f>, file: usize, budget: &'p mut Budget) -> Result<Self, Problem> {
        let mut bundle = Self { places, budget, parts: Vec::new(), patterns: 0, by_value: HashMap::new() };
        bundle.part(places.root(file), String::new());
        let mut next = 0;
        while next < bundle.parts.len() {
            let place = bundle.parts[next].place;
            let value = bundle.schema(next, place, 0)?;
            bundle.parts[next].value = value;
            next += 1;
        }
        bundle.charge(bundle.places.root(file), bundle.patterns * PATTERN)?;
        Ok(bundle)
    }

    /// The index of the part that is a copy of this schema. The copy is made later.
    fn part(&mut self, place: Place<'f>, location: String) -> usize {
        *self.by_value.entry(std::ptr::from_ref(place.value)).or_insert_with(|| {
            self.parts.push(Part::new(place, location));
            self.parts.len() - 1
        })
    }

    /// A copy of the schema at a place, without the keywords that don't affect values.
    fn schema(&mut self, part: usize, place: Place<'f>, depth: u64) -> Result<Value, Problem> {
        let Value::Object(members) = place.value else { return self.data(place, place.value) };
        if place.draft == Draft::Unknown {
            let problem = "unknown `$schema`: use a draft of JSON Schema, e.g. \
                           `https://json-schema.org/draft/2020-12/schema`";
            return Err(self.places.problem(place, "", problem));
        }
        if depth > 0 && own_draft(place.value).is_some_and(|draft| draft != self.parts[part].place.draft) {
            self.charge(place, 1)?;
            return Ok(json!({ "$ref": self.address(part, place, String::new(), depth) }));
        }
        self.charge(place, 1)?;
        self.parts[part].size.include(Size { count: 1, depth });
        let is_classic = matches!(place.draft, Draft::Draft4 | Draft::Draft6 | Draft::Draft7);
        // Old drafts ignore what stands next to a reference.
        let is_alone = |name: &str| !is_classic || name == "$ref" || !members.contains_key("$ref");
        let mut copy = Map::new();
        for (name, member) in members.iter().filter(|(name, _)| is_alone(name)) {
            let member = match (Keyword::of(name, place.draft), member) {
                (Keyword::None, _) => continue,
                (Keyword::Reference, Value::String(reference)) => {
                    if copy.contains_key("$ref") {
                        let problem = "several references in one schema: move them to `allOf`";
                        return Err(self.places.problem(place, "", problem));
                    }
                    copy.insert("$ref".to_owned(), self.target(part, place, name, reference, depth)?);
                    continue;
                }
                (Keyword::Schemas, _) => self.schemas(part, place, member, depth + 1)?,
                (Keyword::Map, Value::Object(inner)) => {
                    self.patterns += if name == "patternProperties" { inner.len() } else { 0 };
                    self.map(part, place, inner, depth + 1)?
                }
                _ => {
                    self.patterns += usize::from(name == "pattern");
                    self.data(place, member)?
                }
            };
            copy.insert(name.clone(), member);
        }
        Ok(Value::Object(copy))
    }

    /// The address of the target of a reference in a part.
    fn target(
        &mut self,
        part: usize,
        place: Place<'f>,
        keyword: &str,
        reference: &str,
        depth: u64,
    ) -> Result<Value, Problem> {
        let is_dynamic = keyword != "$ref";
        let target = self.places.find(place, reference, is_dynamic);
        let target = target.map_err(|problem| self.places.problem(place, "", problem))?;
        self.charge(place, 1)?;
        Ok(self.address(part, target, self.places.label(target, reference), depth).into())
    }

    /// The address of the part with this target, which a part refers to.
    fn address(&mut self, part: usize, target: Place<'f>, location: String, depth: u64) -> String {
        let target = self.part(target, location);
        self.parts[part].references.push((depth, target));
        address(target)
    }

    /// A copy of a schema or a list of schemas. Other values are copied like data.
    fn schemas(
        &mut self,
        part: usize,
        place: Place<'f>,
        value: &'f Value,
        depth: u64,
    ) -> Result<Value, Problem> {
        let Value::Array(values) = value else {
            return self.schema(part, self.places.enter(place, value), depth);
        };
        self.charge(place, 1)?;
        let copies = values.iter().map(|value| self.schema(part, self.places.enter(place, value), depth + 1));
        Ok(Value::Array(copies.collect::<Result<_, _>>()?))
    }

    /// A copy of an object of schemas. Lists of names, as in `dependencies`, are copied like data.
    fn map(
        &mut self,
        part: usize,
        place: Place<'f>,
        members: &'f Map<String, Value>,
        depth: u64,
    ) -> Result<Value, Problem> {
        self.charge(place, 1)?;
        let mut copy = Map::new();
        for (name, value) in members {
            let value = self.schema(part, self.places.enter(place, value), depth + 1)?;
            copy.insert(name.clone(), value);
        }
        Ok(Value::Object(copy))
    }

    fn data(&mut self, place: Place<'f>, value: &Value) -> Result<Value, Problem> {
        self.charge(place, count(value))?;
        Ok(value.clone())
    }

    fn charge(&mut self, place: Place<'f>, values: usize) -> Result<(), Problem> {
        self.budget.0 = self.budget.0.checked_sub(values).ok_or_else(|| {
            let problem = format!(
                "too many references: with the schemas that they refer to, the schemas contain more than {MAX_COPIED} \
                 values"
            );
            Problem::new(&self.places.file(place).path, problem)
        })?;
        Ok(())
    }
}

/// The number of values in a value, including itself.
fn count(value: &Value) -> usize {
    1 + match value {
        Value::Object(members) => members.values().map(count).sum(),
        Value::Array(values) => values.iter().map(count).sum(),
        _ => 0,
    }
}
