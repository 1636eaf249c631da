//! Lines of a page.

/// Removes blank lines at the end of a text.
pub(in crate::format) fn without_trailing_blank_lines(text: &str) -> &str {
    let end = text.trim_end_matches([' ', '\t', '\r', '\n']).len();
    let line = text[end..].find(['\r', '\n']).map_or(text.len(), |len| end + len);
    if end == 0 { "" } else { &text[..line] }
}

/// Removes trailing white space if it is insignificant. White space after a backslash prevents a line break, and white
/// space after `---` prevents front matter.
pub(super) fn trimmed(line: &str) -> &str {
    let trimmed = line.trim_end_matches([' ', '\t']);
    if trimmed.ends_with('\\') || trimmed == "---" { line } else { trimmed }
}

/// The offset of each line.
pub(super) fn line_starts(text: &str) -> Vec<usize> {
    std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect()
}

/// The zero-based number of the line that contains the offset `at`.
pub(super) fn line_of(starts: &[usize], at: usize) -> usize {
    starts.partition_point(|start| *start <= at).saturating_sub(1)
}
