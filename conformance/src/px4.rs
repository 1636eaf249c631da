//! Messages of PX4: the values that they may have, in memory, as CDR and as JSON, and how definitions of them differ.

pub(crate) mod comparison;
pub(crate) mod json;
pub(crate) mod memory;
pub(crate) mod values;

pub(crate) use self::values::ValueRules;
