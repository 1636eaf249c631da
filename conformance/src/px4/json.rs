//! What the JSON of a message has to be, and what is wrong with it where it isn't.
//!
//! A message that is written as those before it, but for its values, is compared with them (`template.rs`). Other
//! text is read once, without a tree, by a reader that only says whether all is well ([`Plans::read`]). What
//! isn't is read again into a [`Tree`], which keeps what other trees lose: repeated keys, numbers as they are
//! written, and tokens that are no JSON, such as `NaN`. From the tree every breach is told
//! ([`Plans::explain`]). Both ask the same functions of single values (`value.rs`), so they can hardly
//! disagree, and a test with random damage holds them to it.

mod clean;
mod dialect;
mod explain;
mod template;
#[cfg(test)]
mod tests;
mod value;

pub(crate) use self::clean::Clean;
pub(crate) use self::dialect::Dialects;
pub(crate) use self::explain::MessageOrigin;
pub(crate) use self::template::Template;
pub(crate) use super::values::Plans;
