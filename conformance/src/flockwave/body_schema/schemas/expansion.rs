//! Bounds the size of schemas with references.
//!
//! Each reference is compiled like a copy of its target. Schemas that refer to each other twice per level therefore
//! need time and memory that double with each level.

use std::collections::HashMap;

use serde_json::Value;

/// The maximum number of schemas in a schema, in which each reference counts like a copy of its target.
pub(super) const MAX_SCHEMAS: u64 = 100_000;

/// The maximum nesting depth of values, in which each reference counts like a copy of its target. Compilers of schemas
/// recurse once per level.
const MAX_DEPTH: u64 = 500;

/// The keywords whose values are references.
const REFERENCES: [&str; 3] = ["$ref", "$dynamicRef", "$recursiveRef"];

/// A value that is being counted.
struct Open<'s> {
    /// The address of the value in memory, which identifies it.
    key: *const Value,
    /// The values that are still to be counted, each with the document that contains it.
    rest: Vec<(&'s str, &'s Value)>,
    size: Size,
}

/// The size of a value.
#[derive(Clone, Copy, Default)]
struct Size {
    /// The number of schemas.
    count: u64,
    /// The number of nested values.
    depth: u64,
}

impl Size {
    /// Includes the size of an inner value.
    fn include(&mut self, inner: Self) {
        self.count = self.count.saturating_add(inner.count);
        self.depth = self.depth.max(inner.depth + 1);
    }

    /// The count. If the value is nested too deeply, the count is the highest number.
    fn total(self) -> u64 {
        if self.depth > MAX_DEPTH { u64::MAX } else { self.count }
    }
}

/// The number of schemas in `root`, in which each reference counts like a copy of its target. References within a cycle
/// count once. If values are nested too deeply, the result is the highest number. `resolve` returns the target of a
/// reference in a document, and the document of the target. Fails with a reference that has no known target, because
/// the target may be of any size.
///
/// Data such as defaults counts like schemas, because properties may have the names of the keywords for data.
pub(super) fn count<'s>(
    document: &'s str,
    root: &'s Value,
    mut resolve: impl FnMut(&'s str, &'s str) -> Option<(&'s str, &'s Value)>,
) -> Result<u64, &'s str> {
    let mut known: HashMap<*const Value, Size> = HashMap::new();
    // The search has its own stack, because references can form long chains.
    let mut open = vec![start(document, root, &mut known, &mut resolve)?];
    loop {
        let Some(last) = open.last_mut() else { return Ok(0) };
        if let Some((document, next)) = last.rest.pop() {
            // A value that is still open counts 0: the reference leads back to it.
            if let Some(size) = known.get(&std::ptr::from_ref(next)) {
                last.size.include(*size);
            } else {
                let next = start(document, next, &mut known, &mut resolve)?;
                open.push(next);
            }
            continue;
        }
        let (key, size) = (last.key, last.size);
        known.insert(key, size);
        open.pop();
        match open.last_mut() {
            None => return Ok(size.total()),
            Some(parent) => parent.size.include(size),
        }
    }
}

fn start<'s>(
    document: &'s str,
    value: &'s Value,
    known: &mut HashMap<*const Value, Size>,
    resolve: &mut impl FnMut(&'s str, &'s str) -> Option<(&'s str, &'s Value)>,
) -> Result<Open<'s>, &'s str> {
    let key = std::ptr::from_ref(value);
    known.insert(key, Size::default());
    let mut rest = Vec::new();
    let size = Size { count: u64::from(value.is_object()), depth: 0 };
    match value {
        Value::Object(members) => {
            for (name, member) in members {
                match member.as_str().filter(|_| REFERENCES.contains(&name.as_str())) {
                    Some(reference) => rest.push(resolve(document, reference).ok_or(reference)?),
                    None => rest.push((document, member)),
                }
            }
        }
        Value::Array(values) => rest.extend(values.iter().map(|value| (document, value))),
        _ => {}
    }
    Ok(Open { key, rest, size })
}

/// The first `$id` below the root of a document that contains references. Other readers resolve references within such a
/// schema relative to its `$id`.
pub(super) fn ambiguous_id(root: &Value) -> Option<&str> {
    let id = values(root).skip(1).find_map(|value| value.get("$id")?.as_str());
    let has_reference = |value: &Value| REFERENCES.iter().any(|name| value.get(name).is_some());
    id.filter(|_| values(root).any(has_reference))
}

/// A value and all values in it. The value itself comes first.
fn values(root: &Value) -> impl Iterator<Item = &Value> {
    let mut open = vec![root];
    std::iter::from_fn(move || {
        let value = open.pop()?;
        match value {
            Value::Object(members) => open.extend(members.values()),
            Value::Array(values) => open.extend(values),
            _ => {}
        }
        Some(value)
    })
}

/// The anchors of the documents that were searched. A name that occurs twice in a document has no target.
#[derive(Default)]
pub(super) struct Anchors<'s>(HashMap<*const Value, HashMap<&'s str, Option<&'s Value>>>);

impl<'s> Anchors<'s> {
    /// The value with this fragment of a reference, which is a pointer or an anchor. An empty fragment means the whole
    /// document.
    pub(super) fn fragment(&mut self, root: &'s Value, fragment: &str) -> Option<&'s Value> {
        if fragment.is_empty() {
            return Some(root);
        }
        if fragment.starts_with('/') {
            return root.pointer(&decoded(fragment)?);
        }
        let anchors = self.0.entry(std::ptr::from_ref(root)).or_insert_with(|| anchors(root));
        anchors.get(fragment).copied().flatten()
    }
}

/// The anchors of a document.
fn anchors(root: &Value) -> HashMap<&str, Option<&Value>> {
    let mut anchors: HashMap<&str, Option<&Value>> = HashMap::new();
    for value in values(root) {
        for name in ["$anchor", "$dynamicAnchor"] {
            if let Some(anchor) = value.get(name).and_then(Value::as_str) {
                anchors.entry(anchor).and_modify(|known| *known = None).or_insert(Some(value));
            }
        }
    }
    anchors
}

/// Decodes the percent-encoded bytes of a fragment. `None` if the result isn't text.
fn decoded(fragment: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(fragment.len());
    let mut parts = fragment.split('%');
    bytes.extend(parts.next().unwrap_or_default().bytes());
    for part in parts {
        bytes.push(u8::from_str_radix(part.get(..2)?, 16).ok()?);
        bytes.extend(part.bytes().skip(2));
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use serde_json::{Map, json};

    use super::*;

    fn count_of(root: &Value) -> u64 {
        let mut anchors = Anchors::default();
        let resolve =
            |_, reference: &'_ str| Some(("", anchors.fragment(root, reference.strip_prefix('#')?)?));
        count("", root, resolve).expect("known references")
    }

    /// A schema in which each level refers twice to the next one.
    fn doubling(levels: usize) -> Value {
        let level = |at: usize| {
            let reference = json!({ "$ref": format!("#/$defs/level{}", at + 1) });
            let schema = if at == levels {
                json!({ "type": "string" })
            } else {
                json!({ "allOf": [reference, reference] })
            };
            (format!("level{at}"), schema)
        };
        let levels: Map<String, Value> = (0..=levels).map(level).collect();
        json!({ "$ref": "#/$defs/level0", "$defs": levels })
    }

    #[test]
    fn references_count_like_copies() {
        assert_eq!(
            count_of(&json!({ "type": "object", "properties": { "a": {}, "b": { "const": {} } } })),
            5
        );
        assert!(count_of(&doubling(3)) > 2 * count_of(&doubling(2)) - 20);
        assert!(count_of(&doubling(10)) < MAX_SCHEMAS);
        for levels in [40, 2_000] {
            assert!(count_of(&doubling(levels)) > MAX_SCHEMAS, "{levels}");
        }
        let anchored = json!({ "$ref": "#top", "$defs": { "a": { "$anchor": "top", "not": {} } } });
        assert!(count_of(&anchored) > count_of(&anchored["$defs"]) + 1);
    }

    #[test]
    fn no_spelling_hides_a_reference() {
        let encoded = doubling(40).to_string().replace("#/$defs", "#/%24defs");
        let named = doubling(40).to_string().replace("allOf", "default");
        for text in [encoded, named] {
            assert!(count_of(&serde_json::from_str(&text).expect("JSON")) > MAX_SCHEMAS, "{text:.100}");
        }
        let embedded = json!({ "$ref": "level0" });
        assert_eq!(count("", &embedded, |_, _| None), Err("level0"));
        assert_eq!(decoded("/a%20b/%C3%A9").as_deref(), Some("/a b/é"));
        assert_eq!([decoded("%"), decoded("%zz"), decoded("%ff")], [None, None, None]);
    }

    #[test]
    fn only_an_inner_id_makes_references_ambiguous() {
        let inner = json!({ "$id": "b", "type": "string" });
        let schema = json!({ "$id": "a", "$ref": "#/$defs/b", "$defs": { "b": inner } });
        assert_eq!(ambiguous_id(&schema), Some("b"));
        assert_eq!(ambiguous_id(&json!({ "$id": "a", "$ref": "#/$defs/b", "$defs": { "b": {} } })), None);
        assert_eq!(ambiguous_id(&json!({ "$id": "a", "properties": { "b": inner } })), None);
    }

    #[test]
    fn cycles_are_finite() {
        let list = json!({ "properties": { "next": { "$ref": "#" }, "other": { "$ref": "#" } } });
        assert!(count_of(&list) < 10);
    }
}
