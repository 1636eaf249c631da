//! The plans of a log's formats, which the logs of a run share.

use std::collections::HashMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use uavspec_codegen::dynamic::MessageType;
use uavspec_codegen::schema::{MessageId, Schema};

use super::ValueRules;
use super::comparison::Comparison;
use super::memory::{Plan, shared_fields, time_offset};
use crate::capture::ulog::FormatSet;

/// The maximum number of sets whose plans are kept for the same definitions.
const MAX_SETS: usize = 4;

/// The check of the messages with a format.
#[derive(Debug)]
pub(crate) struct FormatPlan {
    /// The checks of the values.
    pub(crate) values: Plan,
    /// The number of fields that the format and the definition share, and of all fields.
    pub(crate) shared_fields: (u64, u64),
    /// The offset of `timestamp` in the payload.
    pub(crate) timestamp: Option<usize>,
    /// The offset of `time_utc_usec` in the payload, the time of a satellite navigation receiver.
    pub(crate) utc: Option<usize>,
}

impl FormatPlan {
    /// Compiles the plan for a format and its definition.
    pub(crate) fn new(
        format: MessageType<'_>,
        definition: Option<MessageId>,
        schema: &Schema,
        rules: &'static ValueRules,
    ) -> Self {
        Self {
            values: Plan::new(format, definition, schema, format.name(), rules),
            shared_fields: shared_fields(format, definition, schema),
            timestamp: time_offset(format, "timestamp"),
            utc: time_offset(format, "time_utc_usec"),
        }
    }
}

/// The maximum total number of steps in the plans of a set. Real sets have a few thousand. Other plans are compiled for
/// each topic.
const MAX_STEPS: usize = 1 << 14;

/// The plans of a set of formats, by name. Each is created when it is needed.
#[derive(Debug)]
pub(crate) struct FormatPlans {
    by_name: HashMap<Box<str>, Lazy>,
    /// The total number of steps.
    steps: AtomicUsize,
}

/// What is known about a format.
#[derive(Debug, Default)]
struct Lazy {
    plan: OnceLock<Arc<FormatPlan>>,
    comparison: OnceLock<Comparison>,
}

impl FormatPlans {
    fn new(formats: &FormatSet) -> Self {
        let by_name = formats.types().iter().map(|format| (format.name().into(), Lazy::default()));
        Self { by_name: by_name.collect(), steps: AtomicUsize::new(0) }
    }

    /// The plan of a format, which `compile` creates.
    pub(crate) fn plan(&self, format: &str, compile: impl FnOnce() -> FormatPlan) -> Arc<FormatPlan> {
        let known = self.by_name.get(format);
        if let Some(plan) = known.and_then(|known| known.plan.get()) {
            return Arc::clone(plan);
        }
        let plan = Arc::new(compile());
        let size = plan.values.steps();
        if self.steps.fetch_add(size, Ordering::Relaxed) + size <= MAX_STEPS
            && let Some(known) = known
        {
            // Another thread may have compiled the same plan.
            return Arc::clone(known.plan.get_or_init(|| plan));
        }
        plan
    }

    /// The result of comparing a format with its definition.
    pub(crate) fn comparison(&self, format: &str, compare: impl FnOnce() -> Comparison) -> Comparison {
        match self.by_name.get(format) {
            Some(known) => known.comparison.get_or_init(compare).clone(),
            None => compare(),
        }
    }
}

/// The plans of the formats that were compared with the same definitions.
#[derive(Debug, Default)]
pub(crate) struct PlanCache(Mutex<Vec<(Arc<FormatSet>, Arc<FormatPlans>)>>);

impl PlanCache {
    /// The plans of a set of formats.
    pub(crate) fn get(&self, formats: &Arc<FormatSet>) -> Arc<FormatPlans> {
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
