//! A JSON tokenizer, and a JSON tree that preserves the text.
//!
//! ```
//! use uavspec_model::json::Tree;
//!
//! let tree = Tree::read(r#"{"id": "first", "id": "second", "voltage": NaN}"#).unwrap();
//! assert_eq!(tree.get("id").and_then(Tree::as_str), Some("first"));
//! assert_eq!(tree.get("voltage"), Some(&Tree::Token("NaN")));
//!
//! let error = Tree::read(r#"{"id": "#).unwrap_err();
//! assert_eq!(error.at, 7);
//! ```

pub mod base64;
mod error;
mod excerpt;
mod frame;
pub mod pointer;
mod tokens;
mod tree;

pub use self::error::SyntaxError;
pub use self::frame::Frame;
pub use self::pointer::pointer;
pub use self::tokens::{TRUNCATED, Token, Tokens, Unclear};
pub use self::tree::{Tree, shortened};
