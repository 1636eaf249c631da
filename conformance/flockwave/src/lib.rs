//! The Flockwave protocol: messages enter and leave over its [transports](transport), a [session] relates responses and
//! notifications to requests, and [body schemas](body_schema) describe what messages contain.
//!
//! ```
//! use uavspec_flockwave::transport::Endpoint;
//!
//! let endpoint: Endpoint = "tcp://127.0.0.1:5001".parse().unwrap();
//! assert_eq!(endpoint.to_string(), "tcp://127.0.0.1:5001");
//! ```

#![cfg_attr(not(test), warn(clippy::disallowed_macros, clippy::disallowed_methods))]

pub mod body_schema;
pub mod limits;
pub mod record;
pub mod session;
pub mod transport;
