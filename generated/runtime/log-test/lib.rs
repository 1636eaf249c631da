//! Holds the test in `tests/log.rs` and nothing else.
