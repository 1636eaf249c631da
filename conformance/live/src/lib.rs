//! Live vehicles and servers. The input is the messages of a [bus]. The output is a recorded bag, findings and
//! [displays](watch). A program can also take a [role](vehicle) in PX4's arming checks.
//!
//! ```
//! use uavspec_live::bus::Address;
//!
//! let address: Address = "zenoh://127.0.0.1".parse().unwrap();
//! assert_eq!(address.to_string(), "zenoh://127.0.0.1:7447");
//! ```

#![cfg_attr(not(test), warn(clippy::disallowed_macros, clippy::disallowed_methods))]

pub mod bus;
mod limits;
pub mod vehicle;
pub mod watch;
