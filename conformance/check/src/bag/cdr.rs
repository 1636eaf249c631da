//! Checks the CDR messages of a channel.

use std::borrow::Cow;
use std::io::Read as _;
use std::sync::Arc;

use uavspec_capture::input::zstd::{self, MAGIC as ZSTD};
use uavspec_capture::limits::MAX_RECORD;
use uavspec_dynamic::{DynamicView, MessageType};
use uavspec_model::{Channel, Detail, Findings, Location, Rule, hexadecimal};
use uavspec_px4::memory::{Plan, shared_fields, time_offset};
use uavspec_rules::definitions::{Definitions, Stated};
use uavspec_rules::px4;
use uavspec_runtime::cdr::{ByteOrder, HEADER};
use uavspec_schema::msg::{Dialect, Kind};
use uavspec_schema::{Form, MessageId};

use crate::coverage::Share;

/// A decoded message.
pub(super) struct Seen {
    /// The value of the `timestamp` field, if there is one.
    pub(super) timestamp: Option<u64>,
}

/// The source of the type of a channel's messages.
#[derive(Clone)]
pub(super) enum TypeSource {
    /// The definition, which equals the schema in the file if there is one.
    Definition(MessageId),
    /// The schema in the file, which differs from the definition.
    Differing(Arc<Stated>, MessageId),
    /// The schema in the file. There is no definition.
    Own(Arc<Stated>),
}

impl TypeSource {
    /// The definition of the channel.
    fn definition(&self) -> Option<MessageId> {
        match self {
            Self::Definition(id) | Self::Differing(_, id) => Some(*id),
            Self::Own(_) => None,
        }
    }

    /// The type of the messages.
    pub(super) fn message_type<'t>(&'t self, definitions: &'t Definitions) -> MessageType<'t> {
        match self {
            Self::Definition(id) => definitions.types().get(*id),
            Self::Differing(stated, _) | Self::Own(stated) => stated.root(),
        }
    }
}

/// The checker for the messages of a channel, with counts.
pub(super) struct CdrChecker {
    source: TypeSource,
    plan: Plan,
    /// The offset of `timestamp` in memory.
    timestamp: Option<usize>,
    /// The number of payloads whose header was checked.
    headers: u64,
    bodies: u64,
    /// The number of decoded messages.
    messages: u64,
    /// The number of payloads in unsupported CDR encodings.
    others: u64,
}

impl CdrChecker {
    pub(super) fn new(source: TypeSource, definitions: &Definitions) -> Self {
        let ty = source.message_type(definitions);
        let defined = source.definition().map(|id| definitions.types().get(id));
        let plan = Plan::new(ty, defined, &px4::VALUES);
        Self {
            plan,
            timestamp: time_offset(ty, "timestamp"),
            source,
            headers: 0,
            bodies: 0,
            messages: 0,
            others: 0,
        }
    }

    /// The share of the messages' fields that are checked. If the schema in the file differs from the definition, only
    /// the shared fields are checked.
    pub(super) fn fields(&self, definitions: &Definitions) -> Share {
        let message_type = self.source.message_type(definitions);
        let num_fields = message_type.fields().len() as u64;
        let (shared, all) = match self.source {
            TypeSource::Differing(_, id) => shared_fields(message_type, Some(definitions.types().get(id))),
            TypeSource::Definition(_) | TypeSource::Own(_) => (num_fields, num_fields),
        };
        Share::of(shared, all)
    }

    /// True if the messages lack the timestamp that PX4 requires. `None` for messages of other packages, and for services.
    pub(super) fn lacks_timestamp(&self, definitions: &Definitions) -> Option<bool> {
        let schema = &definitions.schema;
        let message = schema.message(self.source.definition()?);
        let is_px4 = schema.package_of(message).form == Form::Msg(Dialect::Px4);
        (is_px4 && message.kind == Kind::Message).then_some(self.timestamp.is_none())
    }

    /// Checks a payload, and stores the field values in `memory`. Returns `None` if the payload can't be decoded.
    pub(super) fn check(
        &mut self,
        payload: &[u8],
        memory: &mut Vec<u8>,
        channel: &Channel<'_>,
        location: Location,
        definitions: &Definitions,
        findings: &mut Findings,
    ) -> Option<Seen> {
        let definition = self.source.definition().map(|id| definitions.schema.message(id).span);
        let mut report = |rule: &'static Rule, detail: Detail| {
            let excerpt = || detail.excerpt(hexadecimal(payload));
            findings.report(rule, channel.subject(), location, definition, excerpt);
        };
        let [first, second, _, _, ..] = *payload else {
            self.bodies += 1;
            let expected = format!("a header of {HEADER} bytes");
            report(&px4::CDR_02.rule, Detail::differs(expected, payload.len()));
            return None;
        };
        self.headers += 1;
        match (ByteOrder::of(payload), [first, second]) {
            (Ok(_), _) => self.bodies += 1,
            // Parameter lists and CDR version 2.
            (Err(_), [0, 2 | 3 | 6..=0xb]) => {
                self.others += 1;
                return None;
            }
            (Err(_), found) => {
                let expected = "00 01 (little endian) or 00 00 (big endian)";
                report(&px4::CDR_01.rule, Detail::differs(expected, hexadecimal(&found)));
                return None;
            }
        }
        let message_type = self.source.message_type(definitions);
        let message = match message_type.decode_cdr_in(payload, std::mem::take(memory)) {
            Ok(message) => message,
            Err(error) => {
                report(&px4::CDR_02.rule, Detail::new(error.to_string()));
                return None;
            }
        };
        self.plan.check(message.memory(), channel.subject(), location, findings);
        *memory = message.into_memory();
        self.messages += 1;
        let timestamp =
            self.timestamp.and_then(|at| Some(u64::from_le_bytes(*memory.get(at..)?.first_chunk()?)));
        Some(Seen { timestamp })
    }

    /// The field values that [`Self::check`] stored.
    pub(super) fn view<'v>(
        &'v self,
        memory: &'v [u8],
        definitions: &'v Definitions,
    ) -> Option<DynamicView<'v>> {
        self.source.message_type(definitions).view_memory(memory).ok()
    }

    /// Adds the coverage of rules. Returns the number of payloads in unsupported CDR encodings.
    pub(super) fn close(self, findings: &mut Findings) -> u64 {
        findings.cover(&px4::CDR_01.rule, self.headers);
        findings.cover(&px4::CDR_02.rule, self.bodies);
        self.plan.count(self.messages, findings);
        self.others
    }
}

/// Decompresses a payload if rosbag2 compressed each message separately. Zstd data can't be confused with an
/// encapsulation header.
pub fn decompressed(payload: &[u8]) -> Result<Cow<'_, [u8]>, String> {
    if !payload.starts_with(&ZSTD) {
        return Ok(Cow::Borrowed(payload));
    }
    let mut bytes = Vec::new();
    let read =
        zstd::decompress(payload).and_then(|frames| frames.take(MAX_RECORD + 1).read_to_end(&mut bytes));
    match read {
        Ok(_) if bytes.len() as u64 > MAX_RECORD => {
            Err(format!("the compressed message has more than {MAX_RECORD} bytes"))
        }
        Ok(_) => Ok(Cow::Owned(bytes)),
        Err(error) => Err(format!("the message can't be decompressed: {error}")),
    }
}
