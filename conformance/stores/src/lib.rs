//! Captures in object stores: Amazon S3 and compatible stores, Google Cloud Storage, Azure Blob Storage, and web
//! servers.
//!
//! ```text
//!  URL ──list──▶ Objects      Object ──ranges, read ahead──▶ Reader ──bytes──▶ check
//! ```
//!
//! An object is read in ranges, each with the condition that the object is still the same. A request that fails is
//! repeated. Answers and lists have a maximum length, and redirects lead to the same host only. Nothing is stored in
//! files. Errors contain neither credentials nor the queries of URLs, which may be signatures.

#![cfg(feature = "object_store")]

mod client;
mod connect;
mod limits;
mod object;
mod reader;
mod request;

pub use self::connect::list;
