//! Pages for the types and messages that are defined on specification pages.

mod directory;
mod member;
mod message;
mod types;

pub(super) use self::directory::Json;
