//! `PX-FSF-03`.
//!
//! Which flag belongs to which requirement, their names say. A flag is called as its requirement, with words more
//! that say what is wrong ([`STATES`]): `mode_req_local_position_relaxed` and `local_position_invalid_relaxed`.
//! Where the names don't say it, a table does ([`RENAMED_REQUIREMENTS`]). Flags that belong to none aren't looked at.

use uavspec_codegen::dynamic::{DynamicView, Value};

use super::ext::px4_message;
use super::{
    Change, Channel, Check, Checker, Detail, Interest, Level, Message, Mutant, PerChannel, Px4Rule, Rule,
    RuleContext, Status,
};
use crate::rules::sample::Flight;

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-FSF-03",
        level: Level::Info,
        status: Status::Advisory,
        statement: "A flag of FailsafeFlags that is set while no mode has its requirement, as all bits of the matching \
                `mode_req` are 0, keeps no mode from running.",
        source: "FailsafeFlags",
        applies_to: "values of messages",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::State(|| Box::new(Flags::default())),
    mutants: &[Mutant {
        name: "a flag is set that no mode requires",
        change: Change::Flight(not_required),
        also: &[],
    }],
};

const REQUIREMENT: &str = "mode_req_";

/// Words that the name of a flag has beside those of its requirement.
const STATES: [&str; 6] = ["invalid", "lost", "missing", "auto", "control", "signal"];

/// Flags whose requirement has another name.
const RENAMED_REQUIREMENTS: [(&str, &str); 2] = [
    ("wind_limit_exceeded", "wind_and_flight_time_compliance"),
    ("flight_time_limit_exceeded", "wind_and_flight_time_compliance"),
];

#[derive(Default)]
struct Flags {
    channels: PerChannel<Option<Fields>>,
}

/// What the messages of a channel have.
#[derive(Clone)]
struct Fields {
    /// Indices of flags and of their requirements.
    pairs: Vec<(usize, usize)>,
    names: Vec<String>,
}

impl Checker for Flags {
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest {
        self.channels.open(channel, None);
        let is_wanted = px4_message(channel, context) == Some("FailsafeFlags");
        if is_wanted { Interest::Values } else { Interest::Nothing }
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
                    Detail::new(format!("set, and {requirement} is 0: no mode requires it"))
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
                matches!(value, Value::Bool(_) | Value::UInt(_)) && is_of(flag, required)
            });
            pairs.extend(flags.map(|(flag, _)| (flag, requirement)));
        }
        Self { pairs, names: values.fields().map(|(name, _)| name.to_owned()).collect() }
    }
}

/// Whether a value of one number isn't 0.
fn is_set(value: Value<'_>) -> bool {
    matches!(value, Value::Bool(true) | Value::UInt(1..))
}

/// Whether a flag is about this requirement: all words of it are in its name, in this order, at least their
/// beginnings (`alt`, `altitude`), and all other words tell a state.
fn is_of(flag: &str, required: &str) -> bool {
    let mut rest = required.split('_').peekable();
    let is_known = |word: &str| {
        rest.next_if(|required| !required.is_empty() && word.starts_with(required)).is_some()
            || STATES.contains(&word)
    };
    let is_same = flag.split('_').all(is_known) && rest.peek().is_none();
    is_same && !flag.starts_with(REQUIREMENT) || RENAMED_REQUIREMENTS.contains(&(flag, required))
}

/// The last flags have one that is set without being required.
fn not_required<'d>(flight: &Flight<'d>) -> Option<Flight<'d>> {
    let topic = flight.topic("FailsafeFlags")?;
    flight.with_last(topic, |flags| {
        flags["mode_req_attitude"] = 0.into();
        flags["attitude_invalid"] = true.into();
    })
}

#[cfg(test)]
mod tests {
    use super::is_of;

    #[test]
    fn flags_belong_to_requirements_by_their_names() {
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
            assert!(is_of(flag, required), "{flag} and {required}");
        }
    }

    #[test]
    fn flags_of_something_else_do_not() {
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
            assert!(!is_of(flag, required), "{flag} and {required}");
        }
    }
}
