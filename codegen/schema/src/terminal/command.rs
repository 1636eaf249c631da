//! Commands that CI systems execute when they find them in a log.

/// Recognizes the start of a command in the characters of a text.
///
/// GitHub executes `::name::` at the start of a line, after white space. GitHub, Azure Pipelines and `TeamCity` execute
/// `##[name]`, `##vso[name]` and `##teamcity[name]` anywhere in a line. The commands of GitLab and Travis require control
/// characters, which are escaped anyway.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) enum Command {
    /// So far, the line contains only white space.
    #[default]
    Start,
    /// The first character of the line is a colon.
    Colon,
    /// The first characters of the line are two colons. A letter or digit after the colons starts a name. A third colon
    /// starts the second location of a diagnostic.
    Colons,
    /// The last character is a number sign.
    Hash,
    /// The last characters are two number signs and optional letters.
    Name,
    /// Any other text.
    Text,
}

impl Command {
    /// True for a tab or a visible ASCII character that starts no command within a line.
    pub(crate) fn is_plain(byte: u8) -> bool {
        matches!(byte, b'\t' | b' '..=b'~') && byte != b'#'
    }

    /// Advances by a character. True if this character completes the start of a command.
    pub(crate) fn is_completed_by(&mut self, character: char) -> bool {
        let (next, is_complete) = match (*self, character) {
            (_, '\n') => (Self::Start, false),
            (Self::Start, ':') => (Self::Colon, false),
            (Self::Start, _) if character.is_whitespace() => (Self::Start, false),
            (Self::Colon, ':') => (Self::Colons, false),
            (Self::Colons, _) => (Self::Text, character.is_alphanumeric()),
            (Self::Name, '[') => (Self::Text, true),
            (Self::Hash | Self::Name, '#') => (Self::Name, false),
            (Self::Name, _) if character.is_ascii_alphabetic() => (Self::Name, false),
            (_, '#') => (Self::Hash, false),
            _ => (Self::Text, false),
        };
        *self = next;
        is_complete
    }
}
