//! An empty library. The test is in `tests/log.rs`.
