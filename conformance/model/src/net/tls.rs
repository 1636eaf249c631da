//! TLS for client connections. Without the feature `tls`, each use of TLS is an error.

#[cfg_attr(not(feature = "tls"), path = "tls/missing.rs")]
mod enabled;
#[cfg(feature = "tls")]
mod verifier;

pub use self::enabled::{Trust, explain};
pub(super) use self::enabled::{Wrapped, wrap};
