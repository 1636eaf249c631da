//! All cases of a message.

use uavspec_dynamic::Types;
use uavspec_schema::{Dialect, Form, Kind, Message, MessageId, Package, Schema};

use super::bytes::{Bytes, Codec, grown, replaced};
use super::case::{Case, Change, Sample, Verdict, rule};
use super::field::message_typical;
use super::part::Parts;
use super::sample::MessageSamples;
use super::typical::Typical;

/// Maximum estimated JSON size, in bytes, of the cases for one message. The size grows quadratically with the number of
/// fields, because each field has cases and each case contains all fields. Larger messages have no cases for single
/// fields.
const MOST_JSON: usize = 1 << 22;

/// The cases of a message. The list is empty if the message has no valid value, is too long, or is nested too deeply.
pub(super) fn cases(schema: &Schema, id: MessageId, parts: &Parts, types: &Types) -> Vec<Case> {
    let message = schema.message(id);
    let Some(samples) = parts.get(id).and_then(|_| MessageSamples::new(schema, message, parts)) else {
        return Vec::new();
    };
    let codec = Codec::new(types.get(id), is_uorb(schema.package_of(message), message));
    let typical = message_typical(schema, message, parts, &mut Typical::default());
    let mut cases = Cases { samples, codec, done: Vec::new() };
    cases.whole(typical.as_deref());
    if cases.samples.zero().len().saturating_mul(message.fields.len()) <= MOST_JSON {
        for index in 0..message.fields.len() {
            cases.field(index);
        }
    }
    if let Some(typical) = typical {
        cases.uorb(message, &typical);
        cases.cdr(&typical);
    }
    cases.done
}

struct Cases<'s> {
    samples: MessageSamples<'s>,
    codec: Codec<'s>,
    done: Vec<Case>,
}

impl Cases<'_> {
    fn whole(&mut self, typical: Option<&str>) {
        let zero = self.samples.zero();
        self.push("zero", "all fields have the valid value nearest to zero", zero, Verdict::VALID);
        if let Some(typical) = typical {
            let words = "adjacent bytes differ, so swapped or shifted bytes are detected";
            self.push("typical", words, typical.to_owned(), Verdict::VALID);
        }
        let extended = self.samples.extended();
        self.push("extra", "an additional field", extended, Verdict::malformed(rule::FIELDS));
        let mistyped = Verdict::malformed(rule::TYPE);
        self.push("null", "null instead of an object", "null".to_owned(), mistyped);
        self.push("array", "an array instead of an object", "[]".to_owned(), mistyped);
    }

    fn field(&mut self, index: usize) {
        let name = self.samples.message.fields[index].name.clone();
        for sample in std::mem::take(&mut self.samples.samples[index]) {
            let id = format!("{name}-{}", sample.name);
            let description = format!("{name}: {}", sample.words);
            let json = self.samples.with(index, &sample.json);
            match &sample.patch {
                Some(patch) => {
                    let reference = self.samples.with(index, &patch.reference);
                    self.patched(id, description, (&reference, &json), patch.change, &sample);
                }
                None => self.push(id, description, json, sample.verdict),
            }
        }
        let without = self.samples.without(index);
        let description = format!("{name} is missing");
        self.push(format!("{name}-missing"), description, without, Verdict::malformed(rule::FIELDS));
    }

    fn push(
        &mut self,
        id: impl Into<String>,
        description: impl Into<String>,
        json: String,
        verdict: Verdict,
    ) {
        let bytes = if verdict.is_encodable { self.codec.encode(&json) } else { Bytes::default() };
        self.done.push(Case {
            id: id.into(),
            description: description.into(),
            rule: verdict.rule,
            uorb: bytes.uorb,
            cdr: bytes.cdr,
            schema_verdict: verdict.suits_doubles.then_some(verdict.passes_schema),
            json: Some(json),
            ..Case::default()
        });
    }

    /// Adds a case that consists of bytes only.
    fn patched(
        &mut self,
        id: String,
        description: String,
        (reference, json): (&str, &str),
        change: Change,
        sample: &Sample,
    ) {
        let (before, after) = (self.codec.encode(reference), self.codec.encode(json));
        let (uorb, cdr) = match change {
            Change::Byte(byte) => {
                let patch =
                    |before: Option<Vec<u8>>, after: Option<Vec<u8>>| replaced(&before?, after?, byte);
                (patch(before.uorb, after.uorb), patch(before.cdr, after.cdr))
            }
            Change::Growth { size, filler } => {
                let cdr = before.cdr.zip(after.cdr);
                (None, cdr.and_then(|(before, after)| grown(&before, &after, size, filler)))
            }
        };
        if uorb.is_some() || cdr.is_some() {
            self.done.push(Case { id, description, rule: sample.verdict.rule, uorb, cdr, ..Case::default() });
        }
    }

    // The ids of byte-only cases have a dot before any hyphen, so they differ from the ids of field cases.

    /// Adds uORB payloads: one without trailing padding, one with nonzero padding, and several with invalid sizes.
    fn uorb(&mut self, message: &Message, typical: &str) {
        let (Some(layout), Some(bytes)) = (&message.uorb, self.codec.encode(typical).uorb) else { return };
        let (size, no_padding) = (layout.size, layout.size_no_padding);
        let resized = |size: usize| {
            let mut bytes = bytes.clone();
            bytes.resize(size, 0);
            bytes
        };
        let mut push = |id: &str, words: &str, rule, bytes: Vec<u8>| {
            self.done.push(Case { uorb: Some(bytes), ..payload(id, words, rule, typical) });
        };
        if no_padding < size {
            push("uorb.no-padding", "without trailing padding, as in logs", None, resized(no_padding));
        }
        let mut dirty = bytes.clone();
        for slot in layout.slots.iter().filter(|slot| slot.field.is_none()) {
            if let Some(padding) = dirty.get_mut(slot.offset..slot.offset + slot.size) {
                padding.fill(0xaa);
            }
        }
        if dirty != bytes {
            push("uorb.dirty-padding", "nonzero padding", None, dirty);
        }
        let violated = Some(rule::SIZE);
        if let Some(short) = no_padding.checked_sub(1) {
            push("uorb.short", "one byte shorter than the size without padding", violated, resized(short));
        }
        if size > no_padding + 1 {
            push("uorb.part-of-padding", "part of the trailing padding", violated, resized(no_padding + 1));
        }
        push("uorb.long", "one byte longer than the full size", violated, resized(size + 1));
    }

    /// Adds CDR payloads that differ in the header or at the end.
    fn cdr(&mut self, typical: &str) {
        let Some(bytes) = self.codec.encode(typical).cdr else { return };
        let big_endian = self.codec.big_endian(typical);
        let mut push = |id: &str, words: &str, rule, bytes: Vec<u8>| {
            self.done.push(Case { cdr: Some(bytes), ..payload(id, words, rule, typical) });
        };
        if let Some(big_endian) = big_endian {
            push("cdr.big-endian", "a big-endian payload, as declared in the header", None, big_endian);
        }
        let filled = bytes.len().next_multiple_of(4);
        if filled > bytes.len() {
            let mut bytes = bytes.clone();
            bytes.resize(filled, 0);
            push("cdr.filled", "padded to a multiple of four bytes, as some writers do", None, bytes);
        }
        let mut unknown = bytes.clone();
        unknown[..2].fill(0xff);
        push(
            "cdr.encapsulation",
            "a header with an unknown encapsulation",
            Some(rule::ENCAPSULATION),
            unknown,
        );
        let violated = Some(rule::PAYLOAD);
        push("cdr.short", "the last byte is missing", violated, bytes[..bytes.len() - 1].to_vec());
        let mut long = bytes;
        long.resize(filled + 4, 0);
        push("cdr.long", "four bytes after the padding", violated, long);
    }
}

/// A case without bytes. The caller adds bytes that decode to `typical` or violate `rule`.
fn payload(id: &str, words: &str, rule: Option<&'static str>, typical: &str) -> Case {
    let decoded = rule.is_none().then(|| typical.to_owned());
    Case { id: id.to_owned(), description: words.to_owned(), rule, decoded, ..Case::default() }
}

/// True if the message has a uORB payload. A message in a dialect other than PX4's has no uORB payload, even if its
/// size is fixed.
pub(super) fn is_uorb(package: &Package, message: &Message) -> bool {
    package.form == Form::Msg(Dialect::Px4) && message.kind == Kind::Message
}
