//! Messages handled without types: against what other tools say, against the generated types, and on
//! whatever bytes there may be.

mod support;

#[path = "dynamic/oracle.rs"]
mod oracle;
#[path = "dynamic/ulog.rs"]
mod ulog;
