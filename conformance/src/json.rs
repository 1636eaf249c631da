//! JSON: one tokenizer, and the tree that is made with it.

pub(crate) mod base64;
mod error;
mod frame;
mod pointer;
mod tokens;
mod tree;

pub(crate) use self::error::SyntaxError;
pub(crate) use self::frame::Frame;
pub(crate) use self::pointer::pointer;
pub(crate) use self::tokens::{CUT_OFF, Token, Tokens, Unclear};
pub use self::tree::Tree;
pub(crate) use self::tree::shortened;
