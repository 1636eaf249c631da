//! Copies a schema together with all schemas that it refers to.
//!
//! Only these schemas are compiled. Other schemas in the same files may therefore be invalid, or use another draft. The
//! meaning of references doesn't depend on the compiler.

use std::collections::{HashMap, HashSet};

use jsonschema::Draft;
use serde_json::{Map, Value, json};
use uavspec_schema::graph;

use super::Problem;
use super::files::own_draft;
use super::places::{Place, Places};

/// The maximum number of values in all copies. Files that share large schemas contain more values after copying.
const MAX_COPIED: usize = 150_000;

/// The number of values that a pattern counts as. A pattern takes more memory than other values.
const PATTERN: usize = 10;

/// The maximum number of schemas in a schema. Each reference counts as a copy of its target, since the compiler and the
/// checks treat it as a copy. If schemas refer to each other twice per level, the time doubles with each level.
pub(super) const MAX_SCHEMAS: u64 = 100_000;

/// The maximum nesting depth of values. Each reference counts as a copy of its target. Checks recurse once per level.
const MAX_DEPTH: u64 = 500;

/// The keywords that don't affect other values: they only describe, name or contain schemas.
const INERT: [&str; 8] =
    ["$schema", "$id", "id", "$anchor", "$dynamicAnchor", "$recursiveAnchor", "$defs", "definitions"];

/// A copy of a schema, whose references lead to other parts.
pub(super) struct Part<'f> {
    pub place: Place<'f>,
    /// The short form of the location in the file.
    pub location: String,
    pub value: Value,
    /// The size without the targets of references.
    size: Size,
    /// The targets of references, each with the depth of the reference.
    references: Vec<(u64, usize)>,
}

/// The size of a schema.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Size {
    /// The number of schemas.
    pub count: u64,
    /// The number of nested values.
    depth: u64,
}

impl Size {
    /// Includes the size of a schema within this one.
    fn include(&mut self, inner: Self) {
        self.count = self.count.saturating_add(inner.count);
        self.depth = self.depth.max(inner.depth);
    }

    /// True if a schema of this size can be compiled.
    pub(super) fn is_small(self) -> bool {
        self.count <= MAX_SCHEMAS && self.depth <= MAX_DEPTH
    }
}

/// A schema, with copies of the schemas that it refers to.
pub(super) struct Bundle<'f, 'p> {
    places: &'p Places<'f>,
    /// The number of values in this and earlier copies.
    copied: &'p mut usize,
    /// The copied schemas. The first one is the schema itself.
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
    /// Copies the schema of a file. `copied` is the number of values in earlier copies.
    pub(super) fn new(places: &'p Places<'f>, file: usize, copied: &'p mut usize) -> Result<Self, Problem> {
        let mut bundle = Self { places, copied, parts: Vec::new(), patterns: 0, by_value: HashMap::new() };
        bundle.part(places.root(file), String::new());
        let mut next = 0;
        while next < bundle.parts.len() {
            let value = bundle.schema(next, bundle.parts[next].place.value, 0)?;
            bundle.parts[next].value = value;
            next += 1;
        }
        bundle.charge(0, bundle.patterns * PATTERN)?;
        Ok(bundle)
    }

    /// The size of the schema. Each reference counts as a copy of its target. References within a cycle count once.
    pub(super) fn size(&self) -> Size {
        let targets = |part: &Part<'_>| part.references.iter().map(|(_, target)| *target).collect();
        let steps: Vec<Vec<usize>> = self.parts.iter().map(targets).collect();
        // The sizes of the targets are known, unless a target leads back to the part. Such a target counts as 0.
        let mut sizes = vec![Size::default(); self.parts.len()];
        for part in graph::successors_first(&steps) {
            let mut total = self.parts[part].size;
            for (depth, target) in &self.parts[part].references {
                let target = sizes[*target];
                total.include(Size { depth: depth + 1 + target.depth, ..target });
            }
            sizes[part] = total;
        }
        sizes[0]
    }

    /// The index of the part that is a copy of this schema. The copy is created later.
    fn part(&mut self, place: Place<'f>, location: String) -> usize {
        *self.by_value.entry(std::ptr::from_ref(place.value)).or_insert_with(|| {
            let (size, references) = (Size::default(), Vec::new());
            self.parts.push(Part { place, location, value: Value::Null, size, references });
            self.parts.len() - 1
        })
    }

    /// A copy of a schema, without the keywords that don't affect values.
    fn schema(&mut self, part: usize, value: &'f Value, depth: u64) -> Result<Value, Problem> {
        let Value::Object(members) = value else { return self.copy(part, value, &HashSet::new(), depth) };
        let place = self.places.at(value);
        if place.draft == Draft::Unknown {
            let problem = "unknown `$schema`: use a draft of JSON Schema, e.g. \
                           `https://json-schema.org/draft/2020-12/schema`";
            return Err(self.places.problem(place, "", problem));
        }
        self.charge(part, 1)?;
        if depth > 0 && own_draft(value).is_some_and(|draft| draft != self.parts[part].place.draft) {
            return Ok(json!({ "$ref": self.address(part, place, String::new(), depth) }));
        }
        self.parts[part].size.include(Size { count: 1, depth });
        let is_classic = matches!(place.draft, Draft::Draft4 | Draft::Draft6 | Draft::Draft7);
        // Old drafts ignore keywords next to a reference.
        let is_alone = |name: &str| !is_classic || name == "$ref" || !members.contains_key("$ref");
        let is_used = |name: &str| !INERT.contains(&name) && place.draft.is_known_keyword(name);
        // The compiler also reads keywords of draft 7 that later drafts no longer list.
        let drafts = [place.draft, Draft::Draft7];
        let inner = drafts.iter().flat_map(|draft| draft.subresources_of(value));
        let inner: HashSet<*const Value> = inner.map(std::ptr::from_ref).collect();
        let mut copy = Map::new();
        for (name, member) in members.iter().filter(|(name, _)| is_alone(name) && is_used(name)) {
            if let ("$ref" | "$dynamicRef" | "$recursiveRef", Value::String(reference)) =
                (name.as_str(), member)
            {
                if copy.contains_key("$ref") {
                    let problem = "several references in one schema: move them to `allOf`";
                    return Err(self.places.problem(place, "", problem));
                }
                let target = self.places.find(place, reference, name != "$ref");
                let target = target.map_err(|problem| self.places.problem(place, "", problem))?;
                self.charge(part, 1)?;
                let location = self.places.label(target, reference);
                copy.insert("$ref".to_owned(), self.address(part, target, location, depth).into());
                continue;
            }
            self.patterns += match (name.as_str(), member) {
                ("patternProperties", Value::Object(patterns)) => patterns.len(),
                ("pattern", _) => 1,
                _ => 0,
            };
            copy.insert(name.clone(), self.copy(part, member, &inner, depth + 1)?);
        }
        Ok(Value::Object(copy))
    }

    /// Adds a reference from a part to `target`. Returns the address of the part that is a copy of `target`.
    fn address(&mut self, part: usize, target: Place<'f>, location: String, depth: u64) -> String {
        let target = self.part(target, location);
        self.parts[part].references.push((depth, target));
        address(target)
    }

    /// Copies a value. The values in it that `schemas` contains are copied as schemas, and all others as data.
    fn copy(
        &mut self,
        part: usize,
        value: &'f Value,
        schemas: &HashSet<*const Value>,
        depth: u64,
    ) -> Result<Value, Problem> {
        if schemas.contains(&std::ptr::from_ref(value)) {
            return self.schema(part, value, depth);
        }
        self.charge(part, 1)?;
        let mut copied = |value: &'f Value| self.copy(part, value, schemas, depth + 1);
        Ok(match value {
            Value::Object(members) => {
                let members = members.iter().map(|(name, value)| Ok((name.clone(), copied(value)?)));
                Value::Object(members.collect::<Result<_, Problem>>()?)
            }
            Value::Array(values) => Value::Array(values.iter().map(copied).collect::<Result<_, _>>()?),
            _ => value.clone(),
        })
    }

    /// Adds to the number of copied values. Fails if there are too many.
    fn charge(&mut self, part: usize, values: usize) -> Result<(), Problem> {
        let copied = *self.copied + values;
        if copied > MAX_COPIED {
            let problem = format!(
                "too many references: the schemas and everything that they refer to contain more than {MAX_COPIED} \
                 values"
            );
            return Err(Problem::new(&self.places.file(self.parts[part].place).path, problem));
        }
        *self.copied = copied;
        Ok(())
    }
}
