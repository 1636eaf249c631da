//! Formatting of `AsciiDoc` pages.

use uavspec_schema::table::asciidoc::has_specifier;
use uavspec_schema::table::{Page, Table, error_code, pipe};

use super::line::{line_of, line_starts, trimmed};

/// Table attributes that change the meaning of pipes and lines.
const OTHER_FORMS: [&str; 2] = ["separator", "format"];

/// Formats a page. `page` was parsed from `text`; `lines` are the lines of `text` without line endings.
pub(super) fn lay_out(text: &str, lines: &[&str], page: &Page) -> String {
    let mut laid_out: Vec<Vec<String>> = lines.iter().map(|line| vec![trimmed(line).to_owned()]).collect();
    let starts = line_starts(text);
    for table in page.tables.iter().filter(|table| is_plain(table)) {
        let fence = line_of(&starts, (table.span.start - page.span.start) as usize);
        let Some((header, rows)) = body(lines, fence, table) else { continue };
        let first = rows.start;
        for line in rows.clone() {
            laid_out[line].clear();
        }
        laid_out[header] = vec![row_line(&cells(lines[header]))];
        let cells: Vec<&str> = rows.flat_map(|line| cells(lines[line])).collect();
        if let Some(start) = laid_out.get_mut(first) {
            // The blank line after the first row makes that row the header.
            start.extend(lines[first].trim().is_empty().then(String::new));
            start.extend(cells.chunks(table.header.len()).map(row_line));
        }
    }
    laid_out.concat().join("\n")
}

/// True if `table` contains error codes and every row has one cell per column.
fn is_plain(table: &Table) -> bool {
    let mut cells = table.header.iter().chain(table.rows.iter().flat_map(|row| &row.cells));
    error_code::code_column(table).is_some()
        && table.rows.iter().all(|row| row.cells.len() == table.header.len())
        && cells.all(|cell| !cell.is_merged)
}

/// The header line and the range of body lines. Returns `None` unless the header is on one line and every nonempty line
/// contains whole cells without specifiers.
fn body(lines: &[&str], fence: usize, table: &Table) -> Option<(usize, std::ops::Range<usize>)> {
    let is_prelude = |line: &&&str| line.trim().is_empty() || line.starts_with(['[', '.', '/']);
    let mut prelude = lines.get(..fence)?.iter().rev().take_while(is_prelude);
    if prelude.any(|line| OTHER_FORMS.iter().any(|form| line.contains(form))) {
        return None;
    }
    let mark = trimmed(lines.get(fence)?);
    let end = fence + 1 + lines[fence + 1..].iter().position(|line| trimmed(line) == mark)?;
    let header = (fence + 1..end).find(|line| !lines[*line].trim().is_empty())?;
    let is_whole = |line: &&str| {
        line.trim().is_empty()
            || (line.starts_with('|') && !has_specifier(line) && !trimmed(line).ends_with(" +"))
    };
    let count = |lines: &[&str]| lines.iter().map(|line| cells(line).len()).sum::<usize>();
    let is_laid_out_by_line = lines[header..end].iter().all(is_whole)
        && cells(lines[header]).len() == table.header.len()
        && count(&lines[header + 1..end]) == table.header.len() * table.rows.len();
    is_laid_out_by_line.then_some((header, header + 1..end))
}

/// The cells that start on this line.
fn cells(line: &str) -> Vec<&str> {
    pipe::split(line).into_iter().skip(1).map(|cell| line[cell].trim()).collect()
}

fn row_line(cells: &[&str]) -> String {
    format!("|{}", cells.join(" |")).trim_end().to_owned()
}
