//! Texts that follow the grammar of a TOML file. Random bytes would rarely be accepted by the TOML parser.

use std::fmt::Write as _;

/// A table: its header and its keys, each with possible values. The first value of each key is valid.
pub(crate) type Table = (&'static str, &'static [(&'static str, &'static [&'static str])]);

/// A text that the bytes select from these tables. Keys may be missing, or have invalid values.
pub(crate) fn text(tables: &[Table], data: &[u8]) -> String {
    let mut text = String::new();
    let mut bytes = data.iter().map(|byte| usize::from(*byte));
    while let Some(byte) = bytes.next() {
        let (header, keys) = tables[byte % tables.len()];
        // Writing to a `String` can't fail.
        let _ = writeln!(text, "\n{header}");
        for (key, values) in keys {
            match bytes.next().unwrap_or(0) {
                0..64 => {}
                250.. => text.push_str("# ä = \"\u{202e}\r\n"),
                choice if choice % 3 > 0 => _ = writeln!(text, "{key} = {}", values[0]),
                choice => _ = writeln!(text, "{key} = {}", values[choice / 3 % values.len()]),
            }
        }
    }
    text
}
