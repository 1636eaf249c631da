//! The limit of open files.

/// The number of files that the process may open, if the system limits it.
#[cfg(unix)]
pub fn open_files() -> Option<u64> {
    use nix::sys::resource::{Resource, getrlimit};
    getrlimit(Resource::RLIMIT_NOFILE).ok().map(|(soft, _)| soft)
}

/// Returns `None`, because this system doesn't limit the number of open files.
#[cfg(not(unix))]
pub fn open_files() -> Option<u64> {
    None
}

/// Raises the number of files that the process may open, as far as the system permits it.
#[cfg(unix)]
pub fn raise_open_files(wanted: u64) {
    use nix::sys::resource::{Resource, getrlimit, setrlimit};
    if let Ok((soft, hard)) = getrlimit(Resource::RLIMIT_NOFILE)
        && soft < wanted
    {
        // Without permission, callers use fewer files.
        let _ = setrlimit(Resource::RLIMIT_NOFILE, wanted.min(hard), hard);
    }
}

/// Does nothing, because this system doesn't limit the number of open files.
#[cfg(not(unix))]
pub fn raise_open_files(_: u64) {}

#[cfg(all(test, unix))]
mod tests {
    use nix::sys::resource::{Resource, getrlimit};

    use super::*;

    #[test]
    fn only_raises_the_limit() {
        let limit = || getrlimit(Resource::RLIMIT_NOFILE).expect("a limit");
        let (soft, hard) = limit();
        raise_open_files(0);
        assert!(limit().0 >= soft);
        raise_open_files(soft.saturating_add(1));
        assert!(limit().0 > soft || soft == hard);
        assert_eq!(limit().1, hard);
    }
}
