//! The state of the resolution.

use std::collections::{BTreeSet, HashMap};

use uavspec_runtime::Scalar;

use super::gather::ByPrefix;
use crate::diagnostic::Diagnostic;
use crate::span::Span;
use crate::value::Value;
use crate::{EnumRef, MessageId, Schema};

/// A field with an enum that is created later, when all constants are known.
pub(super) struct PendingEnum {
    /// The index of the message with the field.
    pub(super) message: usize,
    pub(super) field: usize,
    /// The message that defines the constants.
    pub(super) owner: MessageId,
    pub(super) prefixes: Vec<String>,
    pub(super) is_flags: bool,
    pub(super) span: Span,
}

/// The owner, the prefixes, the type, and a flag that is true if the values are masks.
type EnumKey = (MessageId, Vec<String>, Scalar, bool);

#[derive(Default)]
pub(super) struct Resolver<'s> {
    pub(super) schema: Schema,
    pub(super) diagnostics: Vec<Diagnostic>,
    /// Messages by package and name.
    pub(super) by_name: HashMap<(usize, &'s str), MessageId>,
    pub(super) package_by_name: HashMap<String, usize>,
    /// The origin of each message, in the order of [`Schema::messages`].
    pub(super) origins: Vec<Origin>,
    pub(super) pending: Vec<PendingEnum>,
    pub(super) claimed: Vec<BTreeSet<String>>,
    pub(super) suggestions: usize,
    pub(super) selections: Vec<Option<Vec<(String, Span)>>>,
    /// The constants of the current part.
    pub(super) constants: HashMap<&'s str, Value>,
    /// The enums created so far; `None` for enums without members.
    pub(super) gathered: HashMap<EnumKey, Option<EnumRef>>,
    /// For each message with enums, its constants by prefix.
    pub(super) by_prefix: HashMap<MessageId, ByPrefix>,
    /// The total number of enum members.
    pub(super) members: usize,
}

#[derive(Clone, Copy)]
pub(super) struct Origin {
    pub(super) package: usize,
    pub(super) file: usize,
    pub(super) part: usize,
}

impl Resolver<'_> {
    pub(super) fn report(&mut self, diagnostic: Diagnostic) {
        self.diagnostics.push(diagnostic);
    }
}

/// The id of the message at `index` in [`Schema::messages`]. The index fits into a `u32`, because there are fewer
/// messages than source bytes.
pub(super) fn id(index: usize) -> MessageId {
    MessageId(offset(index))
}

/// Converts an index to a `u32`. The list has fewer entries than there are source bytes.
pub(super) fn offset(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}
