//! The events of a flight. Its logs contain the event metadata of uavspec.

use serde_json::Value;
use uavspec_runtime::event::{Event, MAX_ARGUMENTS_SIZE};
use uavspec_types::px4_events::px4::{
    ArmDisarmReason, CheckModesGlobalPos, CommanderArmedBy, CommanderArmingCheckSummary,
    CommanderHealthSummary, HealthComponent, NavigationModeGroup,
};

/// The number of different events: a report with one problem, and an event about arming.
pub(super) const NUM_EVENTS: u64 = 4;

/// The problem of the report. It affects all modes.
const PROBLEM: CheckModesGlobalPos = CheckModesGlobalPos {
    modes: NavigationModeGroup(u32::MAX),
    health_component_index: 3, // the bit of `HealthComponent::GPS`
};

/// The fields of the state that agree with the event about arming.
pub(super) fn status() -> [(&'static str, Value); 2] {
    [("arming_state", 2.into()), ("latest_arming_reason", ArmDisarmReason::COMMAND_INTERNAL.0.into())]
}

/// The fields of the event in a round.
pub(super) fn fields(round: u64) -> [(&'static str, Value); 3] {
    let (none, gps) = (HealthComponent(0), HealthComponent::GPS);
    let modes = NavigationModeGroup(0);
    let [id, arguments] = match round % NUM_EVENTS {
        0 => of(&CommanderArmingCheckSummary {
            chunk_idx: 0,
            error: gps,
            warning: none,
            can_arm: modes,
            can_run: modes,
        }),
        1 => of(&PROBLEM),
        2 => of(&CommanderHealthSummary { chunk_idx: 0, is_present: gps, error: none, warning: none }),
        _ => of(&CommanderArmedBy { arg0: ArmDisarmReason::COMMAND_INTERNAL }),
    };
    [("id", id), ("arguments", arguments), ("event_sequence", round.into())]
}

/// Makes an event report why the vehicle can't arm.
pub(super) fn set_reason(event: &mut Value) {
    let [id, arguments] = of(&PROBLEM);
    (event["id"], event["arguments"]) = (id, arguments);
}

/// The id and the arguments of an event.
pub(super) fn of<E: Event>(event: &E) -> [Value; 2] {
    let arguments: [u8; MAX_ARGUMENTS_SIZE] = event.encode();
    [E::ID.into(), arguments.as_slice().into()]
}
