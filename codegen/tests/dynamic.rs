//! Messages handled without types: against what other tools say, against the generated types, and on
//! whatever bytes there may be.

mod hostile;
mod oracle;
mod properties;
mod typed;
mod ulog;
mod values;
