//! Hints: decisions about conversions that definitions don't contain.

mod applies;
mod model;
#[cfg(feature = "files")]
mod reader;

pub(super) use self::applies::{constant, missing};
pub(super) use self::model::{Decisions, Hint, HintValue, Key};
pub use self::model::{Hints, Mistake};
#[cfg(feature = "files")]
pub use self::reader::read;

/// Without the feature `files`, hints can't be read.
#[cfg(not(feature = "files"))]
pub(super) fn read(_: &crate::source::SourceMap, _: crate::source::SourceId) -> Hints {
    Hints::default()
}
