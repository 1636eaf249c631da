//! Tests of the program `uavspec` and of the public API, one module per file.

mod baseline;
#[cfg(unix)]
mod ci;
mod cli;
mod compat;
mod convert;
mod explain;
mod init;
mod outcomes;
mod outputs;
mod probe;
#[cfg(all(feature = "stores", feature = "tables"))]
mod python;
#[cfg(feature = "schemas")]
mod schema;
mod serve;
#[cfg(all(feature = "stores", feature = "tables"))]
mod stores;
mod testee;
mod transport;
mod untrusted;
mod watch;
