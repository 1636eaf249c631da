//! The Flockwave protocol: sessions, message body schemas, and transports.

pub mod body_schema;
pub(crate) mod record;
pub(crate) mod session;
pub mod transport;
