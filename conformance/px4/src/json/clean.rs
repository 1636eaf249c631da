//! A fast check that confirms that a message has no findings. The check reads the text in one pass, without building a
//! tree.
//!
//! All other messages are checked with a tree, which provides the findings.

use uavspec_dynamic::members::Seen;
use uavspec_model::json::{Token, Tokens, Unclear, base64};
use uavspec_runtime::Scalar;
use uavspec_schema::{MessageId, Shape};

use super::dialect::{Dialect, Dialects};
use super::value::{Leaf, keep_bytes};
use crate::values::{Element, FieldPlan, MessagePlan, Plans};

/// The result for a message without findings.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Clean {
    /// The message's `timestamp` field.
    pub timestamp: Option<u64>,
    /// The accepted deviations from the published schema.
    pub dialects: Dialects,
}

impl Plans {
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
        let mut reading = Reading { plans: self, is_rosbridge, values, clean: Clean::default() };
        reading.message(tokens, self.get(id), 0, true)?;
        Ok(reading.clean)
    }
}

struct Reading<'p, 'v> {
    plans: &'p Plans,
    is_rosbridge: bool,
    values: &'v mut [u8],
    clean: Clean,
}

impl<'p> Reading<'p, '_> {
    /// Reads a message that starts at offset `base` in memory.
    fn message(
        &mut self,
        tokens: &mut Tokens<'_>,
        plan: &'p MessagePlan,
        base: usize,
        is_top: bool,
    ) -> Result<(), Unclear> {
        let fields = &plan.fields;
        let (mut seen, mut guess) = (Seen::default(), 0);
        tokens.object(|tokens| {
            let index = next_field(fields, guess, tokens)?;
            if !seen.insert(index, fields.len()) {
                return Err(Unclear);
            }
            guess = index + 1;
            let field = &fields[index];
            if is_top && field.is_timestamp() {
                return self.timestamp(tokens, field);
            }
            self.value(tokens, field, base + field.offset, false)
        })?;
        if (0..fields.len()).all(|index| seen.contains(index)) { Ok(()) } else { Err(Unclear) }
    }

    fn timestamp(&mut self, tokens: &mut Tokens<'_>, field: &FieldPlan) -> Result<(), Unclear> {
        let token = tokens.token()?;
        let value = Leaf::from_token(&token).and_then(Leaf::integer).ok_or(Unclear)?;
        self.clean.timestamp = Some(u64::try_from(value).map_err(|_| Unclear)?);
        field.keep(self.values, field.offset, Leaf::Int(value));
        Ok(())
    }

    /// Reads the value of a field, or one of its elements, at offset `at` in memory.
    fn value(
        &mut self,
        tokens: &mut Tokens<'_>,
        field: &'p FieldPlan,
        at: usize,
        is_element: bool,
    ) -> Result<(), Unclear> {
        let is_array = field.shape != Shape::Single && !is_element;
        match (tokens.peek(), field.element) {
            (Some(b'['), Element::Text(room)) if self.is_rosbridge => self.numbers(tokens, field, at, room),
            (Some(b'['), _) if is_array => self.list(tokens, field, at),
            (Some(b'{'), Element::Message(id)) if !is_array => {
                self.message(tokens, self.plans.get(id), at, false)
            }
            _ => {
                let token = tokens.token()?;
                if let Token::Text(text) = &token
                    && let Some(bytes) = field.as_base64(text, self.is_rosbridge, is_element)
                {
                    self.clean.dialects.insert(Dialect::Base64);
                    keep_bytes(self.values, at..at + bytes.len(), &bytes);
                    return if field.check_bytes(&bytes) { Ok(()) } else { Err(Unclear) };
                }
                let leaf = Leaf::from_token(&token).filter(|_| !is_array).ok_or(Unclear)?;
                field.check(leaf).map_err(|_| Unclear)?;
                field.keep(self.values, at, leaf);
                Ok(())
            }
        }
    }

    /// Reads the elements of an array.
    fn list(&mut self, tokens: &mut Tokens<'_>, field: &'p FieldPlan, mut at: usize) -> Result<(), Unclear> {
        let mut count = 0;
        tokens.list(|tokens| {
            self.value(tokens, field, at, true)?;
            count += 1;
            at += field.stride;
            Ok::<(), Unclear>(())
        })?;
        field.check_length(count).map_err(|_| Unclear)
    }

    /// Reads text that is written as an array of byte values.
    fn numbers(
        &mut self,
        tokens: &mut Tokens<'_>,
        field: &FieldPlan,
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
        field.check_text(&bytes).map_err(|_| Unclear)?;
        keep_bytes(self.values, at..at + room as usize, &bytes);
        Ok(())
    }
}

/// Reads the key of a field. The key most likely names the next declared field.
fn next_field(fields: &[FieldPlan], guess: usize, tokens: &mut Tokens<'_>) -> Result<usize, Unclear> {
    if fields.get(guess).is_some_and(|field| tokens.takes_key(&field.name)) {
        return Ok(guess);
    }
    let key = tokens.key()?;
    fields.iter().position(|field| field.name == key).ok_or(Unclear)
}

impl<'t> Leaf<'t> {
    /// The value of a token. `None` for numbers that are too large and for tokens that aren't JSON.
    pub(super) fn from_token(token: &'t Token<'_>) -> Option<Self> {
        Some(match token {
            Token::Null => Self::Null,
            Token::Bool(value) => Self::Bool(*value),
            Token::Int(value) => Self::Int(*value),
            Token::Float(value, _) => Self::Float(*value),
            Token::Text(text) => Self::Text(text),
            Token::Huge(_) | Token::NotJson(_) => return None,
        })
    }
}

impl FieldPlan {
    /// True if the field is the timestamp of a message. The timestamp's definition has no restriction, so the field
    /// needs no check.
    pub(super) fn is_timestamp(&self) -> bool {
        self.name == "timestamp"
            && matches!(self.element, Element::Scalar(Scalar::UInt64))
            && self.shape == Shape::Single
            && self.restriction.is_none()
    }

    /// The decoded bytes of an array that rosbridge wrote as base64.
    ///
    /// The base64 of an array is longer than any text that fits into the array, so there is no ambiguity.
    pub(super) fn as_base64(&self, text: &str, is_rosbridge: bool, is_element: bool) -> Option<Vec<u8>> {
        let is_bytes = match self.element {
            Element::Text(room) => text.len() > room as usize,
            _ => self.is_byte_array() && !is_element,
        };
        if is_rosbridge && is_bytes { base64::decode(text) } else { None }
    }

    /// True if an array decoded from base64 has no findings.
    fn check_bytes(&self, bytes: &[u8]) -> bool {
        match self.element {
            Element::Text(_) => self.check_text(bytes).is_ok(),
            _ => {
                self.check_length(bytes.len()).is_ok()
                    && bytes.iter().all(|byte| self.check(Leaf::Int((*byte).into())).is_ok())
            }
        }
    }
}
