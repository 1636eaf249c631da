//! `PX-CDR-01`.

use super::{Check, Level, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-CDR-01",
    level: Level::Must,
    statement: "The encapsulation header of a CDR payload names an encoding that exists. Those that aren't plain CDR of version 1 are known, and their messages aren't judged.",
    source: "DDSI-RTPS 2.5, section 10.5, and DDS-XTypes 1.3, table 60",
    check: Check::Source,
};
