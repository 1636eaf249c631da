//! Lines of a page.

/// The text up to the end of its last line that isn't blank.
pub(in crate::format) fn without_blank_end(text: &str) -> &str {
    let end = text.trim_end_matches([' ', '\t', '\r', '\n']).len();
    let line = text[end..].find(['\r', '\n']).map_or(text.len(), |len| end + len);
    if end == 0 { "" } else { &text[..line] }
}

/// The line without white space at its end, unless that says something: after a backslash, that the line doesn't
/// break there; after three dashes, that they enclose no front matter.
pub(super) fn trimmed(line: &str) -> &str {
    let trimmed = line.trim_end_matches([' ', '\t']);
    if trimmed.ends_with('\\') || trimmed == "---" { line } else { trimmed }
}

/// Where each line starts.
pub(super) fn line_starts(text: &str) -> Vec<usize> {
    std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect()
}

/// The line, from 0, that holds the position `at`.
pub(super) fn line_of(starts: &[usize], at: usize) -> usize {
    starts.partition_point(|start| *start <= at).saturating_sub(1)
}
