//! A helper of unit tests.

/// `full` if `UAVSPEC_TEST_THOROUGH` is set, as in `.ci/run`; otherwise `quick`.
pub(crate) fn extent<T>(full: T, quick: T) -> T {
    if std::env::var_os("UAVSPEC_TEST_THOROUGH").is_some_and(|value| value != "0") { full } else { quick }
}
