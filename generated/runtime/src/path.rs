//! Paths to values in a message, such as `events[2].id`.

use core::fmt;

use crate::descriptor::{Element, MessageDescriptor};

/// The maximum number of steps in a path. Deeper steps are omitted.
const DEPTH: usize = 8;

/// The path from a message to a value in it. Displayed as `events[2].id`, or as the name of the message if the path has
/// no steps.
#[derive(Clone, Copy)]
pub struct Path {
    message: &'static MessageDescriptor,
    /// The steps, starting with the outermost field.
    steps: [Step; DEPTH],
    len: u8,
    /// The array element that the next call to [`enclose`](Self::enclose) adds to the enclosing field.
    element: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Step {
    field: u16,
    element: u32,
}

/// Marks a step without an element index.
const NONE: u32 = u32::MAX;

/// A path without steps, for a message that is not known yet.
impl Default for Path {
    fn default() -> Self {
        Self::to(&MessageDescriptor::NONE)
    }
}

/// Two paths are equal if they have the same message name and steps.
impl PartialEq for Path {
    fn eq(&self, other: &Self) -> bool {
        self.message.name == other.message.name
            && self.element == other.element
            && self.len == other.len
            && self.steps() == other.steps()
    }
}

impl Path {
    /// The valid steps. The rest of the array may contain stale steps.
    fn steps(&self) -> &[Step] {
        &self.steps[..usize::from(self.len).min(DEPTH)]
    }

    /// The path to the message itself.
    pub(crate) const fn to(message: &'static MessageDescriptor) -> Self {
        Self { message, steps: [Step { field: 0, element: NONE }; DEPTH], len: 0, element: NONE }
    }

    /// Appends a field.
    pub(crate) fn enter(&mut self, field: usize) {
        if let Some(step) = self.steps.get_mut(usize::from(self.len)) {
            *step = Step { field: u16::try_from(field).unwrap_or(u16::MAX), element: NONE };
        }
        self.len = self.len.saturating_add(1);
    }

    /// Selects an element of the last field, or the whole field for `None`.
    pub(crate) fn select(&mut self, element: Option<usize>) {
        if let Some(step) = self.len.checked_sub(1).and_then(|last| self.steps.get_mut(usize::from(last))) {
            step.element = element.map_or(NONE, number);
        }
    }

    /// Removes the last field.
    pub(crate) fn leave(&mut self) {
        self.len = self.len.saturating_sub(1);
    }

    /// Prepends an array element. The next call to [`enclose`](Self::enclose) adds the field of the array.
    pub(crate) fn within(&mut self, element: usize) {
        self.element = number(element);
    }

    /// Prepends a field of the message `outer`.
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

#[cfg(test)]
mod tests {
    use super::{DEPTH, Path};
    use crate::alloc::format;

    fn entered(fields: &[usize]) -> Path {
        let mut path = Path::default();
        for field in fields {
            path.enter(*field);
        }
        path
    }

    #[test]
    fn paths_with_the_same_steps_are_equal() {
        let mut stale = entered(&[3, 4]);
        stale.leave();
        assert_eq!(stale, entered(&[3]));
        let mut element = entered(&[3]);
        element.select(Some(1));
        for other in [entered(&[]), entered(&[4]), entered(&[3, 4]), element] {
            assert_ne!(other, entered(&[3]));
        }
    }

    #[test]
    fn deep_paths_are_shortened() {
        assert!(!format!("{}", entered(&[0; DEPTH])).contains('…'));
        assert!(format!("{}", entered(&[0; DEPTH + 1])).ends_with(".…"));
    }
}
