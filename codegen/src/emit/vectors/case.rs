//! Cases, and the rules that they break.

use uavspec_runtime::{Constraint, Number, Rule};

/// The ids of rules on whole messages; the runtime knows those of rules on values.
pub(super) mod rule {
    /// JSON has exactly the fields of the message.
    pub(in super::super) const FIELDS: &str = "PX-JSON-01";
    /// Each value has its field's JSON type and range.
    pub(in super::super) const TYPE: &str = "PX-JSON-02";
    /// An array has its defined length.
    pub(in super::super) const LENGTH: &str = "PX-ARR-01";
    /// A byte of a `bool` is 0 or 1.
    pub(in super::super) const BOOL: &str = "PX-BOOL-01";
    /// A uORB payload has the full size, or the full size less the padding at its end.
    pub(in super::super) const SIZE: &str = "PX-DATA-01";
    /// The encapsulation of a CDR payload is known.
    pub(in super::super) const ENCAPSULATION: &str = "PX-CDR-01";
    /// A CDR payload is neither short nor long for its type.
    pub(in super::super) const PAYLOAD: &str = "PX-CDR-02";
}

/// What is known beforehand of a value, or of a message that holds it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Verdict {
    /// The rule that it breaks.
    pub(super) rule: Option<&'static str>,
    /// Whether the published schema lets it through.
    pub(super) passes_schema: bool,
    /// Whether a message can hold it, and so has bytes.
    pub(super) is_held: bool,
    /// Whether readers that keep all numbers as 64-bit floats can come to this verdict.
    pub(super) suits_doubles: bool,
}

impl Verdict {
    /// Breaks no rule.
    pub(super) const VALID: Self =
        Self { rule: None, passes_schema: true, is_held: true, suits_doubles: true };

    /// Breaks `rule` by its form: no message can hold it.
    pub(super) const fn misshapen(rule: &'static str) -> Self {
        Self { rule: Some(rule), passes_schema: false, is_held: false, suits_doubles: true }
    }

    /// Breaks `rule` in a way that a schema has no words for, and that no message can hold.
    pub(super) const fn unseen(rule: &'static str) -> Self {
        Self { passes_schema: true, ..Self::misshapen(rule) }
    }

    /// What `constraint` says of a number that the type holds.
    pub(super) fn of(constraint: &Constraint<'_>, number: Number) -> Self {
        match constraint.violated_by(number) {
            None => Self::VALID,
            Some(rule) => Self {
                rule: Some(rule.id()),
                // Enums are open to a schema, and each float may be null.
                passes_schema: matches!(rule, Rule::Enum | Rule::Nan),
                ..Self::VALID
            },
        }
    }

    /// Breaks `rule` in its bytes alone.
    pub(super) const fn of_bytes(rule: &'static str) -> Self {
        Self { rule: Some(rule), ..Self::VALID }
    }

    pub(super) fn is_valid(self) -> bool {
        self.rule.is_none()
    }
}

/// A value of a field, or something that is none.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    /// What tells it from others of the field: the end of an id.
    pub(super) name: String,
    /// What it is, in words.
    pub(super) words: String,
    pub(super) json: String,
    pub(super) verdict: Verdict,
    /// A change to the bytes, where the JSON is only there to find their place.
    pub(super) patch: Option<Patch>,
}

/// A change to the bytes of a sample that no JSON leads to.
#[derive(Clone, Debug)]
pub(super) struct Patch {
    /// Another value of the field: the change is made where the bytes of the two begin to differ.
    pub(super) reference: String,
    pub(super) change: Change,
}

/// What is changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Change {
    /// The byte becomes this one.
    Byte(u8),
    /// The length that begins there in CDR grows by [`GROWTH`], and as many elements follow it.
    Growth {
        /// Bytes of an element.
        size: usize,
        /// The first byte of each; the others are zero, which makes it a number in little-endian order.
        filler: u8,
    },
}

/// By how many elements a sequence grows beyond its bound: so many take a multiple of eight bytes
/// whatever their size, and the alignment of all that follows stays as it is.
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

    /// A value that the field's type doesn't have.
    pub(super) fn mistyped(name: &'static str, words: impl Into<String>, json: impl Into<String>) -> Self {
        Self::new(name, words, json, Verdict::misshapen(rule::TYPE))
    }

    /// The same with the bytes changed where they begin to differ from those of `reference`.
    pub(super) fn patched(self, reference: impl Into<String>, change: Change) -> Self {
        Self { patch: Some(Patch { reference: reference.into(), change }), ..self }
    }

    /// The sample as a part of something: what `json` makes of its JSON.
    pub(super) fn within(&self, json: impl Fn(&str) -> String) -> Self {
        let patch = self.patch.as_ref();
        Self {
            json: json(&self.json),
            patch: patch.map(|patch| Patch { reference: json(&patch.reference), change: patch.change }),
            ..self.clone()
        }
    }
}

/// A case as it is printed.
#[derive(Clone, Debug, Default)]
pub(super) struct Case {
    pub(super) id: String,
    pub(super) description: String,
    /// The rule that it breaks; none where it is valid.
    pub(super) rule: Option<&'static str>,
    /// The message as JSON; what the bytes decode to, and encode from.
    pub(super) json: Option<String>,
    /// What the bytes decode to, where encoding gives other ones.
    pub(super) decoded: Option<String>,
    pub(super) uorb: Option<Vec<u8>>,
    pub(super) cdr: Option<Vec<u8>>,
    /// Of an error code, its class and severity.
    pub(super) class: Option<(&'static str, &'static str)>,
    /// What the published schema says of the JSON; none where that isn't to be tested.
    pub(super) schema_verdict: Option<bool>,
}
