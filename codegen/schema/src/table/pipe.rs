//! Lines with cells separated by pipes.

use std::ops::Range;

use super::page::Cell;
use super::text::{TextBuilder, trim};
use crate::source::Span;

/// The parts of `line` before, between and after its pipes. A pipe after a backslash is text.
pub fn split(line: &str) -> Vec<Range<usize>> {
    let mut parts = Vec::new();
    let mut start = 0;
    for (at, _) in line.match_indices('|') {
        if !line[..at].ends_with('\\') {
            parts.push(start..at);
            start = at + 1;
        }
    }
    parts.push(start..line.len());
    parts
}

/// The cells of a row. Pipes at the ends of the line are optional.
pub fn cells(line: &str) -> Vec<Range<usize>> {
    let mut parts = split(line);
    let is_empty =
        |part: Option<&Range<usize>>| part.is_some_and(|part| line[part.clone()].trim().is_empty());
    if parts.len() > 1 && is_empty(parts.last()) {
        parts.pop();
    }
    if parts.len() > 1 && is_empty(parts.first()) {
        parts.remove(0);
    }
    parts
}

/// True if `line` separates the header of a table from its rows: `|---|:-:|`.
pub(super) fn is_divider(line: &str) -> bool {
    let is_rule = |cell: &str| {
        let dashes = cell.strip_prefix(':').unwrap_or(cell);
        let dashes = dashes.strip_suffix(':').unwrap_or(dashes);
        !dashes.is_empty() && dashes.bytes().all(|byte| byte == b'-')
    };
    line.contains('|') && cells(line).into_iter().all(|cell| is_rule(line[cell].trim()))
}

/// The cell at `range` of the page `text`. Markup is not interpreted, except escaped pipes.
pub(super) fn plain_cell(text: &str, range: Range<usize>, page: Span) -> Cell {
    let mut builder = TextBuilder::new(page);
    builder.push_unescaped(&text[range.clone()], range.start);
    Cell::new(builder.finish(trim(text, range)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pipes_at_the_ends_of_a_line_are_optional() {
        for line in ["a|b\\|c|d", "|a|b\\|c|d|", "| a | b\\|c | d", "a|b\\|c|d |  "] {
            let cells: Vec<&str> = cells(line).into_iter().map(|cell| line[cell].trim()).collect();
            assert_eq!(cells, ["a", "b\\|c", "d"]);
        }
        assert_eq!(cells("").len(), 1);
        assert_eq!(cells("|").len(), 1);
        assert_eq!(cells("||").len(), 1);
        assert_eq!(cells("| |x|").len(), 2);
    }

    #[test]
    fn dividers() {
        for line in ["---|---|---|", "|:--|--:|", "-|-", " | :-: | - | "] {
            assert!(is_divider(line), "{line}");
        }
        for line in ["---", "|", "||", "", "---|x", "|:|", "|::|", "--- ---|-"] {
            assert!(!is_divider(line), "{line}");
        }
    }
}
