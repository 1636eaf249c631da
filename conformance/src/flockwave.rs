//! The Flockwave protocol: sessions, the body schemas of its messages, and the transports that carry them.

pub mod body_schema;
pub(crate) mod record;
pub(crate) mod session;
pub mod transport;
