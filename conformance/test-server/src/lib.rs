//! Servers and networks for tests of clients.

#![allow(clippy::missing_panics_doc, reason = "a panic is the failure of a test")]

pub mod memory;
pub mod proxy;
pub mod server;
