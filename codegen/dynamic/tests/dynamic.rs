//! Tests of messages whose types are known only at run time: against other tools, against generated types, and with
//! arbitrary bytes.

mod contents;
mod hostile;
mod oracle;
mod properties;
mod typed;
mod ulog;
mod values;
