//! TLS in a program without the feature `tls`: each use is an error.

use std::convert::Infallible;
use std::io::{self, Read, Write};
use std::path::Path;

use crate::net::timed::Timed;

/// The certificates that a client trusts. This build has no TLS.
#[derive(Clone, Debug, Default)]
pub struct Trust(());

impl Trust {
    /// Fails if there is an option that requires TLS.
    pub fn new(authorities: Option<&Path>, is_insecure: bool) -> Result<Self, String> {
        if authorities.is_some() || is_insecure { Err(MISSING.to_owned()) } else { Ok(Self(())) }
    }
}

/// The error for any use of TLS.
const MISSING: &str = "this build has no TLS: enable the feature `tls`";

/// A connection that can't exist.
pub(in crate::net) struct Wrapped(Infallible);

impl Wrapped {
    pub(in crate::net) fn timed(&mut self) -> &mut Timed {
        match self.0 {}
    }

    pub(in crate::net) fn finish(&mut self) -> io::Result<()> {
        match self.0 {}
    }
}

impl Read for Wrapped {
    fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
        match self.0 {}
    }
}

impl Write for Wrapped {
    fn write(&mut self, _: &[u8]) -> io::Result<usize> {
        match self.0 {}
    }

    fn flush(&mut self) -> io::Result<()> {
        match self.0 {}
    }
}

#[allow(clippy::needless_pass_by_value)] // as with TLS
pub(in crate::net) fn wrap(_: Timed, _: &str, _: &Trust) -> io::Result<Wrapped> {
    Err(io::Error::new(io::ErrorKind::Unsupported, MISSING))
}

/// Returns the error unchanged.
pub fn explain(error: io::Error) -> io::Error {
    error
}
