//! Finds the end of a JSON value, using only brackets and quotation marks.
//!
//! The bytes may arrive in pieces of any length, and may be invalid JSON. Readers of lines or streams can therefore
//! find the next value after an invalid one.

/// A state machine that tracks the bytes of a value.
#[derive(Clone, Copy, Debug, Default)]
pub struct Frame {
    depth: u64,
    state: State,
    /// True if the value ended before the most recent byte.
    is_before: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum State {
    /// Only whitespace so far.
    #[default]
    Fresh,
    /// Between strings.
    Plain,
    /// A number or word outside of brackets.
    Word,
    String,
    /// After a backslash in a string.
    Escape,
}

impl Frame {
    /// The number of bytes that belong to the value, if the value ends within `bytes` or directly before them.
    pub fn end(&mut self, bytes: &[u8]) -> Option<usize> {
        let last = bytes.iter().position(|byte| self.step(*byte))?;
        Some(last + usize::from(!self.is_before))
    }

    /// Tracks the brackets in a text with any number of values. Returns the number of open brackets.
    pub fn follow(&mut self, text: &str) -> u64 {
        for byte in text.bytes() {
            if self.state == State::Word {
                self.state = State::Plain;
            }
            self.step(byte);
        }
        self.depth
    }

    /// Processes the next byte. Returns true if the value ends with or before this byte.
    pub fn step(&mut self, byte: u8) -> bool {
        self.is_before = false;
        match self.state {
            State::String => match byte {
                b'"' => {
                    self.state = State::Plain;
                    self.depth == 0
                }
                b'\\' => self.is_in(State::Escape),
                _ => false,
            },
            State::Escape => self.is_in(State::String),
            State::Word
                if matches!(byte, b' ' | b'\t' | b'\r' | b'\n' | b',' | b']' | b'}' | b'{' | b'[') =>
            {
                self.is_before = true;
                true
            }
            State::Word => false,
            State::Fresh | State::Plain => match byte {
                b' ' | b'\t' | b'\r' | b'\n' => false,
                b'"' => self.is_in(State::String),
                b'{' | b'[' => {
                    self.depth += 1;
                    self.is_in(State::Plain)
                }
                b'}' | b']' => {
                    self.depth = self.depth.saturating_sub(1);
                    self.state = State::Plain;
                    self.depth == 0
                }
                _ if self.depth == 0 => self.is_in(State::Word),
                _ => false,
            },
        }
    }

    /// True if all bytes so far were whitespace.
    pub fn is_fresh(&self) -> bool {
        self.state == State::Fresh
    }

    /// True within brackets or a string.
    pub fn is_within(&self) -> bool {
        self.depth > 0 || matches!(self.state, State::String | State::Escape)
    }

    fn is_in(&mut self, state: State) -> bool {
        self.state = state;
        false
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn finds_the_end_of_values_of_every_kind() {
        for (text, end) in [
            ("{\"a\":[1,{}]} {", Some(12)),
            ("[\"]\\\"]\"]]", Some(8)),
            (" \"a\\\\\"x", Some(6)),
            ("true,", Some(4)),
            ("1.5}", Some(3)),
            ("{\"a\":\"}", None),
            ("12", None),
        ] {
            assert_eq!(Frame::default().end(text.as_bytes()), end, "{text}");
        }
    }

    proptest! {
        #[test]
        fn finds_the_same_end_in_pieces(text in "[\\[\\]{}\",:\\\\ a1\u{1}]{0,40}", at in 0_usize..40) {
            let bytes = text.as_bytes();
            let mut frame = Frame::default();
            let steps = bytes.iter().position(|byte| frame.step(*byte));
            let end = steps.map(|last| last + usize::from(!frame.is_before));
            let (first, second) = bytes.split_at(at.min(bytes.len()));
            let mut frame = Frame::default();
            let found = frame.end(first).or_else(|| Some(first.len() + frame.end(second)?));
            prop_assert_eq!(found, end);
        }
    }
}
