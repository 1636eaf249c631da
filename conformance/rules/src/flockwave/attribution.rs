//! Attributions: which body schema violations a specific rule reports instead of `FW-ENV-18`.
//!
//! If the specification contradicts itself about a value, `FW-ENV-26` reports the value.

use uavspec_flockwave::body_schema::{Deviation, Fault, Step};
use uavspec_model::Rule;

use super::{FlockwaveRule, RULES, env_26};

/// Selects body schema violations by message type, path and fault.
#[derive(Debug)]
pub(crate) struct Attribution {
    /// The types of the messages.
    types: &'static [&'static str],
    /// The path, with its steps separated by dots. `*` matches any single step, and `**` at the end matches any number
    /// of steps.
    path: &'static str,
    faults: &'static [Fault],
}

/// A value of the right kind that is invalid, or a value of the wrong kind other than null.
pub(super) const WRONG: &[Fault] = &[Fault::Kind, Fault::Value];

/// A missing value, null, or a value of another kind.
pub(super) const MISSING: &[Fault] = &[Fault::Absent, Fault::Null, Fault::Kind];

/// A missing value, or any invalid value.
pub(super) const INVALID: &[Fault] = &[Fault::Absent, Fault::Null, Fault::Kind, Fault::Value];

/// Any violation.
pub(super) const ALL: &[Fault] = &[Fault::Absent, Fault::Null, Fault::Kind, Fault::Value, Fault::Additional];

impl Attribution {
    /// Creates an attribution for these message types, this path and these faults.
    pub(super) const fn new(
        types: &'static [&'static str],
        path: &'static str,
        faults: &'static [Fault],
    ) -> Self {
        Self { types, path, faults }
    }

    /// Creates an attribution for requested objects that are in an undefined field of the body.
    pub(super) const fn misplaced(types: &'static [&'static str]) -> Self {
        Self::new(types, "*", &[Fault::Misplaced])
    }

    /// The field of UAV states that contains the path, such as `gps` of `status.*.gps.**`.
    pub(super) fn state_field(&self) -> Option<&'static str> {
        self.path.strip_prefix("status.*.")?.split('.').next()
    }

    fn matches(&self, type_name: &str, deviation: &Deviation) -> bool {
        self.types.contains(&type_name)
            && deviation.fault.is_some_and(|fault| self.faults.contains(&fault))
            && matches_path(self.path, &deviation.steps)
    }
}

/// True if the path pattern matches these steps.
fn matches_path(path: &str, steps: &[Step]) -> bool {
    let mut steps = steps.iter();
    for name in path.split('.') {
        match (name, steps.next()) {
            ("**", _) => return true,
            ("*", Some(_)) => {}
            (name, Some(Step::Field(field))) if **field == *name => {}
            _ => return false,
        }
    }
    steps.next().is_none()
}

impl FlockwaveRule {
    /// True if the rule reports this body schema violation for a message type.
    pub(super) fn reports(&self, type_name: &str, deviation: &Deviation) -> bool {
        !env_26::is_disputed(type_name, deviation)
            && self.covers.iter().any(|attribution| attribution.matches(type_name, deviation))
    }
}

/// The rule that reports this body schema violation; `None` if `FW-ENV-18` reports it.
pub fn attributed(type_name: &str, deviation: &Deviation) -> Option<&'static Rule> {
    if env_26::is_disputed(type_name, deviation) {
        return Some(&env_26::RULE.rule);
    }
    let found = RULES.iter().find(|rule| rule.reports(type_name, deviation));
    found.map(|found| &found.rule)
}

#[cfg(test)]
mod tests {
    use uavspec_flockwave::body_schema::Mismatch;

    use super::*;

    fn by_optional(path: &[&str], is_optional: bool, fault: Fault) -> Option<&'static str> {
        // An id may be equal to a field name.
        let step = |name: &&str| match name.strip_prefix('=') {
            Some(_) => Step::Other,
            None => Step::Field((*name).into()),
        };
        let deviation = Deviation {
            steps: path.iter().map(step).collect(),
            is_optional,
            fault: Some(fault),
            field: String::new(),
            definition: None,
            mismatch: Mismatch::new("", ""),
        };
        attributed("UAV-INF", &deviation).map(|rule| rule.id)
    }

    fn by(path: &[&str], fault: Fault) -> Option<&'static str> {
        by_optional(path, false, fault)
    }

    #[test]
    fn the_rule_depends_on_the_path_and_on_the_fault() {
        assert_eq!(by(&["status", "=kite", "position", "=2"], Fault::Kind), Some("FW-UST-POSITION"));
        assert_eq!(by(&["status", "=kite", "errors", "=0"], Fault::Value), Some("FW-ERR-01"));
        assert_eq!(by(&["status", "=kite", "errors", "=0"], Fault::Kind), Some("FW-UST-ERRORS"));
        assert_eq!(by(&["status", "=kite"], Fault::Null), Some("FW-UST-ID"));
        assert_eq!(by(&["status", "=kite", "=flaps"], Fault::Additional), None);
        assert_eq!(by(&["=error"], Fault::Kind), None);
        assert_eq!(by(&["error"], Fault::Kind), Some("FW-UAV-INF-04"));
        assert_eq!(by(&["error"], Fault::Null), None);
        assert_eq!(by_optional(&["error"], true, Fault::Null), Some("FW-ENV-26"));
        assert_eq!(by_optional(&["error"], true, Fault::Kind), Some("FW-UAV-INF-04"));
        assert_eq!(by(&[], Fault::Additional), None);
    }
}
