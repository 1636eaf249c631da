//! The sources that rules cite: parts of the specification.

pub(super) const GENERAL: &str = "Flockwave 2.10, general description of messages";
pub(super) const SCHEMA: &str = "Flockwave 2.10, published JSON Schema";
pub(super) const TRANSPORT: &str = "Flockwave 2.10, transport";
pub(super) const TYPES: &str = "Flockwave 2.10, types";
pub(super) const ERRORS: &str = "Flockwave 2.10, error codes";
pub(super) const ASYNC: &str = "Flockwave 2.10, asynchronous operations";
pub(super) const MESSAGES: &str = "Flockwave 2.10, description of the message";
pub(super) const DERIVED: &str = "derived from Flockwave 2.10";
