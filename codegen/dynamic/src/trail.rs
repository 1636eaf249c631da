//! The path to the current value while a message is traversed.

use std::fmt::Write as _;

/// The path from a message to one of its values.
#[derive(Debug, Default)]
pub(super) struct Trail<'t> {
    /// Field names and element indexes, from the outermost field inwards.
    steps: Vec<(&'t str, Option<usize>)>,
}

impl<'t> Trail<'t> {
    /// Enters a field.
    pub(super) fn enter(&mut self, field: &'t str) {
        self.steps.push((field, None));
    }

    /// Selects an element of the current field, or the whole field for `None`.
    pub(super) fn select(&mut self, element: Option<usize>) {
        if let Some((_, selected)) = self.steps.last_mut() {
            *selected = element;
        }
    }

    /// Returns to the message that contains the current field.
    pub(super) fn leave(&mut self) {
        self.steps.pop();
    }

    /// Formats the path, such as `events[2].id`. An empty path is formatted as `message`.
    pub(super) fn text(&self, message: &str) -> String {
        if self.steps.is_empty() {
            return message.to_owned();
        }
        let mut text = String::new();
        for (field, element) in &self.steps {
            if !text.is_empty() {
                text.push('.');
            }
            text.push_str(field);
            if let Some(element) = element {
                // Writing to a string can't fail.
                let _ = write!(text, "[{element}]");
            }
        }
        text
    }
}
