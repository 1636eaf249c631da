//! A program without tables.

use std::io;
use std::path::Path;

use super::{Origin, TableFormat};
use crate::report::{Subject, Unreadable};
use crate::story::Story;

/// The tables of a run, which this program can't write.
pub(crate) enum Dataset {}

/// The captures of an earlier run, which this program can't read.
pub(crate) enum Done {}

impl Done {
    pub(crate) fn contains(&self, _: &str, _: &Origin) -> bool {
        match *self {}
    }
}

fn unsupported() -> io::Error {
    let problem = "this program was built without tables: build it with `--features tables`";
    io::Error::new(io::ErrorKind::Unsupported, problem)
}

impl Dataset {
    pub(crate) fn create(_: &Path, _: TableFormat, _: bool) -> io::Result<Self> {
        Err(unsupported())
    }

    pub(crate) fn resume(_: &Path, _: bool) -> io::Result<(Self, Done)> {
        Err(unsupported())
    }

    pub(crate) fn folder(&self) -> &Path {
        match *self {}
    }

    pub(crate) fn add(&mut self, _: &Subject, _: &Origin, _: Option<&Story>) {
        match *self {}
    }

    pub(crate) fn add_unreadable(&mut self, _: &Unreadable) {
        match *self {}
    }

    pub(crate) fn finish(self) -> io::Result<()> {
        match self {}
    }
}
