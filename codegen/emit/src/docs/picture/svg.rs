//! Small SVG files without external resources.
//!
//! The background is transparent. Text outside boxes is grey, which is legible on light and dark pages. Each box has a
//! background colour.

use std::fmt;

use uavspec_schema::prose;
use uavspec_schema::wording::{plural, thousands};

use super::grid::{Cell, Grid, Line, ROW, Segment, Tint};
use crate::docs::markdown::{append, notice};

/// Width of the row offsets, left of the boxes.
const LEFT: usize = 44;
/// Width of a byte, which is enough for fifteen letters.
const BYTE: usize = 88;
/// Height of the column numbers.
const TOP: usize = 18;
/// Heights of a break with torn edges, and of a break within a box.
const OPEN_BREAK: usize = 30;
const INNER_BREAK: usize = 14;
/// Height of a labelled row without the lines of the name.
const ROW_HEAD: usize = 17;
/// Height of a row without a label.
const ROW_PLAIN: usize = 15;
/// Height of one line of a name.
const LINE: usize = 11;
/// Height of the torn edge below a row.
const TORN: usize = 4;
/// Maximum number of lines of a name.
const MAX_NAME_LINES: usize = 4;
/// Height of the legend.
const BOTTOM: usize = 30;
/// Width of a letter in a name, in tenths of a pixel: at the default size, and at the large size.
const LETTER: usize = 53;
const WIDE_LETTER: usize = 68;
/// Margin between the edge of a box and its text.
const INSET: usize = 4;

const STYLE: &str = "text{font:9px ui-monospace,SFMono-Regular,Menlo,Consolas,'Liberation Mono',monospace;fill:#1f2328}\
.w{font-size:11px}\
.s{font-size:8px;fill:#1f2328;fill-opacity:.72}\
.o{font-size:9px;fill:#777c82}\
.b{stroke:#6a737d;stroke-width:.75}\
.d{stroke:#1f2328;stroke-opacity:.22;stroke-width:.75;fill:none}";

/// Colours and legend texts of the tints.
const TINTS: [(Tint, &str, &str); 6] = [
    (Tint::Eight, "#a9c9f7", "8 bytes"),
    (Tint::Four, "#a6dfb5", "4 bytes"),
    (Tint::Two, "#f3df8f", "2 bytes"),
    (Tint::One, "#f6c3a0", "1 byte"),
    (Tint::Nested, "#d6c0f2", "message"),
    (Tint::Padding, "url(#p)", "padding"),
];

/// Draws the layout of the message `name`.
pub(super) fn draw(grid: &Grid<'_>, name: &str, caption: &str) -> String {
    let names: Vec<Name<'_>> = grid.cells.iter().map(Name::of).collect();
    let rows = Rows::new(grid, &names);
    let mut svg = Svg::default();
    let (width, height) = (LEFT + ROW * BYTE + INSET, rows.bottom() + BOTTOM);
    svg.put(format_args!(
        "<!-- {} -->\n<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" role=\"img\">\n<title>Memory layout of {}: {}</title>\n<style>{STYLE}</style>\n",
        notice(),
        prose::xml(name),
        prose::xml(caption)
    ));
    svg.put(format_args!(
        "<pattern id=\"p\" width=\"6\" height=\"6\" patternUnits=\"userSpaceOnUse\">\
         <path fill=\"#d8dce1\" d=\"M0 0h6v6H0z\"/><path stroke=\"#b4bbc3\" d=\"M-1 1l2-2M0 6l6-6M5 7l2-2\"/></pattern>\n"
    ));
    svg.rulers(grid, &rows);
    for (tint, colour, _) in TINTS {
        let cells: Vec<(&Cell<'_>, &Name<'_>)> =
            grid.cells.iter().zip(&names).filter(|(cell, _)| cell.member.tint == tint).collect();
        if !cells.is_empty() {
            svg.put(format_args!("<g fill=\"{colour}\">\n"));
            for (cell, name) in cells {
                svg.cell(cell, name, &rows);
            }
            svg.put(format_args!("</g>\n"));
        }
    }
    svg.breaks(grid, &rows);
    svg.legend(grid, caption, height - 10);
    svg.put(format_args!("</svg>\n"));
    svg.0
}

/// A name split into lines.
#[derive(Debug, PartialEq, Eq)]
struct Name<'s> {
    lines: Vec<&'s str>,
    /// True if the name is truncated.
    is_cut: bool,
}

impl<'s> Name<'s> {
    /// Splits the name of a cell into lines that fit into it.
    fn of(cell: &Cell<'s>) -> Self {
        let width = cell.label().map_or(0, |segment| segment.columns.len() * BYTE - 2 * INSET);
        Self::wrapped(&cell.member.slot.name, width * 10 / LETTER)
    }

    /// Splits a name into lines of at most `room` letters, preferably after underscores.
    fn wrapped(name: &'s str, room: usize) -> Self {
        let end =
            |text: &str, letters: usize| text.char_indices().nth(letters).map_or(text.len(), |(at, _)| at);
        let mut lines = Vec::new();
        let mut rest = name;
        while end(rest, room) < rest.len() && lines.len() + 1 < MAX_NAME_LINES {
            let limit = end(rest, room);
            let cut = rest[..limit].rfind('_').map_or(limit, |at| at + 1);
            lines.push(&rest[..cut]);
            rest = &rest[cut..];
        }
        let is_cut = end(rest, room) < rest.len();
        let last = if is_cut { &rest[..end(rest, room.saturating_sub(1))] } else { rest };
        lines.push(last);
        Self { lines, is_cut }
    }
}

/// Vertical positions of the lines.
struct Rows {
    tops: Vec<usize>,
}

impl Rows {
    fn new(grid: &Grid<'_>, names: &[Name<'_>]) -> Self {
        let mut heights: Vec<usize> = grid
            .lines
            .iter()
            .map(|line| match line {
                Line::Row(_) => ROW_PLAIN,
                Line::Break { is_torn: true, .. } => OPEN_BREAK,
                Line::Break { is_torn: false, .. } => INNER_BREAK,
            })
            .collect();
        for (cell, name) in grid.cells.iter().zip(names) {
            if let Some(segment) = cell.label() {
                heights[segment.line] = heights[segment.line].max(ROW_HEAD + LINE * name.lines.len());
            }
        }
        for (index, line) in grid.lines.iter().enumerate().skip(1) {
            if matches!(line, Line::Break { is_torn: true, .. }) {
                heights[index - 1] += TORN;
            }
        }
        let mut top = TOP;
        let mut tops = vec![top];
        for height in heights {
            top += height;
            tops.push(top);
        }
        Self { tops }
    }

    fn top(&self, line: usize) -> usize {
        self.tops[line]
    }

    fn below(&self, line: usize) -> usize {
        self.tops[line + 1]
    }

    fn bottom(&self) -> usize {
        self.tops.last().copied().unwrap_or(TOP)
    }
}

fn x(column: usize) -> usize {
    LEFT + column * BYTE
}

#[derive(Default)]
struct Svg(String);

impl Svg {
    fn put(&mut self, text: fmt::Arguments<'_>) {
        append(&mut self.0, text);
    }

    /// Writes the column numbers and the row offsets.
    fn rulers(&mut self, grid: &Grid<'_>, rows: &Rows) {
        for column in 0..ROW {
            let middle = x(column) + BYTE / 2;
            self.put(format_args!(
                "<text class=\"o\" text-anchor=\"middle\" x=\"{middle}\" y=\"12\">+{column}</text>\n"
            ));
        }
        for (index, line) in grid.lines.iter().enumerate() {
            if let Line::Row(start) = line {
                let (right, y) = (LEFT - 6, rows.top(index) + 12);
                self.put(format_args!(
                    "<text class=\"o\" text-anchor=\"end\" x=\"{right}\" y=\"{y}\">{start}</text>\n"
                ));
            }
        }
    }

    /// Writes the number of omitted bytes in each break.
    fn breaks(&mut self, grid: &Grid<'_>, rows: &Rows) {
        for (index, line) in grid.lines.iter().enumerate() {
            let Line::Break { bytes, is_torn } = line else { continue };
            // Inside a box, the text of a break is on the box colour. At a torn break, the text is on the page
            // background.
            let class = if *is_torn { "o" } else { "s" };
            let y = usize::midpoint(rows.top(index), rows.below(index)) + 3;
            self.put(format_args!(
                "<text class=\"{class}\" text-anchor=\"middle\" x=\"{}\" y=\"{y}\">… {} more …</text>\n",
                x(ROW / 2),
                plural(bytes.len() as u64, "byte")
            ));
        }
    }

    fn cell(&mut self, cell: &Cell<'_>, name: &Name<'_>, rows: &Rows) {
        let slot = cell.member.slot;
        let unit = cell.member.unit.map(|unit| format!(" [{unit}]")).unwrap_or_default();
        self.put(format_args!(
            "<g><title>{} {}{}: {} at {}</title>",
            prose::xml(&slot.type_text),
            prose::xml(&slot.name),
            prose::xml(&unit),
            plural(slot.size as u64, "byte"),
            thousands(slot.offset as u64)
        ));
        self.outline(cell, rows);
        self.dividers(cell, rows);
        if let Some(segment) = cell.label() {
            self.label(cell, segment, name, rows);
        }
        if let [above, below] = cell.segments.as_slice()
            && !touch(above, below)
        {
            let other = if cell.label() == Some(above) { below } else { above };
            self.echo(&slot.name, other, rows);
        }
        self.put(format_args!("</g>\n"));
    }

    fn label(&mut self, cell: &Cell<'_>, segment: &Segment, name: &Name<'_>, rows: &Rows) {
        let slot = cell.member.slot;
        let (left, right) = (x(segment.columns.start) + INSET, x(segment.columns.end) - INSET);
        let top = rows.top(segment.line);
        let element = match cell.member.element_size {
            size if cell.member.tint == Tint::Nested && size < slot.size => {
                format!(", {} each", plural(size as u64, "byte"))
            }
            _ => String::new(),
        };
        self.put(format_args!(
            "<text class=\"s\" x=\"{left}\" y=\"{y}\">{}</text><text class=\"s\" text-anchor=\"end\" x=\"{right}\" y=\"{y}\">{}{element}</text>",
            slot.offset,
            prose::xml(&slot.type_text),
            y = top + 10,
        ));
        let is_wide =
            segment.columns.len() > 1 && slot.name.chars().count() * WIDE_LETTER < 10 * (right - left);
        let class = if is_wide { " class=\"w\"" } else { "" };
        self.put(format_args!("<text{class} x=\"{left}\" y=\"{}\">", top + ROW_HEAD + 6));
        for (index, line) in name.lines.iter().enumerate() {
            if index == 0 {
                self.put(format_args!("{}", prose::xml(line)));
            } else {
                self.put(format_args!("<tspan x=\"{left}\" dy=\"{LINE}\">{}</tspan>", prose::xml(line)));
            }
        }
        self.put(format_args!("{}</text>", if name.is_cut { "…" } else { "" }));
    }

    /// Repeats the name in a segment that doesn't touch the labelled segment.
    fn echo(&mut self, name: &str, segment: &Segment, rows: &Rows) {
        let room = (segment.columns.len() * BYTE - 2 * INSET) * 10 / LETTER;
        if name.chars().count() + 2 <= room {
            let (left, top) = (x(segment.columns.start) + INSET, rows.top(segment.line));
            self.put(format_args!(
                "<text class=\"s\" x=\"{left}\" y=\"{}\">… {}</text>",
                top + 10,
                prose::xml(name)
            ));
        }
    }

    /// Draws the outline of a cell. Torn breaks divide the outline into several polygons.
    fn outline(&mut self, cell: &Cell<'_>, rows: &Rows) {
        let step = if cell.member.tint == Tint::Nested { 2 } else { 1 };
        let belong =
            |above: &Segment, below: &Segment| above.line + step >= below.line && touch(above, below);
        self.put(format_args!("<path class=\"b\" d=\""));
        let mut runs = cell.segments.chunk_by(belong).peekable();
        let mut is_torn_above = false;
        while let Some(run) = runs.next() {
            let is_torn_below = runs.peek().is_some_and(|next| is_interrupted(run, next));
            self.polygon(run, rows, is_torn_above, is_torn_below);
            is_torn_above = is_torn_below;
        }
        self.put(format_args!("\"/>"));
    }

    /// Draws a run of segments. Only the first segment may start in the middle of a line, and only the last segment may
    /// end in the middle of a line.
    fn polygon(&mut self, run: &[Segment], rows: &Rows, is_torn_above: bool, is_torn_below: bool) {
        let (Some(first), Some(last)) = (run.first(), run.last()) else { return };
        let (top, bottom) = (rows.top(first.line), rows.below(last.line));
        let (left, right) = (x(first.columns.start), x(first.columns.end));
        let (last_left, last_right) = (x(last.columns.start), x(last.columns.end));
        self.put(format_args!("M{left} {top}"));
        if is_torn_above {
            self.wave(right - left, 1);
        } else {
            self.put(format_args!("H{right}"));
        }
        if last_right < right {
            self.put(format_args!("V{}H{last_right}", rows.top(last.line)));
        }
        self.put(format_args!("V{bottom}"));
        if is_torn_below {
            self.wave(last_right - last_left, -1);
        } else {
            self.put(format_args!("H{last_left}"));
        }
        if last_left < left {
            self.put(format_args!("V{}H{left}", rows.below(first.line)));
        }
        self.put(format_args!("z"));
    }

    /// Draws a torn edge, either from left to right or from right to left.
    fn wave(&mut self, width: usize, direction: isize) {
        const HALF: usize = 22;
        let step = direction * 22;
        self.put(format_args!("q{} {} {step} 0", step / 2, 6 * direction));
        for _ in 1..width / HALF {
            self.put(format_args!("t{step} 0"));
        }
    }

    /// Draws thin lines between the elements of an array.
    fn dividers(&mut self, cell: &Cell<'_>, rows: &Rows) {
        // Scalars are sorted by size, so no element spans two rows. Elements of nested messages are not drawn.
        let size = cell.member.element_size;
        if size == 0 || size > ROW || size >= cell.member.slot.size || cell.member.tint == Tint::Nested {
            return;
        }
        let mut path = String::new();
        for (index, segment) in cell.segments.iter().enumerate() {
            let top = rows.top(segment.line);
            let height = rows.below(segment.line) - top;
            for column in segment.columns.clone().skip(1).filter(|column| column.is_multiple_of(size)) {
                append(&mut path, format_args!("M{} {top}v{height}", x(column)));
            }
            let above = index.checked_sub(1).and_then(|above| cell.segments.get(above));
            if above.is_some_and(|above| above.line + 1 == segment.line && touch(above, segment)) {
                let left = x(segment.columns.start.max(above.map_or(0, |above| above.columns.start)));
                append(&mut path, format_args!("M{left} {top}H{}", x(segment.columns.end)));
            }
        }
        if !path.is_empty() {
            self.put(format_args!("<path class=\"d\" d=\"{path}\"/>"));
        }
    }

    fn legend(&mut self, grid: &Grid<'_>, caption: &str, y: usize) {
        let mut left = LEFT;
        for (tint, colour, text) in TINTS {
            if !grid.cells.iter().any(|cell| cell.member.tint == tint) {
                continue;
            }
            self.put(format_args!(
                "<path class=\"b\" fill=\"{colour}\" d=\"M{left} {}h10v10h-10z\"/><text class=\"o\" x=\"{}\" y=\"{y}\">{text}</text>\n",
                y - 8,
                left + 14,
            ));
            left += 30 + text.len() * 6;
        }
        self.put(format_args!(
            "<text class=\"o\" text-anchor=\"end\" x=\"{}\" y=\"{y}\">{}</text>\n",
            x(ROW),
            prose::xml(caption)
        ));
    }
}

/// True if two segments on adjacent lines touch.
fn touch(above: &Segment, below: &Segment) -> bool {
    above.columns.start < below.columns.end
}

/// True if a break separates two runs of a member's segments.
fn is_interrupted(run: &[Segment], next: &[Segment]) -> bool {
    matches!((run.last(), next.first()), (Some(last), Some(first)) if last.line + 1 < first.line)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn breaks_names_after_underscores() {
        let wrapped = |name, room| Name::wrapped(name, room).lines;
        assert_eq!(wrapped("local_position_invalid_relaxed", 15), ["local_position_", "invalid_relaxed"]);
        assert_eq!(wrapped("short", 15), ["short"]);
        assert_eq!(wrapped("abcdefgh", 3), ["abc", "def", "gh"]);
        let cut = Name::wrapped("a_b_c_d_e_f", 2);
        assert_eq!(cut, Name { lines: vec!["a_", "b_", "c_", "d"], is_cut: true });
        assert_eq!(Name::wrapped("ab", 0), Name { lines: vec!["", "", "", ""], is_cut: true });
    }
}
