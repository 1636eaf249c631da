//! `PX-FSF-01`: a flag of `FailsafeFlags` that doesn't describe a failure.

use uavspec_runtime::Scalar;
use uavspec_schema::{Element, Field};

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "PX-FSF-01",
    statement: "A FailsafeFlags flag whose name doesn't describe a failure.",
    why: "The failsafe state machine and its simulation treat every flag that is true as a failure.",
    fix: "Choose a name that is true on failure, such as `…_invalid`, `…_lost` or `…_unhealthy`.",
    levels: Levels::both(Level::Error),
    bad: Example {
        path: "FailsafeFlags.msg",
        text: "# Input flags of the failsafe state machine\n\n\
               uint64 timestamp  # [us] Time since system start\n\n\
               bool tow_rope_attached  # Tow rope attached\n",
    },
    good: Example {
        path: "FailsafeFlags.msg",
        text: "# Input flags of the failsafe state machine\n\n\
               uint64 timestamp  # [us] Time since system start\n\n\
               bool tow_rope_lost  # Tow rope lost\n",
    },
    measured: Some(Measured { findings: 0, sample: 0, right: 0 }),
    check: Check::Message(Scope::Px4Messages, check),
};

/// Words in flag names that describe a failure.
const FAILURES: &str = "breached breach broken corrupt corrupted critical denied disconnected empty error exceeded \
    failed failing failure fault faulty high imbalanced inconsistent invalid inaccurate loss lost \
    low missing overheated overload overloaded rejected spoofed stale stuck timeout triggered \
    unavailable unhealthy unsafe unstable violated violation warning weak";

/// Words that may follow a failure word without changing its meaning: a threshold, or the part that failed. All other
/// words change the meaning: `high_accuracy_available` and `failure_cleared` are true if there is no failure.
const QUALIFIERS: [&str; 3] = ["prop", "relaxed", "remaining_time"];

/// Words before a failure word that negate its meaning.
const NEGATIONS: [&str; 4] = ["never", "no", "not", "without"];

/// The prefix of flight-mode masks, which describe requirements instead of failures.
pub(super) const REQUIREMENT: &str = "mode_req_";

/// True if the rules about flags apply to the message.
pub(super) fn applies(subject: &Subject<'_>) -> bool {
    subject.message.name == "FailsafeFlags"
}

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    if !applies(subject) {
        return;
    }
    for field in subject.message.fields.iter().filter(|field| !describes_failure(field)) {
        sink.report(
            field.span,
            format!("`{}` doesn't describe a failure", field.name),
            "choose a name that is true on failure, such as `…_invalid`, `…_lost` or `…_unhealthy`",
        );
    }
}

fn describes_failure(field: &Field) -> bool {
    field.ty.element != Element::Scalar(Scalar::Bool)
        || field.name.starts_with(REQUIREMENT)
        || ends_with_failure(&field.name)
}

fn ends_with_failure(name: &str) -> bool {
    let qualified = QUALIFIERS.iter().find_map(|last| name.strip_suffix(last)?.strip_suffix('_'));
    let mut words = qualified.unwrap_or(name).rsplit('_');
    let is_failure = words.next().is_some_and(|last| FAILURES.split(' ').any(|known| known == last));
    is_failure && words.all(|word| !NEGATIONS.contains(&word))
}

#[cfg(test)]
mod tests {
    use super::ends_with_failure;

    /// The flags of PX4 1.15, 1.16 and later versions.
    const FLAGS: &str = "angular_velocity_invalid attitude_invalid auto_mission_missing battery_low_remaining_time \
        battery_unhealthy fd_alt_loss fd_critical_failure fd_esc_arming_failure fd_imbalanced_prop fd_motor_failure \
        flight_time_limit_exceeded gcs_connection_lost geofence_breached global_position_invalid \
        global_position_invalid_relaxed gnss_lost home_position_invalid local_altitude_invalid \
        local_position_accuracy_low local_position_invalid local_position_invalid_relaxed local_velocity_invalid \
        manual_control_signal_lost mission_failure navigator_failure offboard_control_signal_lost \
        parachute_unhealthy position_accuracy_low remote_id_unhealthy traffic_avoidance_unhealthy \
        vtol_fixed_wing_system_failure wind_limit_exceeded";

    #[test]
    fn px4_flags_describe_a_failure() {
        for flag in FLAGS.split(' ') {
            assert!(ends_with_failure(flag), "{flag}");
        }
    }

    #[test]
    fn other_words_or_negation_change_the_meaning() {
        for flag in [
            "high_accuracy_available",
            "low_noise_ok",
            "failure_cleared",
            "invalid_position_count",
            "link_not_lost",
            "no_failure",
            "prop",
            "relaxed",
            "remaining_time",
            "",
            "_",
        ] {
            assert!(!ends_with_failure(flag), "{flag}");
        }
    }
}
