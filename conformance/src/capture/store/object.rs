//! An object that is a capture.

use std::fmt;
use std::io::{self, Read};
use std::sync::Arc;

use object_store::ObjectStore;
use object_store::path::Path;

use super::reader::{Failure, Known, Reader};

/// An object in an object store.
#[derive(Clone)]
pub(crate) struct Object {
    store: Arc<dyn ObjectStore>,
    location: Path,
    /// The URL without its query.
    url: String,
    /// The size and the version, if the list states them. Lists of web servers don't.
    known: Option<Known>,
}

impl Object {
    pub(super) fn new(
        store: &Arc<dyn ObjectStore>,
        location: Path,
        url: String,
        known: Option<Known>,
    ) -> Self {
        Self { store: Arc::clone(store), location, url, known }
    }

    /// The URL without its query.
    pub(crate) fn url(&self) -> &str {
        &self.url
    }

    /// The size in bytes, if the list states it.
    pub(crate) fn size(&self) -> Option<u64> {
        self.known.as_ref().map(|known| known.size)
    }

    /// The version, if the list states it.
    pub(crate) fn etag(&self) -> Option<&str> {
        self.known.as_ref()?.etag.as_deref()
    }

    /// Opens the object. `failure` receives the reason if reading fails.
    ///
    /// # Errors
    /// Fails if the object doesn't exist, or if the store refuses it.
    pub(crate) fn open(&self, failure: &Failure) -> io::Result<Box<dyn Read + Send>> {
        let reader = Reader::open(&self.store, &self.location, self.known.clone(), failure.clone())?;
        Ok(Box::new(reader))
    }
}

impl fmt::Debug for Object {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.url)
    }
}
