//! Compares two versions of definitions, and reports the changes and the users that each change affects.
//!
//! First, messages, fields and constants of both versions are matched, including renamed ones (`Comparison`, `Pair`).
//! Then each rule checks the matched items. Each rule covers one kind of change, and reports one finding for each
//! [`Category`] that the change breaks.
//!
//! Types and messages in pages are not compared yet.
//!
//! ```
//! use uavspec_dynamic::breaking::{Between, breaking};
//! use uavspec_schema::{Form, PackageInput, SourceMap, msg::Dialect, read};
//!
//! let mut sources = SourceMap::default();
//! let [old, new] = ["float32 speed  # [m/s] Speed\n", "float32 speed  # [deg] Speed\n"].map(|text| {
//!     let id = sources.add("Wind.msg", text.into()).unwrap();
//!     read(&sources, &[PackageInput::new("px4", Form::Msg(Dialect::Px4), vec![id])]).0
//! });
//! let findings = breaking(&sources, &old, &new, Between::Commits);
//! assert!(findings.iter().any(|finding| finding.rule == "field-unit-changed"));
//! ```

mod comparison;
mod message;
mod order;
mod prelude;
mod signature;

mod array_length_changed;
mod constant_added;
mod constant_removed;
mod constant_renamed;
mod constant_reused;
mod constant_type_changed;
mod constant_value_changed;
mod error_code_abbreviation_changed;
mod error_code_added;
mod error_code_meaning_changed;
mod error_code_removed;
mod error_code_renumbered;
mod error_code_reused;
mod event_added;
mod event_arguments_changed;
mod event_enum_changed;
mod event_meaning_changed;
mod event_removed;
mod field_added;
mod field_default_changed;
mod field_enum_changed;
mod field_frame_changed;
mod field_invalid_changed;
mod field_moved;
mod field_range_changed;
mod field_removed;
mod field_renamed;
mod field_type_changed;
mod field_unit_changed;
mod message_added;
mod message_removed;
mod message_renamed;
mod message_version;
mod message_version_needless;
mod message_version_removed;
mod nested_changed;
mod queue_length_changed;
mod rule;
mod topic_added;
mod topic_removed;

use uavspec_schema::Schema;
pub use uavspec_schema::example::Example;
use uavspec_schema::finding::Finding;
use uavspec_schema::source::SourceMap;

pub(crate) use self::comparison::Comparison;
pub use self::message::Between;
pub(crate) use self::message::{ConstantChange, FieldChange, Pair};
pub use self::rule::{Category, Rule};
use self::rule::{Check, Sink};

/// All rules, sorted by id.
pub const RULES: &[&Rule] = &[
    &array_length_changed::RULE,
    &constant_added::RULE,
    &constant_removed::RULE,
    &constant_renamed::RULE,
    &constant_reused::RULE,
    &constant_type_changed::RULE,
    &constant_value_changed::RULE,
    &error_code_abbreviation_changed::RULE,
    &error_code_added::RULE,
    &error_code_meaning_changed::RULE,
    &error_code_removed::RULE,
    &error_code_renumbered::RULE,
    &error_code_reused::RULE,
    &event_added::RULE,
    &event_arguments_changed::RULE,
    &event_enum_changed::RULE,
    &event_meaning_changed::RULE,
    &event_removed::RULE,
    &field_added::RULE,
    &field_default_changed::RULE,
    &field_enum_changed::RULE,
    &field_frame_changed::RULE,
    &field_invalid_changed::RULE,
    &field_moved::RULE,
    &field_range_changed::RULE,
    &field_removed::RULE,
    &field_renamed::RULE,
    &field_type_changed::RULE,
    &field_unit_changed::RULE,
    &message_added::RULE,
    &message_removed::RULE,
    &message_renamed::RULE,
    &message_version::RULE,
    &message_version_needless::RULE,
    &message_version_removed::RULE,
    &nested_changed::RULE,
    &queue_length_changed::RULE,
    &topic_added::RULE,
    &topic_removed::RULE,
];

/// Finds a rule by its id.
pub fn rule(id: &str) -> Option<&'static Rule> {
    RULES.binary_search_by_key(&id, |rule| rule.id).ok().map(|at| RULES[at])
}

/// Compares two versions of definitions. Both versions must be free of errors, and `sources` must contain the sources
/// of both versions. The findings are sorted by location.
pub fn breaking(sources: &SourceMap, old: &Schema, new: &Schema, between: Between) -> Vec<Finding> {
    let comparison = Comparison::new(old, new, between);
    let mut findings = Vec::new();
    for rule in RULES {
        let mut sink = Sink { rule, findings: &mut findings };
        match rule.check {
            Check::Interface(check) => {
                comparison.changes.iter().for_each(|change| check(change, &mut sink));
            }
            Check::Message(check) => comparison.pairs.iter().for_each(|pair| check(pair, &mut sink)),
            Check::Field(check) => {
                for pair in &comparison.pairs {
                    pair.fields().for_each(|(old, new)| check(pair, old, new, &mut sink));
                }
            }
            Check::Constant(check) => {
                for pair in &comparison.pairs {
                    pair.constants.iter().for_each(|change| check(pair, change, &mut sink));
                }
            }
            Check::ErrorCode(check) => comparison.codes.iter().for_each(|change| check(change, &mut sink)),
            Check::Event(check) => comparison.events.iter().for_each(|change| check(change, &mut sink)),
            Check::EventEnum(check) => {
                comparison.event_enums.iter().for_each(|(old, new)| check(old, new, &mut sink));
            }
        }
    }
    let path = |finding: &Finding| sources.path(sources.source_of(finding.span));
    let key = |finding: &Finding| (finding.span, finding.sides.and_then(|sides| sides.old), finding.rule);
    findings.sort_by(|left, right| (path(left), key(left)).cmp(&(path(right), key(right))));
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_are_sorted_by_id() {
        assert!(RULES.windows(2).all(|pair| pair[0].id < pair[1].id));
    }
}
