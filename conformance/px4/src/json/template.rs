//! Confirms that messages have no findings by comparing them with an earlier message on the same channel.
//!
//! A producer always writes a message in the same form, and most values don't change. A template stores the text of a
//! message without findings, with the positions of its values. The next message is compared with the template byte by
//! byte. Everything between the values, including keys, must be equal, and only values that differ are read. The
//! comparison takes a fraction of the time needed to parse JSON. All other text takes the usual path.

use uavspec_dynamic::{Field, Leaf};
use uavspec_model::json::{Tokens, Unclear};
use uavspec_schema::{Element, MessageId, Shape};

use super::clean::Clean;
use super::dialect::Dialects;
use super::value::{is_timestamp, keep, keep_bytes, leaf_of};
use crate::values::Plans;

/// The maximum number of values in a template. Larger templates cost too much memory for the time they save.
const MAX_STEPS: usize = 8_192;

/// The envelope keys that identify the message.
const TYPE_KEYS: [&str; 5] = ["op", "topic", "type", "msg", "message"];

/// A message without findings, with its envelope.
#[derive(Debug)]
pub struct Template {
    text: String,
    steps: Vec<Step>,
    /// The values except for strings in memory layout; empty if they aren't needed.
    values: Vec<u8>,
    timestamp: Option<u64>,
    /// The differences between the current message and the template.
    changes: Vec<Change>,
}

/// The position of a value in the text.
#[derive(Clone, Copy, Debug)]
struct Step {
    /// The start in the text.
    start: usize,
    end: usize,
    /// The field of the value. `None` for values in the envelope, which aren't checked.
    slot: Option<Slot>,
}

/// A value that differs from the template.
#[derive(Clone, Copy, Debug)]
struct Change {
    step: usize,
    /// The length of the text, in bytes.
    length: usize,
    /// The value in memory.
    bytes: [u8; 8],
}

impl Template {
    /// Creates a template from text without findings. The message is the whole text, or the value of `key`. `size` is
    /// the size of the message's values in memory. Returns `None` if the form isn't supported.
    pub fn new(plans: &Plans<'_>, id: MessageId, text: &str, key: Option<&str>, size: usize) -> Option<Self> {
        let template = Self {
            text: text.into(),
            steps: Vec::new(),
            values: vec![0; size],
            timestamp: None,
            changes: Vec::new(),
        };
        let mut learner = Learner { plans, template };
        let mut tokens = Tokens::new(text);
        let read = match key {
            None => learner.message(&mut tokens, id, 0, true),
            Some(key) => learner.around(&mut tokens, id, key),
        };
        read.ok().map(|()| learner.template)
    }

    /// Compares a text with the template. If only values differ and all of them are valid, stores the text as the
    /// template's new text, and returns its results.
    pub fn read(&mut self, plans: &Plans<'_>, text: &str) -> Option<Clean> {
        self.compare(plans, text)?;
        self.advance(plans, text);
        Some(Clean { timestamp: self.timestamp, dialects: Dialects::default() })
    }

    /// The values of the latest message except for strings, in memory layout.
    pub fn values(&self) -> &[u8] {
        &self.values
    }

    /// Finds the values that differ. Returns `None` if anything else differs, or if a value is invalid.
    fn compare(&mut self, plans: &Plans<'_>, text: &str) -> Option<()> {
        self.changes.clear();
        let (mut old, mut new, mut next) = (0, 0, 0);
        loop {
            let same = common(&self.text.as_bytes()[old..], &text.as_bytes()[new..]);
            (old, new) = (old + same, new + same);
            if old == self.text.len() && new == text.len() {
                return Some(());
            }
            // A value may be longer than the previous one.
            next += match self.steps.get(next) {
                Some(step) if step.end >= old => 0,
                _ => self.steps[next..].partition_point(|step| step.end < old),
            };
            let step = self.steps.get(next)?;
            let start = new - old.checked_sub(step.start)?;
            let mut tokens = Tokens::new(text.get(start..)?);
            let token = tokens.token().ok()?;
            let leaf = leaf_of(&token)?;
            let bytes = match step.slot {
                None => [0; 8],
                Some(slot) => {
                    let field = slot.field(plans);
                    field.value_type().check_leaf(leaf).ok()?;
                    bytes_of(field, leaf)
                }
            };
            let length = tokens.at();
            self.changes.push(Change { step: next, length, bytes });
            (old, new, next) = (step.end, start + length, next + 1);
        }
    }

    /// Updates the template to match a text that has the recorded changes.
    fn advance(&mut self, plans: &Plans<'_>, text: &str) {
        let Some(first) = self.changes.first() else { return };
        // If the lengths differ, later values move.
        if self.text.len() != text.len()
            || self.changes.iter().any(|change| self.steps[change.step].length() != change.length)
        {
            let mut changes = self.changes.iter().peekable();
            let mut start = self.steps[first.step].start;
            let mut before = start;
            for (index, step) in self.steps.iter_mut().enumerate().skip(first.step) {
                start += step.start - before;
                let length = changes.next_if(|change| change.step == index).map(|change| change.length);
                let end = start + length.unwrap_or(step.length());
                before = step.end;
                (step.start, step.end) = (start, end);
                start = end;
            }
        }
        self.text.clear();
        self.text.push_str(text);
        for change in &self.changes {
            let Some(slot) = self.steps[change.step].slot else { continue };
            if slot.is_timestamp {
                self.timestamp = Some(u64::from_le_bytes(change.bytes));
            }
            let field = slot.field(plans);
            match field.element {
                Element::Text(_) => {
                    let step = self.steps[change.step];
                    let token = Tokens::new(&self.text[step.start..step.end]).token();
                    if let Some(leaf) = token.as_ref().ok().and_then(leaf_of) {
                        keep(field, &mut self.values, slot.at, leaf);
                    }
                }
                Element::Scalar(scalar) => {
                    let size = scalar.size();
                    keep_bytes(&mut self.values, slot.at..slot.at + size, &change.bytes[..size]);
                }
                Element::String { .. } | Element::Message(_) => {}
            }
        }
    }
}

impl Step {
    fn length(self) -> usize {
        self.end - self.start
    }
}

impl Slot {
    fn field<'d>(self, plans: &Plans<'d>) -> &'d Field {
        &plans.types.get(self.id).fields()[self.index]
    }
}

/// The bytes of a valid value in memory; zeros for text.
fn bytes_of(field: &Field, leaf: Leaf<'_>) -> [u8; 8] {
    match field.element {
        Element::Scalar(scalar) => leaf.bytes(scalar),
        Element::Text(_) | Element::String { .. } | Element::Message(_) => [0; 8],
    }
}

/// The length of the common prefix of two texts. The prefix is usually long, so blocks of 32 and 8 bytes are compared.
fn common(left: &[u8], right: &[u8]) -> usize {
    let (wide, _) = left.as_chunks::<32>();
    let same =
        wide.iter().zip(right.as_chunks::<32>().0).take_while(|(left, right)| left == right).count() * 32;
    let (left, right) = (&left[same..], &right[same..]);
    let mut length = same;
    for (left, right) in left.as_chunks::<8>().0.iter().zip(right.as_chunks::<8>().0) {
        let differing = u64::from_le_bytes(*left) ^ u64::from_le_bytes(*right);
        if differing != 0 {
            return length + differing.trailing_zeros() as usize / 8;
        }
        length += 8;
    }
    let rest = left.iter().zip(right).skip(length - same);
    length + rest.take_while(|(left, right)| left == right).count()
}

/// Creates a template from a message.
struct Learner<'p> {
    plans: &'p Plans<'p>,
    template: Template,
}

impl Learner<'_> {
    /// Reads an object that contains the message as a member.
    fn around(&mut self, tokens: &mut Tokens<'_>, id: MessageId, message: &str) -> Result<(), Unclear> {
        tokens.members(|tokens, key| {
            if key == message {
                self.message(tokens, id, 0, true)
            } else if TYPE_KEYS.contains(&&*key) {
                tokens.text()?;
                Ok(())
            } else {
                self.step(tokens, None)
            }
        })
    }

    fn message(
        &mut self,
        tokens: &mut Tokens<'_>,
        id: MessageId,
        base: usize,
        is_top: bool,
    ) -> Result<(), Unclear> {
        let fields = self.plans.types.get(id).fields();
        tokens.members(|tokens, key| {
            let index = fields.iter().position(|field| *field.name == *key).ok_or(Unclear)?;
            let field = &fields[index];
            let mut slot =
                Slot { id, index, at: base + field.offset, is_timestamp: is_top && is_timestamp(field) };
            if field.shape == Shape::Single {
                return self.value(tokens, field, slot);
            }
            tokens.list(|tokens| {
                self.value(tokens, field, slot)?;
                slot.at += field.stride;
                Ok(())
            })
        })
    }

    fn value(&mut self, tokens: &mut Tokens<'_>, field: &Field, slot: Slot) -> Result<(), Unclear> {
        match field.element {
            Element::Message(nested) => self.message(tokens, nested, slot.at, false),
            _ => self.step(tokens, Some(slot)),
        }
    }

    fn step(&mut self, tokens: &mut Tokens<'_>, slot: Option<Slot>) -> Result<(), Unclear> {
        tokens.peek();
        let start = tokens.at();
        let token = tokens.token()?;
        let leaf = leaf_of(&token).ok_or(Unclear)?;
        let template = &mut self.template;
        if template.steps.len() == MAX_STEPS {
            return Err(Unclear);
        }
        template.steps.push(Step { start, end: tokens.at(), slot });
        if let Some(slot) = slot {
            let field = slot.field(self.plans);
            keep(field, &mut template.values, slot.at, leaf);
            if slot.is_timestamp {
                template.timestamp = Some(u64::from_le_bytes(bytes_of(field, leaf)));
            }
        }
        Ok(())
    }
}

/// The field of a value, and its offset in memory.
#[derive(Clone, Copy, Debug)]
struct Slot {
    id: MessageId,
    index: usize,
    at: usize,
    is_timestamp: bool,
}
