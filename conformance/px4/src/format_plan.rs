//! The plans of a log's formats, which the logs of a run share.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use uavspec_capture::ulog::FormatSet;
use uavspec_dynamic::MessageType;

use super::ValueRules;
use super::comparison::Comparison;
use super::memory::{FieldCounts, Plan, shared_fields, time_offset};

/// The maximum number of sets whose plans are kept for the same definitions.
const MAX_SETS: usize = 4;

/// The check of the messages with a format.
#[derive(Debug)]
pub struct FormatPlan {
    /// The checks of the values. `None` if there are too many fields.
    pub values: Option<Plan>,
    /// The number of fields that the format and the definition share, and of all fields.
    pub shared_fields: (u64, u64),
    /// The offset of `timestamp` in the payload.
    pub timestamp: Option<usize>,
    /// The offset of `time_utc_usec` in the payload, the time of a satellite navigation receiver.
    pub utc: Option<usize>,
}

impl FormatPlan {
    /// Compiles the plan for a format and its definition, with or without the checks of the values.
    pub fn new(
        format: MessageType<'_>,
        defined: Option<MessageType<'_>>,
        rules: &'static ValueRules,
        has_values: bool,
    ) -> Self {
        let (shared, all) = shared_fields(format, defined);
        Self {
            values: has_values.then(|| Plan::new(format, defined, rules)),
            shared_fields: (if has_values { shared } else { 0 }, all),
            timestamp: time_offset(format, "timestamp"),
            utc: time_offset(format, "time_utc_usec"),
        }
    }
}

/// The maximum number of fields in the formats of a set whose values are checked, with the fields of each nested message.
/// Real sets have a few thousand. Without a limit, nested arrays could multiply the fields indefinitely.
const MAX_FIELDS: usize = 1 << 16;

/// The plans of a set of formats, by name. Each is created when it is needed.
#[derive(Debug)]
pub struct FormatPlans {
    by_name: HashMap<Box<str>, Lazy>,
}

/// What is known about a format.
#[derive(Debug)]
struct Lazy {
    /// True if the values are checked: the formats before leave room for the fields of this one.
    has_values: bool,
    plan: OnceLock<Arc<FormatPlan>>,
    comparison: OnceLock<Comparison>,
}

impl FormatPlans {
    fn new(formats: &FormatSet) -> Self {
        let (mut counts, mut room) = (FieldCounts::default(), MAX_FIELDS);
        let by_name = formats.types().iter().map(|format| {
            let rest = room.checked_sub(counts.of(format));
            let has_values = rest.is_some();
            room = rest.unwrap_or(room);
            let lazy = Lazy { has_values, plan: OnceLock::new(), comparison: OnceLock::new() };
            (format.name().into(), lazy)
        });
        Self { by_name: by_name.collect() }
    }

    /// The plan of a format. `compile` creates it, with or without the checks of the values.
    pub fn plan(&self, format: &str, compile: impl FnOnce(bool) -> FormatPlan) -> Arc<FormatPlan> {
        match self.by_name.get(format) {
            Some(known) => Arc::clone(known.plan.get_or_init(|| Arc::new(compile(known.has_values)))),
            None => Arc::new(compile(false)),
        }
    }

    /// The result of comparing a format with its definition.
    pub fn comparison(&self, format: &str, compare: impl FnOnce() -> Comparison) -> Comparison {
        match self.by_name.get(format) {
            Some(known) => known.comparison.get_or_init(compare).clone(),
            None => compare(),
        }
    }
}

/// The plans of the formats that were compared with the same definitions.
#[derive(Debug, Default)]
pub struct PlanCache(Mutex<Vec<(Arc<FormatSet>, Arc<FormatPlans>)>>);

impl PlanCache {
    /// The plans of a set of formats.
    pub fn get(&self, formats: &Arc<FormatSet>) -> Arc<FormatPlans> {
        let plans = || Arc::new(FormatPlans::new(formats));
        if !formats.is_shared {
            return plans();
        }
        let mut sets = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, known)) = sets.iter().find(|(known, _)| Arc::ptr_eq(known, formats)) {
            return Arc::clone(known);
        }
        if sets.len() >= MAX_SETS {
            sets.remove(0);
        }
        let plans = plans();
        sets.push((Arc::clone(formats), Arc::clone(&plans)));
        plans
    }
}
