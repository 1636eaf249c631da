//! Which bytes are drawn where: rows of eight bytes, without the insides of long fields.

use std::ops::Range;

use crate::schema::Slot;

/// Bytes in a row: the layout aligns nested messages and its end to as many.
pub(super) const ROW: usize = 8;

/// Whole rows of a field of scalars that are drawn; of longer ones only the first and the last.
const MAX_ROWS: usize = 7;

/// Most rows of a picture. The longest message of PX4 needs under 100.
const MAX_LINES: usize = 256;

/// How a box is coloured: by the size of what it holds.
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
    /// Of a scalar of `size` bytes.
    pub(super) fn of_scalar(size: usize) -> Self {
        match size {
            8 => Self::Eight,
            4 => Self::Four,
            2 => Self::Two,
            _ => Self::One,
        }
    }
}

/// A slot of the layout, and what a picture needs to know of it.
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

    /// Rows that are this member's alone.
    fn whole_rows(&self) -> Range<usize> {
        let bytes = self.bytes();
        bytes.start.div_ceil(ROW)..bytes.end / ROW
    }

    /// Rows that are not drawn.
    fn hidden_rows(&self) -> Range<usize> {
        let whole = self.whole_rows();
        let most = if self.tint == Tint::Nested { 2 } else { MAX_ROWS };
        if whole.len() > most + 1 { whole.start + 1..whole.end - 1 } else { 0..0 }
    }
}

/// A line of the picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Line {
    /// The bytes from this offset on.
    Row(usize),
    /// Something in place of these bytes.
    Break {
        /// What is left out.
        bytes: Range<usize>,
        /// Whether the paper is torn here. A nested message stays whole: its fields are drawn elsewhere.
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

/// The bytes of a member that lie in one line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Segment {
    /// Index of the line.
    pub(super) line: usize,
    /// Bytes, counted from the start of the line.
    pub(super) columns: Range<usize>,
}

/// A member with what is drawn of it.
#[derive(Clone, Debug)]
pub(super) struct Cell<'s> {
    pub(super) member: Member<'s>,
    /// In the order of their lines.
    pub(super) segments: Vec<Segment>,
}

impl Cell<'_> {
    /// The segment that bears the name: the first, unless the second has more room.
    pub(super) fn label(&self) -> Option<&Segment> {
        self.segments
            .iter()
            .take(2)
            .reduce(|first, second| if second.columns.len() > first.columns.len() { second } else { first })
    }
}

/// What is drawn, and where.
#[derive(Clone, Debug)]
pub(super) struct Grid<'s> {
    pub(super) lines: Vec<Line>,
    pub(super) cells: Vec<Cell<'s>>,
}

impl<'s> Grid<'s> {
    /// Arranges members, which are sorted by their offsets and fill `size` bytes.
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

/// The lines without their middle, where there are too many to be looked at.
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

/// What is drawn of each member. Members and lines are both in the order of their bytes, so one walk
/// over both finds all.
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
    fn members_share_rows_and_span_them() {
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
    fn the_inside_of_a_long_member_is_left_out() {
        let slots = slots(&[4, 1004, 8]);
        let grid = grid(&slots);
        let inside = Line::Break { bytes: 16..1000, is_torn: true };
        assert_eq!(grid.lines, [Line::Row(0), Line::Row(8), inside, Line::Row(1000), Line::Row(1008)]);
        assert_eq!(grid.cells[1].segments.len(), 3);
    }

    #[test]
    fn many_members_are_cut_in_the_middle() {
        let slots = slots(&vec![8; 100_000]);
        let grid = grid(&slots);
        assert_eq!(grid.lines.len(), MAX_LINES + 1);
        assert_eq!(grid.cells.len(), MAX_LINES);
        assert_eq!(grid.lines.last(), Some(&Line::Row(799_992)));
    }
}
