//! Hints: decisions about conversions that definitions don't contain.

mod applies;
mod model;
mod reader;

pub(super) use self::applies::{constant, missing};
pub(super) use self::model::{Decisions, Hint, HintValue, Key};
pub use self::model::{Hints, Mistake};
pub use self::reader::read;
