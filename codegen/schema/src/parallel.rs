//! Parallel execution.

use std::num::NonZero;
use std::sync::LazyLock;
use std::thread;

/// The minimum number of items that are distributed to several threads. Each thread gets at least half of this number.
/// Starting threads takes longer than reading a few definitions.
const MIN_ITEMS: usize = 128;

/// The number of threads that the system runs in parallel. Cached, because the standard library reads several files on
/// Linux to determine this number.
static THREADS: LazyLock<usize> = LazyLock::new(|| thread::available_parallelism().map_or(1, NonZero::get));

/// Calls `work` for consecutive parts of `items` in several threads, and returns the results in order. The number of
/// parts depends on the system, so the combined results must not depend on this number.
pub fn in_parts<'i, T: Sync, R: Send>(items: &'i [T], work: impl Fn(&'i [T]) -> R + Sync) -> Vec<R> {
    if items.len() < MIN_ITEMS || *THREADS == 1 {
        return vec![work(items)];
    }
    in_threads(items.chunks(items.len().div_ceil(*THREADS).max(MIN_ITEMS / 2)), work)
}

/// Calls `work` for each of `items` in a separate thread, and returns the results in order.
pub fn in_parallel<'i, T: Sync, R: Send, E: Send>(
    items: &'i [T],
    work: impl Fn(&'i T) -> Result<R, E> + Sync,
) -> Result<Vec<R>, E> {
    in_threads(items.iter(), work).into_iter().collect()
}

// The current thread only waits. Linux starts a new thread on the processor of its parent. If the parent continues to
// work, the new thread waits until Linux moves it.
fn in_threads<T: Send, R: Send>(items: impl Iterator<Item = T>, work: impl Fn(T) -> R + Sync) -> Vec<R> {
    thread::scope(|scope| {
        let work = &work;
        let threads: Vec<_> = items.map(|item| scope.spawn(move || work(item))).collect();
        // A panic in a thread is a bug; propagate it.
        let join = |thread: thread::ScopedJoinHandle<'_, R>| {
            thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        };
        threads.into_iter().map(join).collect()
    })
}
