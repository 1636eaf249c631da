//! Texts from grammars. Random bytes are rarely valid, so a reader would only see the first error.

use std::slice::Iter;

/// The depth from which on the first alternative is used.
const MAX_DEPTH: usize = 12;

/// The maximum length of a text, in bytes.
const MAX_TEXT: usize = 20_000;

/// The alternatives by name. The first name is the start. In an alternative, a text with this name replaces `<name>`.
/// The first alternative of each name must end.
pub(super) struct Grammar(pub &'static [(&'static str, &'static [&'static str])]);

impl Grammar {
    /// The text that the bytes select. Each byte selects an alternative.
    pub(super) fn text(&self, data: &[u8]) -> String {
        let mut text = String::new();
        let (start, _) = self.0[0];
        self.expand(start, 0, &mut data.iter(), &mut text);
        text
    }

    fn expand(&self, name: &str, depth: usize, choices: &mut Iter<'_, u8>, text: &mut String) {
        let Some((_, alternatives)) = self.0.iter().find(|(known, _)| *known == name) else {
            panic!("unknown name: {name}")
        };
        let is_open = depth < MAX_DEPTH && text.len() < MAX_TEXT;
        let choice = choices.next().filter(|_| is_open).map_or(0, |choice| usize::from(*choice));
        let mut rest = alternatives[choice % alternatives.len()];
        while let Some((plain, (inner, after))) =
            rest.split_once('<').and_then(|(plain, rest)| Some((plain, rest.split_once('>')?)))
        {
            text.push_str(plain);
            self.expand(inner, depth + 1, choices, text);
            rest = after;
        }
        text.push_str(rest);
    }
}

/// Bytes that select different alternatives.
pub(super) fn seeds() -> Vec<Vec<u8>> {
    // The steps have no common factor with the usual numbers of alternatives.
    (0..40_u8)
        .map(|seed| {
            (0..60_u8).map(|at| seed.wrapping_mul(101).wrapping_add(at.wrapping_mul(37 + seed))).collect()
        })
        .collect()
}
