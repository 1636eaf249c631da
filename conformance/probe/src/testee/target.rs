//! The program or the address of a testee.

use std::ffi::OsString;
use std::fmt;

use uavspec_model::net::Address;

#[cfg(test)]
use super::memory::Program;

/// The program or the address of a testee.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Target {
    /// A program with its arguments. uavspec starts the program and communicates over its standard input and output.
    Command(Vec<OsString>),
    /// The address of a running testee.
    Address(Address),
    /// A testee in memory.
    #[cfg(test)]
    Memory(Program),
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Command(command) => {
                f.write_str(&command.first().map(|program| program.to_string_lossy()).unwrap_or_default())
            }
            Self::Address(address) => address.fmt(f),
            #[cfg(test)]
            Self::Memory(_) => f.write_str("memory"),
        }
    }
}
