//! Finds where a value ends, from brackets and quotation marks alone.

/// Follows the bytes of a value.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cut {
    depth: u64,
    state: State,
    is_before: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum State {
    /// Nothing but space so far.
    #[default]
    Fresh,
    /// Between strings.
    Plain,
    /// A number or a word that nothing surrounds.
    Word,
    String,
    /// Behind a backslash in a string.
    Escape,
}

impl Cut {
    /// Takes the next byte, and says whether the value ends: with this byte, or before it.
    pub(super) fn step(&mut self, byte: u8) -> bool {
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

    /// Whether the byte that ended the value isn't part of it.
    pub(super) fn is_before(&self) -> bool {
        self.is_before
    }

    /// Whether nothing has begun yet.
    pub(super) fn is_fresh(&self) -> bool {
        self.state == State::Fresh
    }

    /// Whether something is open.
    pub(super) fn is_within(&self) -> bool {
        self.depth > 0 || matches!(self.state, State::String | State::Escape)
    }

    fn is_in(&mut self, state: State) -> bool {
        self.state = state;
        false
    }
}
