//! Captures that aren't files.

use std::fmt::Debug;
use std::io::{self, Read};
use std::sync::{Arc, Mutex, PoisonError};

use super::Input;

/// A capture in an object store.
pub trait Object: Debug + Send + Sync {
    /// The URL without its query.
    fn url(&self) -> &str;

    /// The size in bytes, if the list contains it.
    fn size(&self) -> Option<u64>;

    /// The version, if the list contains it.
    fn etag(&self) -> Option<&str>;

    /// Opens the object. `failure` receives the reason if reading fails.
    ///
    /// # Errors
    /// Fails if the object doesn't exist, or if the store refuses it.
    fn open(&self, failure: &Failure) -> io::Result<Box<dyn Read + Send>>;
}

/// The objects that a URL denotes, and the other objects in its folder.
#[derive(Debug, Default)]
pub struct Listed {
    /// The captures.
    pub captures: Vec<Input>,
    /// The URLs of objects without the name of a capture.
    pub skipped: Vec<String>,
}

impl Listed {
    /// The error for a URL without captures. An incomplete folder name also has none, because stores list whole folders
    /// only.
    pub const NOTHING: &str =
        "no captures at this URL: expected a capture, a folder, or a list on a web server";
}

/// The reason why an object couldn't be read completely. Without the reason, the capture would look truncated.
#[derive(Clone, Debug, Default)]
pub struct Failure(Arc<Mutex<Option<String>>>);

impl Failure {
    /// Sets the reason, unless there already is one.
    pub fn set(&self, problem: &str) {
        let mut known = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        known.get_or_insert_with(|| problem.to_owned());
    }

    /// Removes and returns the reason, if there is one.
    pub fn take(&self) -> Option<String> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}
