//! Tables, for a program without the feature `tables`: each use is an error.

use std::io;
use std::path::Path;

use uavspec_check::timeline::Timeline;
use uavspec_report::{Origin, Subject, TableFormat, Unreadable};

/// The tables of a run, which this program can't write.
pub(super) enum Dataset {}

/// The captures of an earlier run, which this program can't read.
pub(super) enum Done {}

impl Done {
    pub(super) fn contains(&self, _: &str, _: &Origin) -> bool {
        match *self {}
    }
}

fn unsupported() -> io::Error {
    let problem = "this program was built without tables: build it with `--features tables`";
    io::Error::new(io::ErrorKind::Unsupported, problem)
}

impl Dataset {
    pub(super) fn create(_: &Path, _: TableFormat, _: bool) -> io::Result<Self> {
        Err(unsupported())
    }

    pub(super) fn resume(_: &Path, _: bool) -> io::Result<(Self, Done)> {
        Err(unsupported())
    }

    pub(super) fn folder(&self) -> &Path {
        match *self {}
    }

    pub(super) fn add(&mut self, _: &Subject, _: &Origin, _: Option<&Timeline>) {
        match *self {}
    }

    pub(super) fn add_unreadable(&mut self, _: &Unreadable) {
        match *self {}
    }

    pub(super) fn finish(self) -> io::Result<()> {
        match self {}
    }
}
