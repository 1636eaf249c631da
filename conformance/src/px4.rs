//! Messages of PX4: the values that they may have, in memory, as CDR and as JSON, and how definitions of them differ.

pub mod comparison;
pub mod json;
pub mod memory;
pub mod values;

pub use self::values::ValueRules;
