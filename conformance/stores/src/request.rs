//! Requests to object stores: their threads, their repetition and their errors.

use std::io;
use std::sync::LazyLock;
use std::time::Duration;

use object_store::Error;
use tokio::runtime::{Builder, Runtime};
use uavspec_model::text::without_secrets;

use super::client::Refused;

/// The number of attempts for a request.
const ATTEMPTS: u32 = 5;

/// The time before the second attempt. It doubles with each attempt.
const PAUSE: Duration = Duration::from_millis(200);

/// The threads of all connections.
pub(super) fn runtime() -> io::Result<&'static Runtime> {
    static RUNTIME: LazyLock<io::Result<Runtime>> = LazyLock::new(|| {
        let mut builder = Builder::new_multi_thread();
        builder.worker_threads(2).thread_name("uavspec store").enable_all().build()
    });
    RUNTIME.as_ref().map_err(|error| io::Error::new(error.kind(), error.to_string()))
}

/// Repeats a request whose response breaks off. The store's client repeats only requests that the store refuses.
pub(super) async fn attempts<T, F: Future<Output = Result<T, Error>>>(
    request: impl Fn() -> F,
) -> Result<T, Error> {
    let mut pause = PAUSE;
    for _ in 1..ATTEMPTS {
        match request().await {
            Err(error) if matches!(error, Error::Generic { .. }) && Refused::cause_of(&error).is_none() => {}
            result => return result,
        }
        tokio::time::sleep(pause).await;
        pause *= 2;
    }
    request().await
}

/// An error without credentials.
pub(super) fn text(error: &Error) -> String {
    Refused::cause_of(error).map_or_else(|| without_secrets(&error.to_string()), ToString::to_string)
}
