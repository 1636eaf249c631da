//! Where in a message something is: `events[2].id`.

use core::fmt;

use crate::descriptor::{Element, MessageDescriptor};

/// How deep a path goes; what lies deeper is left out of it.
const DEPTH: usize = 8;

/// The way from a message to a value in it. Shown as `events[2].id`; the name of the message where it
/// is the message itself.
#[derive(Clone, Copy)]
pub struct Path {
    message: &'static MessageDescriptor,
    /// From the outermost field inwards.
    steps: [Step; DEPTH],
    len: u8,
    /// The element of the field that comes before all steps so far.
    element: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Step {
    field: u16,
    element: u32,
}

/// Stands for no element.
const NONE: u32 = u32::MAX;

/// The way to a message that isn't known yet.
impl Default for Path {
    fn default() -> Self {
        Self::to(&MessageDescriptor::NONE)
    }
}

/// Equal are ways through messages of one name by the same fields and elements.
impl PartialEq for Path {
    fn eq(&self, other: &Self) -> bool {
        self.message.name == other.message.name
            && self.element == other.element
            && self.len == other.len
            && self.steps() == other.steps()
    }
}

impl Path {
    /// The steps so far; behind them may be those of a way that was left.
    fn steps(&self) -> &[Step] {
        &self.steps[..usize::from(self.len).min(DEPTH)]
    }

    /// The way to the message itself.
    pub(crate) const fn to(message: &'static MessageDescriptor) -> Self {
        Self { message, steps: [Step { field: 0, element: NONE }; DEPTH], len: 0, element: NONE }
    }

    /// Goes on to a field.
    pub(crate) fn enter(&mut self, field: usize) {
        if let Some(step) = self.steps.get_mut(usize::from(self.len)) {
            *step = Step { field: u16::try_from(field).unwrap_or(u16::MAX), element: NONE };
        }
        self.len = self.len.saturating_add(1);
    }

    /// Goes on to an element of the field, or back to the field.
    pub(crate) fn select(&mut self, element: Option<usize>) {
        if let Some(step) = self.len.checked_sub(1).and_then(|last| self.steps.get_mut(usize::from(last))) {
            step.element = element.map_or(NONE, number);
        }
    }

    /// Goes back to the message that the field is of.
    pub(crate) fn leave(&mut self) {
        self.len = self.len.saturating_sub(1);
    }

    /// Makes the way so far one from an element of a field, which [`enclose`](Self::enclose) then names.
    pub(crate) fn within(&mut self, element: usize) {
        self.element = number(element);
    }

    /// Makes the way so far one from a field of the message `outer`.
    pub(crate) fn enclose(&mut self, outer: &'static MessageDescriptor, field: usize) {
        self.steps.copy_within(..DEPTH - 1, 1);
        self.steps[0] = Step { field: u16::try_from(field).unwrap_or(u16::MAX), element: self.element };
        self.message = outer;
        self.len = self.len.saturating_add(1);
        self.element = NONE;
    }
}

fn number(element: usize) -> u32 {
    u32::try_from(element).unwrap_or(NONE)
}

impl fmt::Display for Path {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.len == 0 {
            return formatter.write_str(self.message.name);
        }
        let mut message = self.message;
        for (depth, step) in self.steps().iter().enumerate() {
            let Some(field) = message.fields.get(usize::from(step.field)) else { break };
            let dot = if depth == 0 { "" } else { "." };
            write!(formatter, "{dot}{}", field.name)?;
            if step.element != NONE {
                write!(formatter, "[{}]", step.element)?;
            }
            if let Element::Message(nested) = field.element {
                message = nested;
            }
        }
        if usize::from(self.len) > DEPTH { formatter.write_str(".…") } else { Ok(()) }
    }
}

impl fmt::Debug for Path {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: {self}", self.message.name)
    }
}
