//! Tests of the `ULog` reader: with real logs and the results of another tool, with corrupt logs, and with arbitrary
//! bytes.

mod corruption;
mod log;
mod memory;
mod oracle;
mod problems;
mod properties;
mod seen;
