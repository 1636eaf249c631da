//! The way to a value while a message is walked through.

use std::fmt::Write as _;

/// The way from a message to a value in it.
#[derive(Debug, Default)]
pub(super) struct Trail<'t> {
    /// From the outermost field inwards.
    steps: Vec<(&'t str, Option<usize>)>,
}

impl<'t> Trail<'t> {
    /// Goes on to a field.
    pub(super) fn enter(&mut self, field: &'t str) {
        self.steps.push((field, None));
    }

    /// Goes on to an element of the field, or back to the field.
    pub(super) fn select(&mut self, element: Option<usize>) {
        if let Some((_, selected)) = self.steps.last_mut() {
            *selected = element;
        }
    }

    /// Goes back to the message that the field is of.
    pub(super) fn leave(&mut self) {
        self.steps.pop();
    }

    /// The way as `events[2].id`; `message` where it leads nowhere else.
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
