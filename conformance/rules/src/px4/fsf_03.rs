//! `PX-FSF-03`.
//!
//! Flags and requirements are matched by name. A flag's name contains the words of its requirement and words that
//! describe the failure (`STATES`). For example, `local_position_invalid_relaxed` belongs to
//! `mode_req_local_position_relaxed`. [`RENAMED_REQUIREMENTS`] lists the exceptions. Flags without a requirement are
//! not checked.

use uavspec_dynamic::{DynamicView, Value};
use uavspec_types::px4::FailsafeFlags;

use super::ext::px4_message;
use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-FSF-03",
    name: "Failsafe flags and mode requirements",
    level: Level::Info,
    status: Status::Advisory,
    statement: "If a flag of FailsafeFlags is set, at least one mode has a matching requirement: the \
                `mode_req` mask for the flag is not 0.",
    source: "FailsafeFlags",
    applies_to: "message values",
    why: "A flag without a matching requirement doesn't prevent any mode from running. Either the flag is \
          not meant to block any mode, or a mode lacks a requirement.",
    example: "{…, \"mode_req_attitude\": 0, \"attitude_invalid\": true, …}",
    fix: "Check which modes can't run while the flag is set, and set their bits in the mask. If all modes \
          can run, no change is necessary.",
})
.check(Check::State(|| Box::new(Flags::default())))
.bug(
    Bug::message(Side::Autopilot, "`attitude_invalid` is set, but no mode requires an attitude.", |out| {
        out.edit(3, |flags: &mut FailsafeFlags| {
            (flags.attitude_invalid, flags.mode_req_attitude) = (true, 0);
        });
    })
    // The flags of several releases have the same size.
    .needs(Needs::TypeHashes),
)
.mutants(&[Mutant::flight("a flag that is set but has no matching requirement", not_required)]);

/// The prefix of the fields that say what a mode requires.
pub const REQUIREMENT: &str = "mode_req_";

/// Words that appear in flag names but not in the names of their requirements.
const STATES: [&str; 6] = ["invalid", "lost", "missing", "auto", "control", "signal"];

/// The flags and requirements that belong together but can't be matched by name.
const RENAMED_REQUIREMENTS: [(&str, &str); 2] = [
    ("wind_limit_exceeded", "wind_and_flight_time_compliance"),
    ("flight_time_limit_exceeded", "wind_and_flight_time_compliance"),
];

#[derive(Default)]
struct Flags {
    channels: PerChannel<Option<Fields>>,
}

/// The fields of a channel's messages.
#[derive(Clone)]
struct Fields {
    /// The field indices of each flag and its requirement.
    pairs: Vec<(usize, usize)>,
    names: Vec<String>,
}

impl Checker for Flags {
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest {
        self.channels.open(channel, None);
        let is_flags = px4_message(channel, context) == Some("FailsafeFlags");
        if is_flags { Interest::Values } else { Interest::Nothing }
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, context: &mut RuleContext<'_>) {
        let (Some(values), Some(fields)) = (message.values, self.channels.get(channel)) else { return };
        // All messages of a channel have the same fields.
        let fields = fields.get_or_insert_with(|| Fields::new(values));
        let is_set = |at: &usize| values.field(*at).map(is_set);
        for (flag, requirement) in &fields.pairs {
            context.covered();
            if is_set(flag) == Some(true) && is_set(requirement) == Some(false) {
                let [flag, requirement] = [&fields.names[*flag], &fields.names[*requirement]];
                context.violation_in_field(channel, flag, message.location, || {
                    Detail::new(format!("set, but no mode has a matching requirement: {requirement} is 0"))
                        .expected(format!("not set, or {requirement} other than 0"))
                        .actual("set")
                });
            }
        }
    }
}

impl Fields {
    fn new(values: DynamicView<'_>) -> Self {
        let mut pairs = Vec::new();
        for (requirement, (name, _)) in values.fields().enumerate() {
            let Some(required) = name.strip_prefix(REQUIREMENT) else { continue };
            let flags = values.fields().enumerate();
            let flags = flags.filter(|(_, (flag, value))| {
                matches!(value, Value::Bool(_) | Value::UInt(_)) && belongs_to(flag, required)
            });
            pairs.extend(flags.map(|(flag, _)| (flag, requirement)));
        }
        Self { pairs, names: values.fields().map(|(name, _)| name.to_owned()).collect() }
    }
}

/// True if a bool is true or an unsigned integer isn't 0.
fn is_set(value: Value<'_>) -> bool {
    matches!(value, Value::Bool(true) | Value::UInt(1..))
}

/// True if a flag belongs to a requirement. The flag's name must contain all words of the requirement in order,
/// possibly in longer forms (`altitude` for `alt`). All other words must be in `STATES`.
pub fn belongs_to(flag: &str, required: &str) -> bool {
    let mut rest = required.split('_').peekable();
    let is_known = |word: &str| {
        rest.next_if(|required| !required.is_empty() && word.starts_with(required)).is_some()
            || STATES.contains(&word)
    };
    let is_match = flag.split('_').all(is_known) && rest.peek().is_none();
    is_match && !flag.starts_with(REQUIREMENT) || RENAMED_REQUIREMENTS.contains(&(flag, required))
}

/// Sets a flag in the last message, and clears the flag's requirement.
fn not_required<'d>(flight: &Flight<'d>) -> Option<Flight<'d>> {
    let topic = flight.topic("FailsafeFlags")?;
    flight.with_last(topic, |flags| {
        flags["mode_req_attitude"] = 0.into();
        flags["attitude_invalid"] = true.into();
    })
}

#[cfg(test)]
mod tests {
    use super::belongs_to;

    #[test]
    fn matches_flags_and_requirements_by_name() {
        for (flag, required) in [
            ("angular_velocity_invalid", "angular_velocity"),
            ("attitude_invalid", "attitude"),
            ("local_altitude_invalid", "local_alt"),
            ("local_position_invalid", "local_position"),
            ("local_position_invalid_relaxed", "local_position_relaxed"),
            ("global_position_invalid_relaxed", "global_position_relaxed"),
            ("auto_mission_missing", "mission"),
            ("offboard_control_signal_lost", "offboard_signal"),
            ("home_position_invalid", "home_position"),
            ("manual_control_signal_lost", "manual_control"),
            ("wind_limit_exceeded", "wind_and_flight_time_compliance"),
            ("flight_time_limit_exceeded", "wind_and_flight_time_compliance"),
        ] {
            assert!(belongs_to(flag, required), "{flag} and {required}");
        }
    }

    #[test]
    fn does_not_match_other_flags() {
        for (flag, required) in [
            ("local_position_invalid_relaxed", "local_position"),
            ("local_position_invalid", "local_position_relaxed"),
            ("local_velocity_invalid", "angular_velocity"),
            ("local_position_invalid", "global_position"),
            ("mission_failure", "mission"),
            ("mode_req_attitude", "attitude"),
            ("battery_unhealthy", "other"),
            ("attitude_invalid", ""),
            ("invalid", ""),
            ("position_home_invalid", "home_position"),
            ("wind_limit_exceeded", "attitude"),
        ] {
            assert!(!belongs_to(flag, required), "{flag} and {required}");
        }
    }
}
