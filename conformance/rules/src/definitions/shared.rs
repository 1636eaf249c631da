//! The data that the captures of a run share. Most captures of an archive come from the same firmware.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError, Weak};

use sha2::{Digest as _, Sha256};
use uavspec_capture::ulog::{Compiled, SharedFormats};
use uavspec_dynamic::MessageType;
use uavspec_model::Recent;
use uavspec_px4::comparison::{Comparison, compare};
use uavspec_px4::event::EventMetadata;
use uavspec_px4::memory::{FieldCounts, Plan, shared_fields, time_offset};

use super::{Definitions, Stated};
use crate::limits::{MAX_SHARED_EVENTS, MAX_SHARED_FIELDS, MAX_SHARED_SCHEMA, MAX_SHARED_SCHEMAS};
use crate::px4;

/// The data that captures share, even if they are checked against different definitions.
#[derive(Debug, Default)]
pub struct Shared {
    /// The formats of logs.
    pub formats: Arc<SharedFormats>,
    events: Recent<CapturedEvents, MAX_SHARED_EVENTS>,
    schemas: Recent<SharedSchema, MAX_SHARED_SCHEMAS>,
}

/// A schema in a bag.
#[derive(Debug)]
struct SharedSchema {
    name: String,
    text: Box<[u8]>,
    stated: Result<Arc<Stated>, String>,
}

/// The event metadata in a capture.
#[derive(Debug)]
pub struct CapturedEvents {
    bytes: Box<[u8]>,
    /// The SHA-256 hash of the bytes, in hexadecimal digits.
    pub sha256: String,
    /// The metadata, and the first reason why not all events can be decoded. The error is the reason why no event can be
    /// decoded.
    pub read: Result<(Arc<EventMetadata>, Option<String>), String>,
}

/// A format of a log, compared with its definition.
#[derive(Debug)]
pub struct FormatPlan {
    /// The result of the comparison.
    pub comparison: Comparison,
    /// The number of fields that the format and the definition share, and the number of all fields.
    pub fields: (u64, u64),
    /// The number of fields, including the fields of each nested message.
    pub all_fields: usize,
    /// The offset of `timestamp` in the payload.
    pub timestamp: Option<usize>,
    /// The offset of `time_utc_usec` in the payload. This field contains the time of a satellite navigation receiver.
    pub utc: Option<usize>,
    values: OnceLock<Arc<Plan>>,
}

impl Shared {
    /// Reads the type in the text of a `ros2msg` schema.
    pub fn stated(&self, name: &str, text: &[u8]) -> Result<Arc<Stated>, String> {
        let read = || Stated::read(name, text).map(Arc::new);
        if text.len() > MAX_SHARED_SCHEMA {
            return read();
        }
        let make = || SharedSchema { name: name.to_owned(), text: text.into(), stated: read() };
        self.schemas.get(|known| *known.text == *text && known.name == name, make).stated.clone()
    }
}

impl FormatPlan {
    /// The checks of the values, compiled when they are first needed.
    pub fn values(&self, format: MessageType<'_>, definitions: &Definitions) -> Arc<Plan> {
        let compile = || Arc::new(Plan::new(format, definitions.of_format(format), &px4::VALUES));
        Arc::clone(self.values.get_or_init(compile))
    }
}

/// The plans for the formats of a log, by topic.
#[derive(Debug)]
pub(super) struct FormatPlans {
    compiled: Weak<Compiled>,
    by_topic: Mutex<HashMap<String, Arc<FormatPlan>>>,
}

impl Definitions {
    /// Reads the event metadata in a capture.
    pub fn read_events(&self, bytes: &[u8]) -> Arc<CapturedEvents> {
        let read = || {
            let (metadata, mistake) = EventMetadata::of_capture(bytes).map_err(|error| error.to_string())?;
            Ok((Arc::new(metadata), mistake.map(|mistake| mistake.to_string())))
        };
        let make = || CapturedEvents {
            bytes: bytes.into(),
            sha256: Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect(),
            read: read(),
        };
        self.shared.events.get(|known| *known.bytes == *bytes, make)
    }

    /// The definition of the topic that a format in a log belongs to.
    fn of_format(&self, format: MessageType<'_>) -> Option<MessageType<'_>> {
        self.message_of_logged_topic(format.name()).map(|id| self.types().get(id))
    }

    /// The plan for a format among the formats of a log.
    pub fn plan(&self, format: MessageType<'_>, compiled: &Arc<Compiled>) -> Arc<FormatPlan> {
        let make = || FormatPlans { compiled: Arc::downgrade(compiled), by_topic: Mutex::default() };
        let plans = self.plans.get(|known| known.compiled.as_ptr() == Arc::as_ptr(compiled), make);
        let mut by_topic = plans.by_topic.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = by_topic.get(format.name()) {
            return Arc::clone(known);
        }
        let defined = self.of_format(format);
        let plan = Arc::new(FormatPlan {
            comparison: defined.map_or(Comparison::Undefined, |defined| compare(format, defined)),
            fields: shared_fields(format, defined),
            all_fields: FieldCounts::default().of(format),
            timestamp: time_offset(format, "timestamp"),
            utc: time_offset(format, "time_utc_usec"),
            values: OnceLock::new(),
        });
        if plan.all_fields <= MAX_SHARED_FIELDS {
            by_topic.insert(format.name().to_owned(), Arc::clone(&plan));
        }
        plan
    }
}
