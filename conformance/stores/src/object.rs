//! An object that is a capture.

use std::fmt;
use std::io::{self, Read};
use std::sync::Arc;

use object_store::ObjectStore;
use object_store::path::Path;
use uavspec_capture::input::Failure;

use crate::reader::{Known, Reader};

/// An object in an object store.
#[derive(Clone)]
pub(crate) struct Object {
    store: Arc<dyn ObjectStore>,
    location: Path,
    /// The URL without its query.
    url: String,
    /// The size and the version, if the list contains them. Lists of web servers don't.
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
}

impl uavspec_capture::input::Object for Object {
    fn url(&self) -> &str {
        &self.url
    }

    fn size(&self) -> Option<u64> {
        self.known.as_ref().map(|known| known.size)
    }

    fn etag(&self) -> Option<&str> {
        self.known.as_ref()?.etag.as_deref()
    }

    fn open(&self, failure: &Failure) -> io::Result<Box<dyn Read + Send>> {
        let reader = Reader::open(&self.store, &self.location, self.known.clone(), failure.clone())?;
        Ok(Box::new(reader))
    }
}

impl fmt::Debug for Object {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.url)
    }
}
