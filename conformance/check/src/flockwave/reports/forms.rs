//! Reads texts that differ from an earlier text only in their values.
//!
//! A program writes all its messages in the same form: the text between the values stays the same. If the form is
//! known, only the values need a tokenizer. This takes a fraction of the time.

use std::ops::Range;

/// The maximum number of forms. For a program that writes more forms, this method has no benefit.
const MAX_FORMS: usize = 8;

/// The maximum length of the text of a form without its values, in bytes.
const MAX_TEXT: usize = 4_096;

/// The known forms, each with the properties `P` that all its texts share.
#[derive(Debug)]
pub(super) struct Forms<V, P>(Vec<(Form<V>, P)>);

/// The values of a text, and the text between them.
#[derive(Debug)]
struct Form<V> {
    /// The values, each with the text before it.
    values: Vec<(Box<str>, V)>,
    /// The text after the last value.
    end: Box<str>,
}

impl<V, P> Default for Forms<V, P> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<V, P: Copy> Forms<V, P> {
    /// Reads a known form at the start of a text. `value` reads a value at the start of a text, and returns its length.
    /// If the first forms don't match, `value` is called again for the values of another form, and must then replace
    /// what it has stored. Returns the length of the text in this form, and the properties.
    #[inline]
    pub(super) fn read<'t>(
        &self,
        text: &'t str,
        mut value: impl FnMut(&V, &'t str) -> Option<usize>,
    ) -> Option<(usize, P)> {
        self.0.iter().find_map(|(form, properties)| Some((form.length(text, &mut value)?, *properties)))
    }

    /// Adds the form of a text, whose values have these positions.
    pub(super) fn learn(
        &mut self,
        text: &str,
        values: impl Iterator<Item = (Range<usize>, V)>,
        properties: P,
    ) {
        if self.0.len() == MAX_FORMS {
            return;
        }
        let (mut from, mut length) = (0, text.len());
        let values = values.map(|(range, value)| {
            let before = text[from..range.start].into();
            from = range.end;
            length -= range.len();
            (before, value)
        });
        let values = values.collect();
        if length <= MAX_TEXT {
            self.0.push((Form { values, end: text[from..].into() }, properties));
        }
    }
}

impl<V> Form<V> {
    /// The length of the text that has this form, at the start of `text`.
    #[inline]
    fn length<'t>(
        &self,
        text: &'t str,
        value: &mut impl FnMut(&V, &'t str) -> Option<usize>,
    ) -> Option<usize> {
        let mut rest = text;
        for (before, kind) in &self.values {
            rest = without_start(rest, before)?;
            let length = value(kind, rest)?;
            rest = rest.get(length..)?;
        }
        let rest = without_start(rest, &self.end)?;
        Some(text.len() - rest.len())
    }
}

/// The rest of a text after `start`. Most starts are a comma, for which comparing the bytes is faster than a call.
#[inline]
fn without_start<'t>(text: &'t str, start: &str) -> Option<&'t str> {
    match (start.as_bytes(), text.as_bytes().first()) {
        ([one], Some(first)) if one == first => text.get(1..),
        ([_], _) => None,
        _ => text.strip_prefix(start),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Learns the form of a text in which the digits are values.
    fn learn(forms: &mut Forms<(), usize>, text: &str, properties: usize) {
        let digits = text.char_indices().filter(|(_, character)| character.is_ascii_digit());
        forms.learn(text, digits.map(|(at, _)| (at..at + 1, ())), properties);
    }

    fn read(forms: &Forms<(), usize>, text: &str) -> Option<(usize, usize)> {
        forms.read(text, |(), rest| rest.starts_with(|first: char| first.is_ascii_digit()).then_some(1))
    }

    #[test]
    fn only_values_may_differ() {
        let mut forms = Forms::default();
        assert_eq!(read(&forms, "a1,2é"), None);
        learn(&mut forms, "a1,2é", 7);
        assert_eq!(read(&forms, "a3,4é, more"), Some(("a3,4é".len(), 7)));
        for other in ["", "a3", "a3,4", "a3,4e", "a3;4é", "b3,4é", "a3,xé", "a3,,4é"] {
            assert_eq!(read(&forms, other), None, "{other}");
        }
    }

    #[test]
    fn each_form_has_its_properties() {
        let mut forms = Forms::default();
        let text = |number: usize| format!("{}0", "é".repeat(number));
        for number in 0..MAX_FORMS + 2 {
            learn(&mut forms, &text(number), number);
        }
        learn(&mut forms, &"x".repeat(MAX_TEXT + 1), 0);
        for number in (0..MAX_FORMS + 2).rev() {
            let found = (number < MAX_FORMS).then(|| (text(number).len(), number));
            assert_eq!(read(&forms, &text(number)), found);
        }
    }
}
