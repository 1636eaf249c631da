//! Limits on the input and the stored data, which bound the time and the memory that hostile input takes.

/// Maximum nesting depth of messages. Codecs recurse once per level, so this limit bounds the stack. JSON readers may
/// have a lower limit (`serde_json` allows 127 nested brackets). Real messages nest up to seven levels deep.
pub(crate) const MAX_DEPTH: usize = 32;

/// The maximum number of field comparisons when detecting renamed messages. If more comparisons are needed, renames are
/// not detected.
pub(crate) const MAX_COMPARISONS: usize = 1_000_000;

/// The maximum number of name comparisons per message, for all runs of unmatched fields together. Beyond this limit,
/// fields are matched by their order.
pub(crate) const MAX_REORDERINGS: usize = 20_000;

/// The maximum length of an expression, in bytes.
pub(crate) const MAX_EXPRESSION: usize = 4096;

/// The maximum depth of nested expressions.
pub(crate) const MAX_EXPRESSION_DEPTH: usize = 64;

/// The maximum size of a converted message in memory, in bytes. Without a limit, a sequence of messages that gain many
/// fields could take up much more memory than its payload.
pub const MAX_CONVERTED: usize = 256 << 20;

/// The maximum length of the text of an event, in bytes.
pub(crate) const MAX_EVENT_TEXT: usize = 4 << 10;

/// The maximum number of parts of a message that is copied from CDR part by part, and its maximum size in bytes. Larger
/// messages are read field by field.
pub(crate) const MAX_PARTS: usize = 64;
pub(crate) const MAX_TRANSFERRED: usize = 1 << 16;
