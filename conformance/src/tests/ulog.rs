//! The reader of `ULog`: against what another tool reads, on each kind of damage, and on whatever bytes there
//! may be.

mod corruption;
mod log;
mod memory;
mod oracle;
mod problems;
mod properties;
mod seen;
