//! Bounds the size of schemas with references.
//!
//! Each reference is compiled or checked like a copy of its target. Schemas that refer to each other twice per level
//! therefore need time that doubles with each level.

use serde_json::Value;

use super::places::Place;

/// The maximum number of schemas in a schema, in which each reference counts like a copy of its target.
pub(super) const MAX_SCHEMAS: u64 = 100_000;

/// The maximum nesting depth of values, in which each reference counts like a copy of its target. Compilers of schemas
/// recurse once per level.
const MAX_DEPTH: u64 = 500;

/// A copy of a schema, whose references lead to other parts.
pub(super) struct Part<'f> {
    pub place: Place<'f>,
    /// The location in the file, in short.
    pub location: String,
    pub value: Value,
    /// The size without the targets of references.
    pub size: Size,
    /// The targets of references, each with the depth of the reference.
    pub references: Vec<(u64, usize)>,
}

impl<'f> Part<'f> {
    pub(super) fn new(place: Place<'f>, location: String) -> Self {
        Self { place, location, value: Value::Null, size: Size::default(), references: Vec::new() }
    }
}

/// The size of a schema.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Size {
    /// The number of schemas.
    pub count: u64,
    /// The number of nested values.
    pub depth: u64,
}

impl Size {
    /// Includes the size of a schema within this one.
    pub(super) fn include(&mut self, inner: Self) {
        self.count = self.count.saturating_add(inner.count);
        self.depth = self.depth.max(inner.depth);
    }

    /// True if a schema of this size can be compiled.
    pub(super) fn is_small(self) -> bool {
        self.count <= MAX_SCHEMAS && self.depth <= MAX_DEPTH
    }
}

/// The size of the first part, in which each reference counts like a copy of its target. References within a cycle count
/// once.
pub(super) fn size(parts: &[Part<'_>]) -> Size {
    let mut sizes: Vec<Option<Size>> = vec![None; parts.len()];
    // The search has its own stack, because references can form long chains.
    let mut open = vec![(0, 0)];
    sizes[0] = Some(Size::default());
    while let Some((part, next)) = open.pop() {
        let Some((_, target)) = parts[part].references.get(next) else {
            sizes[part] = Some(total(&parts[part], &sizes));
            continue;
        };
        open.push((part, next + 1));
        if sizes[*target].is_none() {
            // A part that is still open counts 0: the reference leads back to it.
            sizes[*target] = Some(Size::default());
            open.push((*target, 0));
        }
    }
    sizes[0].unwrap_or_default()
}

/// The size of a part, with the known sizes of the targets of its references.
fn total(part: &Part<'_>, sizes: &[Option<Size>]) -> Size {
    let mut total = part.size;
    for (depth, target) in &part.references {
        let target = sizes[*target].unwrap_or_default();
        total.include(Size { depth: depth + 1 + target.depth, ..target });
    }
    total
}
