//! The texts of events, which contain tags and placeholders.

use core::fmt::{self, Write};

use super::Profile;

/// The units of placeholders, each with the text that follows the number. `m_v` is a vertical distance.
pub const UNITS: [(&str, &str); 5] = [("m", "m"), ("m_v", "m"), ("m/s", "m/s"), ("m^2", "m^2"), ("C", "C")];

/// The maximum number of decimal places in a placeholder.
const MAX_DIGITS: u8 = 20;

/// A text of an event, as written in event metadata. The syntax of libevents applies:
///
/// - A backslash escapes the next character.
/// - `{N}` is the argument with this number, from 1. `{N:.D}` shows `D` decimal places. A unit may follow: `{N:.Dm/s}`.
/// - `<profile name="dev">…</profile>` is only for developers. With `!dev`, the content is for all other readers.
/// - `<param>NAME</param>` is the name of a parameter, and `<a href="URL">…</a>` a link.
/// - Other tags are removed with their content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Text<'t>(&'t str);

/// A part of a [`Text`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Piece<'t> {
    /// Characters without a special meaning.
    Plain(&'t str),
    /// An escaped character.
    Escaped(&'t str),
    /// An argument.
    Placeholder(Placeholder<'t>),
    /// A tag with its content.
    Tag(Tag<'t>),
    /// A `<` or `{` that starts neither a tag nor a placeholder. Readers show the character.
    Stray(&'t str),
}

/// An argument in a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Placeholder<'t> {
    /// The placeholder as written, with its braces.
    pub text: &'t str,
    /// The number of the argument, from 1. Greater than the number of arguments in an invalid text.
    pub number: usize,
    /// The number of decimal places.
    pub digits: Option<u8>,
    /// The text of the unit.
    pub unit: Option<&'static str>,
}

/// A tag in a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tag<'t> {
    /// The name.
    pub name: &'t str,
    /// The name and the value of the attribute.
    pub attribute: Option<(&'t str, &'t str)>,
    /// The text up to the first end tag of the same name.
    pub content: &'t str,
}

impl Tag<'_> {
    /// True if a reader with this profile sees the content.
    pub fn is_shown(&self, profile: Profile) -> bool {
        let name = self.attribute.map_or("", |(_, value)| value);
        match name.strip_prefix('!') {
            Some(other) => profile.name() != other,
            None => profile.name() == name,
        }
    }
}

impl<'t> Text<'t> {
    /// A text as written in event metadata.
    pub const fn new(text: &'t str) -> Self {
        Self(text)
    }

    /// The text as written.
    pub const fn as_str(self) -> &'t str {
        self.0
    }

    /// The parts of the text, in order. The content of a tag isn't split.
    pub fn pieces(self) -> impl Iterator<Item = Piece<'t>> {
        let mut rest = self.0;
        core::iter::from_fn(move || {
            let (piece, after) = next(rest)?;
            rest = after;
            Some(piece)
        })
    }

    /// The text that a reader sees, without white space at both ends. `argument` returns the argument with an index,
    /// from 0, if there is one.
    pub fn show<'a>(
        self,
        profile: Profile,
        argument: &'a dyn Fn(usize) -> Option<Argument<'a>>,
    ) -> Shown<'t, 'a> {
        Shown { text: self, profile, argument }
    }
}

/// The next part of a text, and the text after it.
fn next(text: &str) -> Option<(Piece<'_>, &str)> {
    let first = text.chars().next()?;
    let (start, after) = text.split_at(first.len_utf8());
    match first {
        '\\' => {
            let escaped = after.chars().next().map_or(0, char::len_utf8);
            Some((Piece::Escaped(&after[..escaped]), &after[escaped..]))
        }
        '<' => Some(tag(text).map_or((Piece::Stray(start), after), |(tag, after)| (Piece::Tag(tag), after))),
        '{' => Some(
            placeholder(text)
                .map_or((Piece::Stray(start), after), |(found, after)| (Piece::Placeholder(found), after)),
        ),
        _ => {
            let (plain, after) = text.split_at(text.find(['\\', '<', '{']).unwrap_or(text.len()));
            Some((Piece::Plain(plain), after))
        }
    }
}

/// Reads `<name attribute="value">content</name>` at the start of a text. The attribute is optional.
fn tag(text: &str) -> Option<(Tag<'_>, &str)> {
    let (name, after) = word(text.strip_prefix('<')?)?;
    let (attribute, after) = match after.strip_prefix(' ') {
        Some(after) => {
            let (attribute, after) = word(after)?;
            let (value, after) = after.strip_prefix("=\"")?.split_once('"')?;
            (Some((attribute, value)), after)
        }
        None => (None, after),
    };
    let body = after.strip_prefix('>')?;
    let end =
        ends(body).find(|(_, after)| after.strip_prefix(name).is_some_and(|rest| rest.starts_with('>')));
    let (content, after) = end?;
    Some((Tag { name, attribute, content }, &after[name.len() + 1..]))
}

/// The occurrences of `</` in a text, each as the text before and the text after it.
fn ends(body: &str) -> impl Iterator<Item = (&str, &str)> {
    body.match_indices("</").map(|(at, end)| (&body[..at], &body[at + end.len()..]))
}

/// A word of lower-case letters at the start of a text, and the text after it.
fn word(text: &str) -> Option<(&str, &str)> {
    let end = text.find(|c: char| !c.is_ascii_lowercase()).unwrap_or(text.len());
    (end > 0).then(|| text.split_at(end))
}

/// Reads `{N:.Dunit}` at the start of a text.
fn placeholder(text: &str) -> Option<(Placeholder<'_>, &str)> {
    let (inner, after) = text.strip_prefix('{')?.split_once('}')?;
    let (number, inner) = digits(inner)?;
    let number = number.parse().ok().filter(|number| *number > 0)?;
    let (places, unit) = match inner.strip_prefix(':') {
        Some(format) => match format.strip_prefix('.') {
            Some(format) => {
                let (places, unit) = digits(format)?;
                (Some(places.parse().ok().filter(|places| *places <= MAX_DIGITS)?), unit)
            }
            None => (None, format),
        },
        None => (None, inner),
    };
    let unit = match unit {
        "" => None,
        unit => Some(UNITS.iter().find(|(name, _)| *name == unit)?.1),
    };
    let text = &text[..text.len() - after.len()];
    Some((Placeholder { text, number, digits: places, unit }, after))
}

/// The decimal digits at the start of a text, and the text after them.
fn digits(text: &str) -> Option<(&str, &str)> {
    let end = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    (end > 0).then(|| text.split_at(end))
}

/// An argument of an event, for its texts.
#[derive(Clone, Copy)]
pub enum Argument<'a> {
    /// An integer.
    Integer(i128),
    /// A `float`.
    Float(f32),
    /// A value of an enum.
    Enum(i128, &'a dyn Labels),
}

/// The texts for the values of an enum in event metadata.
pub trait Labels {
    /// The number of bits, and the text between two labels. `None` if a value has a single label.
    fn bits(&self) -> Option<(usize, &str)>;

    /// The description of a value, or of a bit.
    fn label(&self, value: i128) -> Option<&str>;
}

impl fmt::Debug for Argument<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, formatter)
    }
}

/// The text of the argument. A `float` is formatted as the shortest text that parses to the same number.
impl fmt::Display for Argument<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let label = |formatter: &mut fmt::Formatter<'_>, found: Option<&str>, value| match found {
            Some(label) => formatter.write_str(label),
            None => write!(formatter, "(unknown: {value})"),
        };
        match *self {
            Self::Integer(value) => write!(formatter, "{value}"),
            Self::Float(value) => write!(formatter, "{value}"),
            Self::Enum(value, labels) => {
                let Some((bits, separator)) = labels.bits() else {
                    return label(formatter, labels.label(value), value);
                };
                let set = (0..bits).map(|bit| 1 << bit).filter(|bit| value & bit != 0);
                for (index, bit) in set.enumerate() {
                    formatter.write_str(if index == 0 { "" } else { separator })?;
                    // The reference parsers show the whole value, too.
                    label(formatter, labels.label(bit), value)?;
                }
                Ok(())
            }
        }
    }
}

/// Shows the text for a reader.
#[derive(Clone, Copy)]
pub struct Shown<'t, 'a> {
    text: Text<'t>,
    profile: Profile,
    argument: &'a dyn Fn(usize) -> Option<Argument<'a>>,
}

impl Shown<'_, '_> {
    fn write(&self, text: Text<'_>, to: &mut dyn Write) -> fmt::Result {
        for piece in text.pieces() {
            match piece {
                Piece::Plain(plain) | Piece::Escaped(plain) | Piece::Stray(plain) => to.write_str(plain)?,
                Piece::Placeholder(placeholder) => self.placeholder(placeholder, to)?,
                // The content can't contain a complete tag with the same name, so this recursion ends, too.
                Piece::Tag(tag) if tag.name == "profile" && tag.is_shown(self.profile) => {
                    self.write(Text(tag.content), to)?;
                }
                Piece::Tag(tag) if matches!(tag.name, "a" | "param") => to.write_str(tag.content)?,
                Piece::Tag(_) => {}
            }
        }
        Ok(())
    }

    fn placeholder(&self, placeholder: Placeholder<'_>, to: &mut dyn Write) -> fmt::Result {
        let Placeholder { text, number, digits, unit } = placeholder;
        let Some(argument) = (self.argument)(number - 1) else { return to.write_str(text) };
        let digits = digits.map(usize::from);
        match (argument, digits) {
            (Argument::Float(value), Some(digits)) => write!(to, "{value:.digits$}")?,
            (Argument::Integer(value), Some(digits @ 1..)) => write!(to, "{value}.{:0digits$}", 0)?,
            _ => write!(to, "{argument}")?,
        }
        unit.map_or(Ok(()), |unit| write!(to, " {unit}"))
    }
}

impl fmt::Display for Shown<'_, '_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The first pass finds the white space at the end.
        let mut measure = Measure { length: 0, visible: 0 };
        self.write(self.text, &mut measure)?;
        self.write(self.text, &mut Trim { to: formatter, room: measure.visible, has_started: false })
    }
}

impl fmt::Debug for Shown<'_, '_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, formatter)
    }
}

/// Measures a text, in bytes.
struct Measure {
    length: usize,
    /// The length without white space at the end.
    visible: usize,
}

impl Write for Measure {
    fn write_str(&mut self, part: &str) -> fmt::Result {
        let visible = part.trim_end().len();
        if visible > 0 {
            self.visible = self.length + visible;
        }
        self.length += part.len();
        Ok(())
    }
}

/// Writes a text without white space at both ends.
struct Trim<'f, 'w> {
    to: &'f mut fmt::Formatter<'w>,
    /// The number of bytes before the white space at the end.
    room: usize,
    has_started: bool,
}

impl Write for Trim<'_, '_> {
    fn write_str(&mut self, part: &str) -> fmt::Result {
        let part = &part[..part.len().min(self.room)];
        self.room -= part.len();
        let part = if self.has_started { part } else { part.trim_start() };
        self.has_started |= !part.is_empty();
        self.to.write_str(part)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alloc::string::{String, ToString};
    use crate::alloc::vec::Vec;
    use crate::alloc::{format, vec};

    struct Sides;

    impl Labels for Sides {
        fn bits(&self) -> Option<(usize, &str)> {
            Some((8, "/ "))
        }

        fn label(&self, value: i128) -> Option<&str> {
            [(1, "left"), (4, "right")].iter().find(|(known, _)| *known == value).map(|(_, label)| *label)
        }
    }

    struct Result;

    impl Labels for Result {
        fn bits(&self) -> Option<(usize, &str)> {
            None
        }

        fn label(&self, value: i128) -> Option<&str> {
            (value == -1).then_some("failed")
        }
    }

    fn shown(text: &str, profile: Profile) -> String {
        let arguments = [
            Argument::Integer(-7),
            Argument::Float(16.423),
            Argument::Enum(5, &Sides),
            Argument::Enum(6, &Sides),
            Argument::Enum(-1, &Result),
            Argument::Enum(3, &Result),
            Argument::Integer(i128::from(u64::MAX)),
        ];
        Text::new(text).show(profile, &|index| arguments.get(index).copied()).to_string()
    }

    #[test]
    fn shows_arguments_tags_and_escapes() {
        for (text, expected) in [
            ("{1} and {1m} and {7:}", "-7 and -7 m and 18446744073709551615"),
            (
                "{2} {2:.1} {2:.0m/s} {2:.3m_v} {2:.2m^2} {2C}",
                "16.423 16.4 16 m/s 16.423 m 16.42 m^2 16.423 C",
            ),
            ("{1:.2}, {1:.0}", "-7.00, -7"),
            ("{3}; {4}; {4:.2}", "left/ right; (unknown: 6)/ right; (unknown: 6)/ right"),
            ("{5}, {6}", "failed, (unknown: 3)"),
            (" \n a\\<b> \\{1} \\\\ ", "a<b> {1} \\"),
            (
                "see <a href=\"https://example.org\">the page</a> on <param>COM_ARM</param>",
                "see the page on COM_ARM",
            ),
            ("a<unknown>gone {1}</unknown>b<a>x</a>", "abx"),
            ("<param>{1}</param>", "{1}"),
            ("", ""),
        ] {
            assert_eq!(shown(text, Profile::Normal), expected, "{text}");
        }
    }

    #[test]
    fn shows_each_profile_its_parts() {
        let text =
            "a<profile name=\"dev\"> {1} <param>B</param> \\<</profile><profile name=\"!dev\">c</profile>";
        assert_eq!(shown(text, Profile::Dev), "a -7 B <");
        assert_eq!(shown(text, Profile::Normal), "ac");
        assert_eq!(shown("<profile>x</profile>", Profile::Normal), "");
    }

    #[test]
    fn shows_what_is_malformed_as_written() {
        for text in [
            "{",
            "{}",
            "{0}",
            "{8}",
            "{1",
            "{1:.}",
            "{1:.21}",
            "{1:x}",
            "{1 }",
            "{x}",
            "{99999999999999999999}",
            "<",
            "<>",
            "<a>",
            "<a href>x</a>",
            "<a href=x>x</a>",
            "<A>x</A>",
            "<a >x</a>",
            "<a>x</b>",
            "<a>x</a",
        ] {
            assert_eq!(shown(text, Profile::Normal), text);
        }
    }

    #[test]
    fn splits_a_text_into_all_of_its_bytes() {
        let text = "a\\é<b>{1:.2m}<a x=\"y\">z</a>\\";
        let pieces: Vec<Piece<'_>> = Text::new(text).pieces().collect();
        let tag = Tag { name: "a", attribute: Some(("x", "y")), content: "z" };
        let placeholder = Placeholder { text: "{1:.2m}", number: 1, digits: Some(2), unit: Some("m") };
        let expected = vec![
            Piece::Plain("a"),
            Piece::Escaped("é"),
            Piece::Stray("<"),
            Piece::Plain("b>"),
            Piece::Placeholder(placeholder),
            Piece::Tag(tag),
            Piece::Escaped(""),
        ];
        assert_eq!(pieces, expected);
    }

    #[test]
    fn floats_are_the_shortest_text_of_the_same_number() {
        for (value, expected) in
            [(0.1, "0.1"), (1.0, "1"), (-0.0, "-0"), (f32::NAN, "NaN"), (f32::INFINITY, "inf")]
        {
            assert_eq!(format!("{}", Argument::Float(value)), expected);
        }
    }
}
