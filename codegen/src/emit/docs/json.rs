//! Pages of the types and messages that pages of a specification define.

mod directory;
mod member;
mod message;
mod types;

pub(super) use self::directory::Json;
