//! Reads definitions from files, and generates code and documentation. The input is a configuration file or paths, and
//! the output is generated files. This crate finds and writes files, and contains the command line. Other crates
//! perform the steps in between:
//!
//! ```text
//!  text ──uavspec-schema──▶ Schema ──▶ uavspec-emit: Rust, TypeScript, Python, JSON Schema, pages, test vectors
//!                                ├──▶ uavspec-dynamic: codecs and checks at run time, comparisons, conversions
//!                                └──▶ uavspec-lint: findings, formatting, releases
//! ```
//!
//! Reading doesn't stop at the first error: each step returns everything that it could read, and a list of
//! [`Diagnostic`](uavspec_schema::diagnostic::Diagnostic)s.
//!
//! ```
//! let folder = tempfile::tempdir()?;
//! std::fs::write(folder.path().join("Wind.msg"), "float32 speed  # [m/s] Speed\n")?;
//! let (_, schema) = uavspec_codegen::load::read_definitions(folder.path())?;
//! let files = uavspec_emit::json_schema::emit(&schema, &uavspec_emit::json_schema::Options::default());
//! assert!(files.iter().any(|file| file.path.ends_with("Wind.schema.json")));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! `cargo xtask bench codegen` measures how long each step takes with PX4's messages, and how this time grows with the
//! number of messages.

#![cfg_attr(not(test), warn(clippy::disallowed_macros, clippy::disallowed_methods))]

pub mod cli;
mod generate;
pub mod load;

pub use generate::{Generated, generate};
