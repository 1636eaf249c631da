//! A fast check that confirms that a message has no findings. The check reads the text in one pass, without building a
//! tree.
//!
//! All other messages are checked with a tree, which provides the findings.

use uavspec_dynamic::members::Seen;
use uavspec_dynamic::{Field, Leaf, MessageType};
use uavspec_model::json::{Token, Tokens, Unclear};
use uavspec_schema::{Element, MessageId, Shape};

use super::dialect::{Dialect, Dialects};
use super::value::{as_base64, is_timestamp, keep, keep_bytes, leaf_of};
use crate::values::Plans;

/// The result for a message without findings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Clean {
    /// The message's `timestamp` field.
    pub timestamp: Option<u64>,
    /// The accepted deviations from the published schema.
    pub dialects: Dialects,
}

impl Plans<'_> {
    /// Reads text like [`Plans::read`]. Fails if there may be findings.
    pub fn read_text(
        &self,
        id: MessageId,
        text: &str,
        is_rosbridge: bool,
        values: &mut [u8],
    ) -> Result<Clean, Unclear> {
        let mut tokens = Tokens::new(text);
        let clean = self.read(id, &mut tokens, is_rosbridge, values)?;
        tokens.end()?;
        Ok(clean)
    }

    /// Reads a message without findings. Stores the message's values except for strings in `values`, in memory layout.
    /// `values` has the size of the message, or is empty if the values aren't needed.
    pub fn read(
        &self,
        id: MessageId,
        tokens: &mut Tokens<'_>,
        is_rosbridge: bool,
        values: &mut [u8],
    ) -> Result<Clean, Unclear> {
        let mut reading = Reading { is_rosbridge, values, clean: Clean::default() };
        reading.message(tokens, self.types.get(id), 0, true)?;
        Ok(reading.clean)
    }
}

struct Reading<'v> {
    is_rosbridge: bool,
    values: &'v mut [u8],
    clean: Clean,
}

impl Reading<'_> {
    /// Reads a message that starts at offset `base` in memory.
    fn message(
        &mut self,
        tokens: &mut Tokens<'_>,
        message_type: MessageType<'_>,
        base: usize,
        is_top: bool,
    ) -> Result<(), Unclear> {
        let fields = message_type.fields();
        let (mut seen, mut guess) = (Seen::default(), 0);
        tokens.object(|tokens| {
            let index = next_field(fields, guess, tokens)?;
            if !seen.insert(index, fields.len()) {
                return Err(Unclear);
            }
            guess = index + 1;
            let field = &fields[index];
            if is_top && is_timestamp(field) {
                return self.timestamp(tokens, field);
            }
            self.value(tokens, message_type, field, base + field.offset, false)
        })?;
        if (0..fields.len()).all(|index| seen.contains(index)) { Ok(()) } else { Err(Unclear) }
    }

    fn timestamp(&mut self, tokens: &mut Tokens<'_>, field: &Field) -> Result<(), Unclear> {
        let token = tokens.token()?;
        let value = leaf_of(&token).and_then(Leaf::integer).ok_or(Unclear)?;
        self.clean.timestamp = Some(u64::try_from(value).map_err(|_| Unclear)?);
        keep(field, self.values, field.offset, Leaf::Int(value));
        Ok(())
    }

    /// Reads the value of a field, or one of its elements, at offset `at` in memory.
    fn value(
        &mut self,
        tokens: &mut Tokens<'_>,
        message_type: MessageType<'_>,
        field: &Field,
        at: usize,
        is_element: bool,
    ) -> Result<(), Unclear> {
        let is_array = field.shape != Shape::Single && !is_element;
        match (tokens.peek(), field.element) {
            (Some(b'['), Element::Text(room)) if self.is_rosbridge => self.numbers(tokens, field, at, room),
            (Some(b'['), _) if is_array => self.list(tokens, message_type, field, at),
            (Some(b'{'), Element::Message(id)) if !is_array => {
                self.message(tokens, message_type.nested(id), at, false)
            }
            _ => {
                let token = tokens.token()?;
                if let Token::Text(text) = &token
                    && let Some(bytes) = as_base64(field, text, self.is_rosbridge, is_element)
                {
                    self.clean.dialects.insert(Dialect::Base64);
                    keep_bytes(self.values, at..at + bytes.len(), &bytes);
                    return if has_valid_bytes(field, &bytes) { Ok(()) } else { Err(Unclear) };
                }
                let leaf = leaf_of(&token).filter(|_| !is_array).ok_or(Unclear)?;
                field.value_type().check_leaf(leaf).map_err(|_| Unclear)?;
                keep(field, self.values, at, leaf);
                Ok(())
            }
        }
    }

    /// Reads the elements of an array.
    fn list(
        &mut self,
        tokens: &mut Tokens<'_>,
        message_type: MessageType<'_>,
        field: &Field,
        mut at: usize,
    ) -> Result<(), Unclear> {
        let mut count = 0;
        tokens.list(|tokens| {
            self.value(tokens, message_type, field, at, true)?;
            count += 1;
            at += field.stride;
            Ok::<(), Unclear>(())
        })?;
        field.value_type().check_length(count).map_err(|_| Unclear)
    }

    /// Reads text that is written as an array of byte values.
    fn numbers(
        &mut self,
        tokens: &mut Tokens<'_>,
        field: &Field,
        at: usize,
        room: u32,
    ) -> Result<(), Unclear> {
        let mut bytes = Vec::new();
        tokens.list(|tokens| match tokens.token()? {
            Token::Int(byte) if bytes.len() < room as usize => {
                bytes.push(u8::try_from(byte).map_err(|_| Unclear)?);
                Ok(())
            }
            _ => Err(Unclear),
        })?;
        self.clean.dialects.insert(Dialect::NumbersForText);
        field.value_type().check_array(&bytes).map_err(|_| Unclear)?;
        keep_bytes(self.values, at..at + room as usize, &bytes);
        Ok(())
    }
}

/// Reads the key of a field. The key most likely names the next declared field.
fn next_field(fields: &[Field], guess: usize, tokens: &mut Tokens<'_>) -> Result<usize, Unclear> {
    if fields.get(guess).is_some_and(|field| tokens.takes_key(&field.name)) {
        return Ok(guess);
    }
    let key = tokens.key()?;
    fields.iter().position(|field| *field.name == *key).ok_or(Unclear)
}

/// True if an array decoded from base64 has no findings.
fn has_valid_bytes(field: &Field, bytes: &[u8]) -> bool {
    let value = field.value_type();
    match field.element {
        Element::Text(_) => value.check_array(bytes).is_ok(),
        _ => {
            value.check_length(bytes.len()).is_ok()
                && bytes.iter().all(|byte| value.check_leaf(Leaf::Int((*byte).into())).is_ok())
        }
    }
}
