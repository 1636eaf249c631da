//! Test cases and the rules that they violate.

use uavspec_runtime::{Constraint, ConstraintKind, Number};

/// Ids of rules about complete messages. The runtime defines the ids of rules about values.
pub(super) mod rule {
    /// JSON contains exactly the fields of the message.
    pub(in super::super) const FIELDS: &str = "PX-JSON-01";
    /// A value has the JSON type and range of its field.
    pub(in super::super) const TYPE: &str = "PX-JSON-02";
    /// An array has the declared length.
    pub(in super::super) const LENGTH: &str = "PX-ARR-01";
    /// The byte of a `bool` is 0 or 1.
    pub(in super::super) const BOOL: &str = "PX-BOOL-01";
    /// A uORB payload has the full size, or the size without trailing padding.
    pub(in super::super) const SIZE: &str = "PX-DATA-01";
    /// The encapsulation of a CDR payload is known.
    pub(in super::super) const ENCAPSULATION: &str = "PX-CDR-01";
    /// The length of a CDR payload matches its type.
    pub(in super::super) const PAYLOAD: &str = "PX-CDR-02";
}

/// The expected result for a value, or for a message that contains it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Verdict {
    /// The violated rule.
    pub(super) rule: Option<&'static str>,
    /// True if the published schema accepts the value.
    pub(super) passes_schema: bool,
    /// True if the value can be encoded in a message.
    pub(super) is_encodable: bool,
    /// True if readers that store all numbers as 64-bit floats reach the same verdict.
    pub(super) suits_doubles: bool,
}

impl Verdict {
    /// A valid value.
    pub(super) const VALID: Self =
        Self { rule: None, passes_schema: true, is_encodable: true, suits_doubles: true };

    /// A value that violates `rule` and can't be encoded.
    pub(super) const fn malformed(rule: &'static str) -> Self {
        Self { rule: Some(rule), passes_schema: false, is_encodable: false, suits_doubles: true }
    }

    /// Like [`Self::malformed`], but for a rule that the schema can't express, so the schema accepts the value.
    pub(super) const fn accepted_by_schema(rule: &'static str) -> Self {
        Self { passes_schema: true, ..Self::malformed(rule) }
    }

    /// The verdict of `constraint` on a number of the right type.
    pub(super) fn of(constraint: &Constraint<'_>, number: Number) -> Self {
        match constraint.violated_by(number) {
            None => Self::VALID,
            Some(rule) => Self {
                rule: Some(rule.id()),
                // In schemas, enums are open and floats may be null.
                passes_schema: matches!(rule, ConstraintKind::Enum | ConstraintKind::Nan),
                ..Self::VALID
            },
        }
    }

    /// Bytes that violate `rule`.
    pub(super) const fn invalid_bytes(rule: &'static str) -> Self {
        Self { rule: Some(rule), ..Self::VALID }
    }

    pub(super) fn is_valid(self) -> bool {
        self.rule.is_none()
    }
}

/// A valid or invalid field value.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    /// Suffix of the case id, unique within the field.
    pub(super) name: String,
    /// Description.
    pub(super) words: String,
    pub(super) json: String,
    pub(super) verdict: Verdict,
    /// A change to the bytes. If there is a change, `json` is used only to locate it.
    pub(super) patch: Option<Patch>,
}

/// A change to the encoded bytes of a sample.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// Another value of the field. The change applies at the first byte where the two encodings differ.
    pub(super) reference: String,
    pub(super) change: Change,
}

/// A change to bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Change {
    /// Replaces one byte.
    Byte(u8),
    /// Increases the sequence length in CDR by [`GROWTH`], and inserts that many elements.
    Growth {
        /// Size of an element in bytes.
        size: usize,
        /// The first byte of each element. The other bytes are zero, so an element is a small little-endian number.
        filler: u8,
    },
}

/// The number of elements that are added to a sequence to exceed its bound. Eight elements of any size preserve the
/// alignment of the following data.
pub(super) const GROWTH: u32 = 8;

impl Sample {
    pub(super) fn new(
        name: impl Into<String>,
        words: impl Into<String>,
        json: impl Into<String>,
        verdict: Verdict,
    ) -> Self {
        Self { name: name.into(), words: words.into(), json: json.into(), verdict, patch: None }
    }

    /// A value of the wrong type.
    pub(super) fn mistyped(name: &'static str, words: impl Into<String>, json: impl Into<String>) -> Self {
        Self::new(name, words, json, Verdict::malformed(rule::TYPE))
    }

    /// Adds a change at the first byte where the encoding differs from the encoding of `reference`.
    pub(super) fn patched(self, reference: impl Into<String>, change: Change) -> Self {
        Self { patch: Some(Patch { reference: reference.into(), change }), ..self }
    }

    /// Embeds the sample in a larger value, which the function `json` creates.
    pub(super) fn within(&self, json: impl Fn(&str) -> String) -> Self {
        let patch = self.patch.as_ref();
        Self {
            json: json(&self.json),
            patch: patch.map(|patch| Patch { reference: json(&patch.reference), change: patch.change }),
            ..self.clone()
        }
    }
}

/// A test case, ready to print.
#[derive(Clone, Debug, Default)]
pub(super) struct Case {
    pub(super) id: String,
    pub(super) description: String,
    /// The violated rule, or `None` for a valid case.
    pub(super) rule: Option<&'static str>,
    /// The message as JSON. Present only if it encodes to the bytes and the bytes decode to it.
    pub(super) json: Option<String>,
    /// The decoded value as JSON. Present only if re-encoding it produces different bytes.
    pub(super) decoded: Option<String>,
    pub(super) uorb: Option<Vec<u8>>,
    pub(super) cdr: Option<Vec<u8>>,
    /// The arguments of an event.
    pub(super) arguments: Option<Vec<u8>>,
    /// The message and the description of an event, by profile.
    pub(super) texts: Vec<(&'static str, [String; 2])>,
    /// Class and severity of an error code.
    pub(super) class: Option<(&'static str, &'static str)>,
    /// The published schema's verdict on the JSON. `None` if the verdict is not tested.
    pub(super) schema_verdict: Option<bool>,
}
