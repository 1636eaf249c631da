//! JSON: one tokenizer, and the tree that is made with it.

pub mod base64;
mod frame;
mod pointer;
mod tokens;
mod tree;

pub(crate) use self::frame::Frame;
pub use self::pointer::pointer;
pub(crate) use self::tokens::{CUT_OFF, Token, Tokens, Unclear};
pub(crate) use self::tree::shortened;
pub use self::tree::{SyntaxError, Tree};
