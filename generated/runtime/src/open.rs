//! How values of enums and flags are shown.

use core::fmt;

/// Writes an open enum: the name of its value, or its type and number where that is unknown.
pub fn fmt_enum(
    formatter: &mut fmt::Formatter<'_>,
    type_name: &str,
    name: Option<&str>,
    value: impl fmt::Debug,
) -> fmt::Result {
    match name {
        Some(name) => formatter.pad(name),
        None => write!(formatter, "{type_name}({value:?})"),
    }
}

/// Writes flags: the names of those that are set between `|`, and what is left as a number.
pub fn fmt_flags(
    formatter: &mut fmt::Formatter<'_>,
    type_name: &str,
    names: impl Iterator<Item = &'static str>,
    unknown: u64,
) -> fmt::Result {
    write!(formatter, "{type_name}(")?;
    let mut separator = "";
    for name in names {
        write!(formatter, "{separator}{name}")?;
        separator = " | ";
    }
    if unknown != 0 || separator.is_empty() {
        write!(formatter, "{separator}{unknown:#x}")?;
    }
    formatter.write_str(")")
}
