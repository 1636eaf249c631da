//! Types and messages of pages: a page for each, with links between them.

mod directory;
mod member;
mod message;
mod types;

pub(super) use self::directory::Json;
