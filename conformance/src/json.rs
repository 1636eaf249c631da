//! JSON as it is written: one tokenizer, and the tree that is made with it.

pub mod base64;
mod cursor;
mod pointer;
mod tree;

pub(crate) use self::cursor::{Cursor, Key, Token};
pub use self::pointer::pointer;
pub(crate) use self::tree::{CUT_OFF, shortened};
pub use self::tree::{SyntaxError, Tree};
