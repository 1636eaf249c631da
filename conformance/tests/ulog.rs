//! The reader of `ULog`: against what another tool reads, on each kind of damage, and on whatever bytes there
//! may be.

mod support;

#[path = "ulog/damage.rs"]
mod damage;
#[path = "ulog/log.rs"]
mod log;
#[path = "ulog/memory.rs"]
mod memory;
#[path = "ulog/oracle.rs"]
mod oracle;
#[path = "ulog/problems.rs"]
mod problems;
#[path = "ulog/properties.rs"]
mod properties;
