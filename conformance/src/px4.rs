//! PX4 messages: rules on values in memory, CDR and JSON, and comparison with definitions.

pub(crate) mod comparison;
pub(crate) mod format;
pub(crate) mod format_plan;
pub(crate) mod json;
pub(crate) mod memory;
pub(crate) mod values;

pub(crate) use self::values::ValueRules;
