//! What is judged: logs and captures, read as they come, in bounded memory.

pub mod ulog;
