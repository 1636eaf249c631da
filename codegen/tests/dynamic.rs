//! Messages handled without types: against what other tools say, against the generated types, and on
//! whatever bytes there may be.

mod support;

#[path = "dynamic/hostile.rs"]
mod hostile;
#[path = "dynamic/oracle.rs"]
mod oracle;
#[path = "dynamic/properties.rs"]
mod properties;
#[path = "dynamic/typed.rs"]
mod typed;
#[path = "dynamic/ulog.rs"]
mod ulog;
#[path = "dynamic/values.rs"]
mod values;
