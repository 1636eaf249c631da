//! Tests of the `ULog` reader: with real logs and the results of another tool, with corrupt logs, and with arbitrary
//! bytes.

mod corruption;
mod log;
mod memory;
mod oracle;
mod problems;
mod properties;
mod seen;

use crate::capture::ulog::Reader;

/// The messages of a log that begin within this size.
pub(crate) fn head(bytes: &[u8], size: usize) -> &[u8] {
    let mut reader = Reader::new(bytes);
    while let Some(item) = reader.next().expect("a slice") {
        if item.offset > size as u64 {
            return &bytes[..usize::try_from(item.offset).expect("an offset")];
        }
    }
    bytes
}
