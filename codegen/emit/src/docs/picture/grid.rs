//! Arrangement of the bytes of a layout in rows of eight. The middle of long fields is omitted.

use std::ops::Range;

use uavspec_schema::Slot;

/// Number of bytes per row, which is also the maximum alignment of a layout.
pub(super) const ROW: usize = 8;

/// If a scalar field fills more than `MAX_ROWS + 1` complete rows, only the first and the last of these rows are drawn.
const MAX_ROWS: usize = 7;

/// Maximum number of lines of a picture. The longest PX4 message needs fewer than 100 lines.
const MAX_LINES: usize = 256;

/// The colour of a box, which depends on the element size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Tint {
    Eight,
    Four,
    Two,
    One,
    Nested,
    Padding,
}

impl Tint {
    /// The colour of a scalar of `size` bytes.
    pub(super) fn of_scalar(size: usize) -> Self {
        match size {
            8 => Self::Eight,
            4 => Self::Four,
            2 => Self::Two,
            _ => Self::One,
        }
    }
}

/// A slot of the layout, with the properties needed to draw it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Member<'s> {
    pub(super) slot: &'s Slot,
    pub(super) tint: Tint,
    pub(super) element_size: usize,
    pub(super) unit: Option<&'s str>,
}

impl Member<'_> {
    fn bytes(&self) -> Range<usize> {
        self.slot.offset..self.slot.offset.saturating_add(self.slot.size)
    }

    /// Rows filled by this member alone.
    fn whole_rows(&self) -> Range<usize> {
        let bytes = self.bytes();
        bytes.start.div_ceil(ROW)..bytes.end / ROW
    }

    /// Rows that are not drawn.
    fn hidden_rows(&self) -> Range<usize> {
        let whole = self.whole_rows();
        let max = if self.tint == Tint::Nested { 2 } else { MAX_ROWS };
        if whole.len() > max + 1 { whole.start + 1..whole.end - 1 } else { 0..0 }
    }
}

/// A line of the picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Line {
    /// A row of bytes that starts at this offset.
    Row(usize),
    /// A gap that replaces omitted bytes.
    Break {
        /// The omitted bytes.
        bytes: Range<usize>,
        /// True if the gap has torn edges. A gap in a nested message has no torn edges, because another page shows the
        /// fields of the nested message.
        is_torn: bool,
    },
}

impl Line {
    fn bytes(&self) -> Range<usize> {
        match self {
            Self::Row(start) => *start..start + ROW,
            Self::Break { bytes, .. } => bytes.clone(),
        }
    }
}

/// The bytes of one member that are on the same line of the picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Segment {
    /// Index of the line.
    pub(super) line: usize,
    /// Bytes, relative to the start of the line.
    pub(super) columns: Range<usize>,
}

/// A member with its drawn segments.
#[derive(Clone, Debug)]
pub(super) struct Cell<'s> {
    pub(super) member: Member<'s>,
    /// Segments in line order.
    pub(super) segments: Vec<Segment>,
}

impl Cell<'_> {
    /// The segment that contains the name: the first segment, or the second one if it is wider.
    pub(super) fn label(&self) -> Option<&Segment> {
        self.segments
            .iter()
            .take(2)
            .reduce(|first, second| if second.columns.len() > first.columns.len() { second } else { first })
    }
}

/// The arranged picture.
#[derive(Clone, Debug)]
pub(super) struct Grid<'s> {
    pub(super) lines: Vec<Line>,
    pub(super) cells: Vec<Cell<'s>>,
}

impl<'s> Grid<'s> {
    /// Arranges members. The members must be sorted by offset and fill `size` bytes.
    pub(super) fn new(members: &[Member<'s>], size: usize) -> Self {
        let lines = lines(members, size);
        let cells = cells(members, &lines);
        Self { lines, cells }
    }
}

fn lines(members: &[Member<'_>], size: usize) -> Vec<Line> {
    let mut lines = Vec::new();
    let mut row = 0;
    for member in members {
        let hidden = member.hidden_rows();
        if !hidden.is_empty() {
            lines.extend((row..hidden.start).map(|row| Line::Row(row * ROW)));
            let is_torn = member.tint != Tint::Nested;
            lines.push(Line::Break { bytes: hidden.start * ROW..hidden.end * ROW, is_torn });
            row = hidden.end;
        }
    }
    lines.extend((row..size / ROW).map(|row| Line::Row(row * ROW)));
    shortened(lines)
}

/// If there are too many lines, omits the lines in the middle.
fn shortened(mut lines: Vec<Line>) -> Vec<Line> {
    if lines.len() <= MAX_LINES {
        return lines;
    }
    let tail = lines.split_off(lines.len() - MAX_LINES / 4);
    lines.truncate(MAX_LINES - MAX_LINES / 4);
    let hidden =
        lines.last().map_or(0, |line| line.bytes().end)..tail.first().map_or(0, |line| line.bytes().start);
    lines.push(Line::Break { bytes: hidden, is_torn: true });
    lines.extend(tail);
    lines
}

/// The drawn segments of each member. Members and lines are both sorted by offset, so one pass suffices.
fn cells<'s>(members: &[Member<'s>], lines: &[Line]) -> Vec<Cell<'s>> {
    let mut cells = Vec::with_capacity(members.len());
    let mut first = 0;
    for member in members {
        let bytes = member.bytes();
        while lines.get(first).is_some_and(|line| line.bytes().end <= bytes.start) {
            first += 1;
        }
        let segments: Vec<Segment> = lines[first..]
            .iter()
            .enumerate()
            .take_while(|(_, line)| line.bytes().start < bytes.end)
            .filter_map(|(index, line)| match line {
                Line::Row(start) => {
                    let columns = bytes.start.max(*start) - start..bytes.end.min(start + ROW) - start;
                    Some(Segment { line: first + index, columns })
                }
                Line::Break { .. } => None,
            })
            .collect();
        if !segments.is_empty() {
            cells.push(Cell { member: *member, segments });
        }
    }
    cells
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slots(sizes: &[usize]) -> Vec<Slot> {
        let mut offset = 0;
        let slot = |size: &usize| {
            let slot = Slot { field: Some(0), name: "x".into(), type_text: "t".into(), offset, size: *size };
            offset += size;
            slot
        };
        sizes.iter().map(slot).collect()
    }

    fn grid(slots: &[Slot]) -> Grid<'_> {
        let members: Vec<Member<'_>> =
            slots.iter().map(|slot| Member { slot, tint: Tint::One, element_size: 1, unit: None }).collect();
        Grid::new(&members, slots.iter().map(|slot| slot.size).sum())
    }

    #[test]
    fn splits_members_into_rows() {
        let slots = slots(&[4, 8, 4]);
        let grid = grid(&slots);
        assert_eq!(grid.lines, [Line::Row(0), Line::Row(8)]);
        let columns: Vec<(usize, Range<usize>)> = grid
            .cells
            .iter()
            .enumerate()
            .flat_map(|(cell, found)| {
                found.segments.iter().map(move |segment| (cell, segment.columns.clone()))
            })
            .collect();
        assert_eq!(columns, [(0, 0..4), (1, 4..8), (1, 0..4), (2, 4..8)]);
    }

    #[test]
    fn omits_the_middle_of_a_long_member() {
        let slots = slots(&[4, 1004, 8]);
        let grid = grid(&slots);
        let gap = Line::Break { bytes: 16..1000, is_torn: true };
        assert_eq!(grid.lines, [Line::Row(0), Line::Row(8), gap, Line::Row(1000), Line::Row(1008)]);
        assert_eq!(grid.cells[1].segments.len(), 3);
    }

    #[test]
    fn omits_the_middle_of_a_long_layout() {
        let slots = slots(&vec![8; 100_000]);
        let grid = grid(&slots);
        assert_eq!(grid.lines.len(), MAX_LINES + 1);
        assert_eq!(grid.cells.len(), MAX_LINES);
        assert_eq!(grid.lines.last(), Some(&Line::Row(799_992)));
    }
}
