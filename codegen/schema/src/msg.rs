//! The `.msg` language and the related `.srv` and `.action` languages: text to syntax tree.
//!
//! The parser reads line by line and doesn't stop at errors: it reports an invalid line and continues with the next
//! line. The tree preserves everything, including comments and empty lines.
//!
//! ```
//! use uavspec_schema::msg::{Dialect, Kind};
//!
//! assert_eq!(Kind::of("srv/Tow.srv"), Some(Kind::Service));
//! assert_eq!(Kind::Service.part_suffixes(), ["_Request", "_Response"]);
//! assert_eq!(Dialect::Ros2.name(), "ros2");
//! ```

pub mod annotation;
pub mod ast;
pub mod attribute;
pub mod constraint;
mod kind;
pub(crate) mod literal;
mod parser;
pub mod statement;
pub mod words;

pub use self::kind::{Dialect, Kind};
pub use self::parser::is_separator;
use crate::diagnostic::Diagnostic;
use crate::source::{SourceId, SourceMap};

/// Parses the source `id`. Returns a tree with everything that could be read, and the diagnostics.
pub fn parse(
    sources: &SourceMap,
    id: SourceId,
    kind: Kind,
    dialect: Dialect,
) -> (ast::Definition<'_>, Vec<Diagnostic>) {
    parser::parse(sources.text(id), sources.span(id), kind, dialect)
}
