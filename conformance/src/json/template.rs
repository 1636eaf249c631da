//! Says whether a message is clean by how clean ones before it were written.
//!
//! A producer writes the same message the same way each time: only the values differ. So what stands between the
//! values of a clean message, keys and all, is kept, and the next one is compared with it byte for byte; only its
//! values are read. That takes a fraction of the time that reading it as any JSON takes, and whatever differs is
//! read as that.

use uavspec_codegen::schema::{MessageId, Shape};
use uavspec_runtime::Scalar;

use super::clean::Clean;
use super::dialect::Dialects;
use super::plan::{Element, FieldPlan, Plans};
use super::value::Leaf;

/// Most values that a template has: beyond that it costs more room than it saves time.
const MAX_STEPS: usize = 8_192;

/// How clean messages of a channel are written.
#[derive(Debug)]
pub(crate) struct Template {
    steps: Vec<Step>,
    /// What follows the last value.
    tail: Box<[u8]>,
}

/// A value, and what stands before it.
#[derive(Debug)]
struct Step {
    literal: Box<[u8]>,
    message: MessageId,
    field: usize,
    /// Where it is in memory.
    at: usize,
    is_timestamp: bool,
}

impl Template {
    /// The template of a text in which a clean message stands: as the whole of it, or as the value of this key.
    /// None where it is written in a way that templates don't know.
    pub(crate) fn of(plans: &Plans, id: MessageId, text: &[u8], key: Option<&str>) -> Option<Self> {
        let mut learner = Learner { plans, text, at: 0, literal: 0, steps: Vec::new() };
        match key {
            None => learner.message(id, 0, true)?,
            Some(key) => learner.around(id, key)?,
        }
        let Learner { literal, steps, .. } = learner;
        Some(Self { steps, tail: text[literal..].into() })
    }

    /// Whether a text is one more like it, and what it says of itself; `values` gets its numbers and bools as they
    /// lie in memory, if it has room for them.
    pub(crate) fn read(&self, plans: &Plans, text: &[u8], values: &mut [u8]) -> Option<Clean> {
        let mut timestamp = None;
        let mut rest = text;
        for step in &self.steps {
            rest = rest.strip_prefix(&*step.literal)?;
            let (leaf, after) = token(rest)?;
            let field = &plans.get(step.message).fields[step.field];
            field.judge(leaf).ok()?;
            if step.is_timestamp {
                let Leaf::Int(value) = leaf else { return None };
                timestamp = u64::try_from(value).ok();
            }
            if let (Element::Scalar(scalar), false) = (field.element, values.is_empty()) {
                keep(values, scalar, step.at, leaf);
            }
            rest = after;
        }
        (rest == &*self.tail).then_some(Clean { timestamp, dialects: Dialects::default() })
    }
}

/// Keeps a value at its place in memory.
pub(super) fn keep(values: &mut [u8], scalar: Scalar, at: usize, leaf: Leaf<'_>) {
    let bytes = leaf.bytes(scalar);
    if let Some(place) = values.get_mut(at..at + scalar.size()) {
        place.copy_from_slice(&bytes[..scalar.size()]);
    }
}

/// The value that a text begins with, and what follows it. None where it is an object or an array, is no JSON, or
/// is written in a way that is seldom.
fn token(text: &[u8]) -> Option<(Leaf<'_>, &[u8])> {
    match text.first()? {
        b't' => Some((Leaf::Bool(true), text.strip_prefix(b"true")?)),
        b'f' => Some((Leaf::Bool(false), text.strip_prefix(b"false")?)),
        b'n' => Some((Leaf::Null, text.strip_prefix(b"null")?)),
        b'"' => {
            let is_special = |byte: &u8| matches!(byte, b'"' | b'\\' | ..=0x1f);
            let end = 1 + text[1..].iter().position(is_special)?;
            let is_plain = text[end] == b'"';
            is_plain.then(|| Some((Leaf::Text(str::from_utf8(&text[1..end]).ok()?), &text[end + 1..])))?
        }
        _ => number(text),
    }
}

/// A number as RFC 8259 writes it.
fn number(text: &[u8]) -> Option<(Leaf<'_>, &[u8])> {
    let digits = |text: &[u8]| text.iter().position(|byte| !byte.is_ascii_digit()).unwrap_or(text.len());
    let sign = usize::from(text[0] == b'-');
    let whole = digits(&text[sign..]);
    let first = *text.get(sign)?;
    // Nothing may stand behind a leading 0; and -0 is a float, whatever its field.
    if whole == 0 || (first == b'0' && (whole > 1 || sign == 1)) {
        return None;
    }
    let mut end = sign + whole;
    let is_integer = !matches!(text.get(end), Some(b'.' | b'e' | b'E'));
    if is_integer {
        // What has more digits is in the range of no type.
        let value = text[sign..end]
            .iter()
            .fold(0_u64, |value, digit| value.wrapping_mul(10).wrapping_add(u64::from(digit - b'0')));
        let value = i128::from(value);
        return (whole < 20).then_some((Leaf::Int(if sign == 1 { -value } else { value }), &text[end..]));
    }
    if text[end] == b'.' {
        let fraction = digits(&text[end + 1..]);
        if fraction == 0 {
            return None;
        }
        end += 1 + fraction;
    }
    if matches!(text.get(end), Some(b'e' | b'E')) {
        end += 1 + usize::from(matches!(text.get(end + 1), Some(b'+' | b'-')));
        let exponent = digits(text.get(end..)?);
        if exponent == 0 {
            return None;
        }
        end += exponent;
    }
    let value: f64 = str::from_utf8(&text[..end]).ok()?.parse().ok()?;
    // JSON can say numbers that no float holds: what they are is for others to say.
    value.is_finite().then_some((Leaf::Float(value), &text[end..]))
}

/// Finds the values of a clean message.
struct Learner<'p, 't> {
    plans: &'p Plans,
    text: &'t [u8],
    at: usize,
    /// Where what stands before the next value begins.
    literal: usize,
    steps: Vec<Step>,
}

impl Learner<'_, '_> {
    fn space(&mut self) {
        let rest = &self.text[self.at..];
        let is_space = |byte: &u8| matches!(byte, b' ' | b'\t' | b'\n' | b'\r');
        self.at += rest.iter().position(|byte| !is_space(byte)).unwrap_or(rest.len());
    }

    fn take(&mut self, byte: u8) -> Option<()> {
        self.space();
        (self.text.get(self.at) == Some(&byte)).then(|| self.at += 1)
    }

    fn string(&mut self) -> Option<&[u8]> {
        self.space();
        let start = self.at;
        let (Leaf::Text(text), rest) = token(&self.text[start..])? else { return None };
        self.at = self.text.len() - rest.len();
        Some(text.as_bytes())
    }

    /// Members of an object or elements of an array, up to its end.
    fn each(&mut self, end: u8, mut item: impl FnMut(&mut Self) -> Option<()>) -> Option<()> {
        self.space();
        if self.text.get(self.at) == Some(&end) {
            return self.take(end);
        }
        loop {
            item(self)?;
            if self.take(b',').is_none() {
                return self.take(end);
            }
        }
    }

    /// An object of which one member is the message; all others are as they are.
    fn around(&mut self, id: MessageId, message: &str) -> Option<()> {
        self.take(b'{')?;
        self.each(b'}', |learner| {
            let is_message = learner.string()? == message.as_bytes();
            learner.take(b':')?;
            learner.space();
            if is_message {
                return learner.message(id, 0, true);
            }
            let (_, rest) = token(&learner.text[learner.at..])?;
            learner.at = learner.text.len() - rest.len();
            Some(())
        })
    }

    fn message(&mut self, id: MessageId, base: usize, is_top: bool) -> Option<()> {
        let plans = self.plans;
        let fields = &plans.get(id).fields;
        self.take(b'{')?;
        self.each(b'}', |learner| {
            let key = learner.string()?;
            let index = fields.iter().position(|field| field.name.as_bytes() == key)?;
            learner.take(b':')?;
            let field = &fields[index];
            let place =
                Place { id, index, at: base + field.offset, is_timestamp: is_top && field.is_timestamp() };
            if field.shape == Shape::Single {
                return learner.value(field, place);
            }
            learner.take(b'[')?;
            let mut element = place;
            learner.each(b']', |learner| {
                learner.value(field, element)?;
                element.at += field.stride;
                Some(())
            })
        })
    }

    fn value(&mut self, field: &FieldPlan, place: Place) -> Option<()> {
        if let Element::Message(nested) = field.element {
            return self.message(nested, place.at, false);
        }
        self.space();
        let (_, rest) = token(&self.text[self.at..])?;
        if self.steps.len() == MAX_STEPS {
            return None;
        }
        let Place { id: message, index: field, at, is_timestamp } = place;
        let literal = self.text[self.literal..self.at].into();
        self.steps.push(Step { literal, message, field, at, is_timestamp });
        self.at = self.text.len() - rest.len();
        self.literal = self.at;
        Some(())
    }
}

/// Which field a value is of, and where it is in memory.
#[derive(Clone, Copy)]
struct Place {
    id: MessageId,
    index: usize,
    at: usize,
    is_timestamp: bool,
}
