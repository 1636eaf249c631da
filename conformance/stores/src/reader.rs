//! Reads an object in ranges. The next range is requested while the current one is read.

use std::io::{self, Read};
use std::ops::Range;
use std::sync::Arc;

use bytes::{Buf as _, Bytes, BytesMut};
use futures_util::{Stream, TryStreamExt as _};
use object_store::path::Path;
use object_store::{Error, GetOptions, ObjectMeta, ObjectStore, ObjectStoreExt as _};
use tokio::task::JoinHandle;
use uavspec_capture::input::Failure;
use uavspec_model::text::thousands;

use crate::limits::MAX_OBJECT;
use crate::request::{attempts, runtime, text};

/// The size of a range, in bytes. Two ranges are in memory for each reader.
const RANGE: u64 = 4 << 20;

/// The state of an object.
#[derive(Clone, Debug)]
pub(super) struct Known {
    pub(super) size: u64,
    pub(super) etag: Option<String>,
}

impl From<ObjectMeta> for Known {
    fn from(meta: ObjectMeta) -> Self {
        Self { size: meta.size, etag: meta.e_tag.map(quoted) }
    }
}

/// A version in quotation marks, as in the headers of HTTP. Azure omits them in lists.
fn quoted(etag: String) -> String {
    if etag.ends_with('"') { etag } else { format!("\"{etag}\"") }
}

/// The bytes of an object, in order.
pub(crate) struct Reader {
    store: Arc<dyn ObjectStore>,
    location: Path,
    known: Known,
    /// The rest of the current range.
    current: Bytes,
    /// The offset at which the next range to request starts.
    next: u64,
    pending: Option<JoinHandle<Result<Bytes, String>>>,
    failure: Failure,
}

impl Reader {
    pub(super) fn open(
        store: &Arc<dyn ObjectStore>,
        location: &Path,
        known: Option<Known>,
        failure: Failure,
    ) -> io::Result<Self> {
        let known = match known {
            Some(known) => known,
            None => runtime()?.block_on(store.head(location)).map_err(|error| unreadable(&error))?.into(),
        };
        if known.size > MAX_OBJECT {
            let problem = format!("the size is {} bytes according to the server", thousands(known.size));
            return Err(io::Error::new(io::ErrorKind::FileTooLarge, problem + ", which is more than 1 TiB"));
        }
        let (store, location) = (Arc::clone(store), location.clone());
        let mut reader =
            Self { store, location, known, current: Bytes::new(), next: 0, pending: None, failure };
        reader.request()?;
        Ok(reader)
    }

    /// Requests the next range, if there is one.
    fn request(&mut self) -> io::Result<()> {
        let range = self.next..self.known.size.min(self.next.saturating_add(RANGE));
        if range.is_empty() {
            return Ok(());
        }
        self.next = range.end;
        let (store, location, etag) =
            (Arc::clone(&self.store), self.location.clone(), self.known.etag.clone());
        self.pending = Some(runtime()?.spawn(async move { receive(&*store, &location, etag, range).await }));
        Ok(())
    }
}

impl Read for Reader {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if self.current.is_empty()
            && let Some(pending) = self.pending.take()
        {
            let received = runtime()?.block_on(pending).map_err(io::Error::other)?;
            self.current = received.map_err(|problem| {
                self.failure.set(&problem);
                io::Error::other(problem)
            })?;
            self.request()?;
        }
        let length = out.len().min(self.current.len());
        self.current.copy_to_slice(&mut out[..length]);
        Ok(length)
    }
}

/// Receives a range of an object.
async fn receive(
    store: &dyn ObjectStore,
    location: &Path,
    etag: Option<String>,
    range: Range<u64>,
) -> Result<Bytes, String> {
    let length = usize::try_from(range.end - range.start).unwrap_or(usize::MAX);
    let request = || async {
        let range = Some(range.clone().into());
        let options = GetOptions { if_match: etag.clone(), range, ..GetOptions::default() };
        let result = store.get_opts(location, options).await?;
        let is_same = etag.is_none() || result.meta.e_tag.clone().map(quoted) == etag;
        Ok((is_same, up_to(length, result.into_stream()).await?))
    };
    match attempts(request).await {
        Ok((true, bytes)) if bytes.len() == length => Ok(bytes),
        Ok(_) | Err(Error::Precondition { .. }) => Err(CHANGED.to_owned()),
        Err(Error::NotFound { .. }) => Err("the object was deleted while it was read".to_owned()),
        Err(error) => Err(text(&error)),
    }
}

/// The bytes of a stream, up to a length. A longer stream isn't read to its end: the last part may exceed the length.
async fn up_to(
    length: usize,
    mut stream: impl Stream<Item = object_store::Result<Bytes>> + Unpin,
) -> object_store::Result<Bytes> {
    let mut bytes = BytesMut::new();
    while bytes.len() <= length
        && let Some(part) = stream.try_next().await?
    {
        bytes.extend_from_slice(&part);
    }
    Ok(bytes.freeze())
}

/// The error for an object whose version changed during reading.
const CHANGED: &str = "the object changed while it was read";

/// The error for an object that can't be opened.
fn unreadable(error: &Error) -> io::Error {
    let kind = match error {
        Error::NotFound { .. } => io::ErrorKind::NotFound,
        Error::PermissionDenied { .. } | Error::Unauthenticated { .. } => io::ErrorKind::PermissionDenied,
        _ => io::ErrorKind::Other,
    };
    io::Error::new(kind, text(error))
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use futures_util::stream;

    use super::*;

    #[test]
    fn a_stream_without_end_is_read_up_to_the_length() {
        let taken = Cell::new(0);
        let endless = stream::repeat_with(|| {
            taken.set(taken.get() + 1);
            Ok(Bytes::from_static(&[0; 10]))
        });
        let read = runtime().expect("a runtime").block_on(up_to(25, endless)).expect("bytes");
        assert_eq!((read.len(), taken.get()), (30, 3));
    }
}
