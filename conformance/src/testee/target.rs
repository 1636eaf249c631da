//! Where a testee is found.

use std::ffi::OsString;
use std::fmt;

use crate::net::Address;

/// Where a testee is found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Target {
    /// A program and its arguments: it is started, and asked over its standard input and output.
    Command(Vec<OsString>),
    /// Somewhere a testee listens that was started by others.
    Address(Address),
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Command(command) => {
                f.write_str(&command.first().map(|program| program.to_string_lossy()).unwrap_or_default())
            }
            Self::Address(address) => address.fmt(f),
        }
    }
}
