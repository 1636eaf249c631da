//! Runs work without Python's lock.

use std::collections::VecDeque;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;
use uavspec_tables::{Checker, Options, Problem};

use crate::Error;

/// The interval between checks for an interrupt by the user.
const INTERVAL: Duration = Duration::from_millis(50);

/// The maximum number of checkers that are kept in memory.
const MAX_CHECKERS: usize = 4;

/// The most recent checkers, with their options. A checker keeps the releases that it has read.
static CHECKERS: Mutex<VecDeque<(Options, Arc<Checker>)>> = Mutex::new(VecDeque::new());

/// Runs work in a separate thread, so that it blocks neither other Python threads nor an interrupt. After an interrupt,
/// the thread ends when its work is finished.
pub(crate) fn run<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> Result<T, Problem> + Send + 'static,
) -> PyResult<T> {
    let (sender, results) = channel();
    let started = thread::Builder::new().name("uavspec".to_owned()).spawn(move || sender.send(work()));
    started.map_err(|error| Error::new_err(format!("can't start a thread: {error}")))?;
    // Without Python's lock, only values that threads can share may be used. A receiver can't be shared.
    let results = Mutex::new(results);
    loop {
        let received =
            py.detach(|| results.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(INTERVAL));
        match received {
            Ok(result) => return result.map_err(|problem| Error::new_err(problem.to_string())),
            Err(RecvTimeoutError::Timeout) => py.check_signals()?,
            // The thread has panicked.
            Err(RecvTimeoutError::Disconnected) => {
                return Err(Error::new_err(
                    "uavspec failed: please report this, with the text on standard error",
                ));
            }
        }
    }
}

/// Returns a checker with these options. Reuses a checker that is kept in memory, unless the options name files.
pub(crate) fn checker(options: &Options) -> Result<Arc<Checker>, Problem> {
    // Files may change between two calls.
    let has_files =
        !options.schemas.is_empty() || options.definitions.as_ref().is_some_and(|path| path.exists());
    if has_files {
        return Checker::new(options).map(Arc::new);
    }
    let mut checkers = CHECKERS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some((_, known)) = checkers.iter().find(|(known, _)| known == options) {
        return Ok(Arc::clone(known));
    }
    let checker = Arc::new(Checker::new(options)?);
    checkers.push_front((options.clone(), Arc::clone(&checker)));
    checkers.truncate(MAX_CHECKERS);
    Ok(checker)
}
