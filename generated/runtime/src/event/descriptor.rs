//! Descriptors of events, which generated code contains.

use core::fmt;

use super::text::{Argument, Labels, Text};
use super::{LogLevel, MAX_ARGUMENTS_SIZE, Profile};
use crate::record::Primitive;
use crate::{Fault, Scalar};

/// The language of the definitions.
const ENGLISH: &str = "en";

/// An event of event metadata.
#[derive(Debug)]
pub struct EventDescriptor {
    /// The id, which includes the id of the component.
    pub id: u32,
    /// The name of the component.
    pub namespace: &'static str,
    /// The name.
    pub name: &'static str,
    /// The group.
    pub group: &'static str,
    /// The arguments, in the order of their bytes.
    pub arguments: &'static [ArgumentDescriptor],
    /// The texts, in English and in other languages.
    pub texts: &'static [EventTexts],
}

/// The texts of an event in one language.
#[derive(Debug)]
pub struct EventTexts {
    /// The BCP 47 tag, such as `pt-BR`.
    pub language: &'static str,
    /// The message: one line.
    pub message: Text<'static>,
    /// The description, which may be empty.
    pub description: Text<'static>,
}

impl EventTexts {
    /// The texts in a language.
    pub const fn new(language: &'static str, message: &'static str, description: &'static str) -> Self {
        Self { language, message: Text::new(message), description: Text::new(description) }
    }
}

/// An argument of an event.
#[derive(Debug)]
pub struct ArgumentDescriptor {
    /// The name.
    pub name: &'static str,
    /// The type of the value.
    pub scalar: Scalar,
    /// The labels of an enum, in English and in other languages. Empty for a number.
    pub labels: &'static [EnumLabels],
}

impl ArgumentDescriptor {
    /// An argument with its type and its labels.
    pub const fn new(name: &'static str, scalar: Scalar, labels: &'static [EnumLabels]) -> Self {
        Self { name, scalar, labels }
    }
}

/// The labels of an enum in one language.
#[derive(Debug)]
pub struct EnumLabels {
    /// The BCP 47 tag, such as `pt-BR`.
    pub language: &'static str,
    /// The number of bits, and the text between two labels. `None` if a value has a single label.
    pub bits: Option<(usize, &'static str)>,
    /// The label of each value or bit, sorted by value.
    pub entries: &'static [(i128, &'static str)],
}

impl Labels for EnumLabels {
    fn bits(&self) -> Option<(usize, &str)> {
        self.bits
    }

    fn label(&self, value: i128) -> Option<&str> {
        let found = self.entries.binary_search_by_key(&value, |(known, _)| *known);
        found.ok().map(|at| self.entries[at].1)
    }
}

impl EventDescriptor {
    /// The size of the arguments, in bytes.
    pub fn size(&self) -> usize {
        self.arguments.iter().map(|argument| argument.scalar.size()).sum()
    }

    /// The message of an event with these arguments, for a reader of this profile and language. If the language isn't
    /// available, the message is in English.
    pub fn message<'a>(
        &'static self,
        arguments: &'a [u8],
        profile: Profile,
        language: &str,
    ) -> ShownEvent<'a> {
        self.show(arguments, profile, language, |texts| texts.message)
    }

    /// Like [`Self::message`], for the description.
    pub fn description<'a>(
        &'static self,
        arguments: &'a [u8],
        profile: Profile,
        language: &str,
    ) -> ShownEvent<'a> {
        self.show(arguments, profile, language, |texts| texts.description)
    }

    fn show<'a>(
        &'static self,
        arguments: &'a [u8],
        profile: Profile,
        language: &str,
        text: fn(&EventTexts) -> Text<'static>,
    ) -> ShownEvent<'a> {
        let texts = in_language(self.texts, language, |texts| texts.language);
        ShownEvent {
            descriptor: self,
            arguments,
            profile,
            language: texts.map_or(ENGLISH, |texts| texts.language),
            text: texts.map_or(Text::new(""), text),
        }
    }

    /// The value of an argument. `None` if there is no such argument, or too few bytes.
    fn argument(&'static self, index: usize, bytes: &[u8], language: &str) -> Option<Argument<'static>> {
        let argument = self.arguments.get(index)?;
        let before = self.arguments[..index].iter().map(|argument| argument.scalar.size());
        let bytes = bytes.get(before.sum()..)?.get(..argument.scalar.size())?;
        if argument.scalar == Scalar::Float32 {
            return Some(Argument::Float(f32::read_le(bytes)));
        }
        let value = match argument.scalar {
            Scalar::Int8 => i8::read_le(bytes).into(),
            Scalar::Int16 => i16::read_le(bytes).into(),
            Scalar::UInt16 => u16::read_le(bytes).into(),
            Scalar::Int32 => i32::read_le(bytes).into(),
            Scalar::UInt32 => u32::read_le(bytes).into(),
            Scalar::Int64 => i64::read_le(bytes).into(),
            Scalar::UInt64 => u64::read_le(bytes).into(),
            _ => u8::read_le(bytes).into(),
        };
        let labels = in_language(argument.labels, language, |labels| labels.language);
        Some(labels.map_or(Argument::Integer(value), |labels| Argument::Enum(value, labels)))
    }
}

/// The entry in a language, or the English entry if there is none.
fn in_language<T>(all: &'static [T], language: &str, tag: impl Fn(&T) -> &'static str) -> Option<&'static T> {
    let find = |wanted: &str| all.iter().find(|found| tag(found).eq_ignore_ascii_case(wanted));
    find(language).or_else(|| find(ENGLISH))
}

/// Shows a text of an event.
#[derive(Clone, Copy)]
pub struct ShownEvent<'a> {
    descriptor: &'static EventDescriptor,
    arguments: &'a [u8],
    profile: Profile,
    language: &'static str,
    text: Text<'static>,
}

impl fmt::Display for ShownEvent<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let argument = |index| self.descriptor.argument(index, self.arguments, self.language);
        fmt::Display::fmt(&self.text.show(self.profile, &argument), formatter)
    }
}

impl fmt::Debug for ShownEvent<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, formatter)
    }
}

/// An event with its arguments, which code generated from event metadata implements.
pub trait Event: Sized {
    /// The descriptor.
    const DESCRIPTOR: &'static EventDescriptor;

    /// The id, which includes the id of the component.
    const ID: u32 = Self::DESCRIPTOR.id;

    /// Reads the arguments. The source has enough bytes.
    #[doc(hidden)]
    fn read(source: &mut ArgumentReader<'_>) -> Self;

    /// Writes the arguments.
    #[doc(hidden)]
    fn write(&self, sink: &mut ArgumentWriter);

    /// Decodes the arguments. Bytes after the arguments are ignored; in PX4's messages, they are zero.
    fn decode(arguments: &[u8]) -> Result<Self, Fault> {
        let (needed, left) = (Self::DESCRIPTOR.size(), arguments.len());
        if left < needed {
            return Err(Fault::Truncated { needed, left });
        }
        Ok(Self::read(&mut ArgumentReader { rest: arguments }))
    }

    /// Encodes the arguments, followed by zeros.
    fn encode(&self) -> [u8; MAX_ARGUMENTS_SIZE] {
        let mut sink = ArgumentWriter { bytes: [0; MAX_ARGUMENTS_SIZE], length: 0 };
        self.write(&mut sink);
        sink.bytes
    }
}

/// Reads arguments.
#[derive(Debug)]
pub struct ArgumentReader<'a> {
    rest: &'a [u8],
}

impl ArgumentReader<'_> {
    /// The next number; 0 if there are too few bytes.
    pub fn take<P: Primitive>(&mut self) -> P {
        let size = P::SCALAR.size();
        let Some((bytes, rest)) = self.rest.split_at_checked(size) else { return P::default() };
        self.rest = rest;
        P::read_le(bytes)
    }
}

/// Writes arguments.
#[derive(Debug)]
pub struct ArgumentWriter {
    bytes: [u8; MAX_ARGUMENTS_SIZE],
    length: usize,
}

impl ArgumentWriter {
    /// Adds a number, if there is room.
    pub fn put<P: Primitive>(&mut self, value: P) {
        let end = self.length + P::SCALAR.size();
        if let Some(room) = self.bytes.get_mut(self.length..end) {
            value.write_le(room);
            self.length = end;
        }
    }
}

/// Combines the levels for logs and for ground stations into the field `log_levels` of an event.
pub const fn log_levels(internal: LogLevel, external: LogLevel) -> u8 {
    (internal as u8) << 4 | external as u8
}
