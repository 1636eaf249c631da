//! The memory limit for a domain.
//!
//! When rustdds receives the first fragment of a message, it reserves memory of the size that the fragment claims,
//! before it knows the sender. No setting limits this. With forged fragments, the process would use memory until the
//! system kills it, or another process.

use std::time::{Duration, Instant};

use uavspec_model::clock::Clock;

/// The growth of memory at which the connection ends, in bytes. Even the subscribers of several cameras need less.
const MAX_GROWTH: u64 = 2 << 30;

/// The growth of memory at which allocations fail, in bytes. A fragment claims at most 4 GiB, so the connection can end
/// before this limit is reached.
#[cfg(target_os = "linux")]
const HARD_LIMIT: u64 = 7 << 30;

/// The time between two measurements.
pub(crate) const INTERVAL: Duration = Duration::from_millis(100);

/// Measures the memory of this process. Only Linux reports it.
pub(crate) struct Memory {
    /// The memory at the start of the connection.
    start: u64,
    next: Instant,
}

impl Memory {
    /// Starts the measurement. From then on, allocations beyond the hard limit fail, which ends the program.
    pub(crate) fn start() -> Self {
        let start = used().unwrap_or(0);
        limit(start);
        Self { start, next: Clock::real().now() }
    }

    /// Fails if the process uses too much memory.
    pub(crate) fn check(&mut self) -> Result<(), String> {
        if Clock::real().now() < self.next {
            return Ok(());
        }
        self.next = Clock::real().now() + INTERVAL;
        let growth = used().unwrap_or(0).saturating_sub(self.start);
        if growth <= MAX_GROWTH {
            return Ok(());
        }
        Err(format!(
            "rustdds uses more than {} GiB of memory: a message in the domain is too large, or forged",
            MAX_GROWTH >> 30
        ))
    }
}

/// The size of this process's private memory, in bytes, including reserved memory.
fn used() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmData:"))?;
    line.trim().strip_suffix(" kB")?.parse().ok().map(|size: u64| size << 10)
}

/// Lowers the system's limit on private memory to the hard limit.
#[cfg(target_os = "linux")]
fn limit(start: u64) {
    use nix::sys::resource::{Resource, getrlimit, setrlimit};
    if let Ok((soft, hard)) = getrlimit(Resource::RLIMIT_DATA) {
        // The probe also works without this limit.
        let _ = setrlimit(Resource::RLIMIT_DATA, soft.min(start + HARD_LIMIT), hard);
    }
}

#[cfg(not(target_os = "linux"))]
fn limit(_: u64) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn excessive_memory_is_reported() {
        let mut memory = Memory::start();
        assert_eq!(memory.check(), Ok(()));
        if cfg!(target_os = "linux") {
            let used = used().expect("the memory");
            assert!(used > 0);
            // Reserved, but never touched.
            let reserved: Vec<u8> =
                Vec::with_capacity(usize::try_from(MAX_GROWTH).expect("a size") + (512 << 20));
            memory.next = Clock::real().now();
            assert!(memory.check().is_err(), "{}", reserved.capacity());
        }
    }
}
