//! A pair of messages, seen in the direction of the conversion.

use std::collections::BTreeMap;

use uavspec_schema::{Message, MessageId, Schema};

use crate::breaking::{FieldChange, Pair};

/// The matched messages of both packages, by old and new id.
pub(super) type Pairs<'a> = BTreeMap<(MessageId, MessageId), &'a Pair<'a>>;

/// One side of a conversion.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side<'a> {
    pub(super) schema: &'a Schema,
    pub(super) message: &'a Message,
}

/// A pair of messages, seen in the direction of the conversion.
pub(super) struct Direction<'a> {
    pub(super) is_forward: bool,
    pub(super) from: Side<'a>,
    pub(super) to: Side<'a>,
    /// Maps the index of each target field to the index of its source field.
    pub(super) sources: BTreeMap<usize, usize>,
    pub(super) pair: &'a Pair<'a>,
    /// All matched messages, by old and new id.
    pub(super) pairs: &'a Pairs<'a>,
}

impl<'a> Direction<'a> {
    pub(super) fn new(pair: &'a Pair<'a>, pairs: &'a Pairs<'a>, is_forward: bool) -> Self {
        let old = Side { schema: pair.old_schema, message: pair.old };
        let new = Side { schema: pair.new_schema, message: pair.new };
        let kept = pair.fields.iter().filter_map(|change| match change {
            FieldChange::Kept(kept) => Some((kept.old, kept.new)),
            FieldChange::Removed(_) | FieldChange::Added(_) => None,
        });
        let sources = kept.map(|(old, new)| if is_forward { (new, old) } else { (old, new) });
        let (from, to) = if is_forward { (old, new) } else { (new, old) };
        Self { is_forward, from, to, sources: sources.collect(), pair, pairs }
    }

    /// Orders a pair of a source and a target item as old and new.
    pub(super) fn old_and_new<T>(&self, from: T, to: T) -> (T, T) {
        if self.is_forward { (from, to) } else { (to, from) }
    }
}
