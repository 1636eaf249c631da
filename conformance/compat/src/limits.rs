//! Limits on input.

/// The maximum length of a source file in bytes.
pub const MAX_SOURCE: usize = 1 << 20;

/// The maximum number of source files.
pub const MAX_FILES: usize = 20_000;

/// The maximum number of places that name topics.
pub const MAX_PLACES: usize = 100_000;

/// The maximum number of tokens of an expression before or after the name of a topic.
pub const MAX_EXPRESSION: usize = 100;

/// The maximum number of calls around the name of a topic in which its type is searched.
pub const MAX_CALLS: usize = 3;

/// The maximum depth of lists and mappings in a list of DDS topics.
pub const MAX_DEPTH: usize = 32;
