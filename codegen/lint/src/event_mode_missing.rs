//! `event-mode-missing`: a navigation state without a group of modes.

use std::collections::BTreeSet;

use uavspec_schema::Schema;
use uavspec_schema::value::Value;

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "event-mode-missing",
    statement: "A navigation state that has no bit in the mode groups of event metadata.",
    why: "A health and arming report says, for each group of modes, whether the vehicle can arm. A pilot learns \
          nothing about a mode without a group.",
    fix: "Add the bit of the state to `navigation_mode_group_t`, or name the state `FREE` or `UNUSED` if it isn't used.",
    levels: Levels::both(Level::Note),
    bad: Example {
        path: "VehicleStatus.msg",
        text: "uint64 timestamp\nuint8 nav_state\nuint8 NAVIGATION_STATE_DESCEND = 12\n",
    },
    good: Example {
        path: "VehicleStatus.msg",
        text: "uint64 timestamp\nuint8 nav_state\nuint8 NAVIGATION_STATE_MANUAL = 0\n",
    },
    measured: None,
    check: Check::Schema(check),
};

/// The words in the names of states that aren't used.
const UNUSED: [&str; 3] = ["FREE", "UNUSED", "MAX"];

fn check(schema: &Schema, sink: &mut Sink<'_>) {
    let components = schema.packages.iter().flat_map(|package| &package.components);
    let mut groups = components.flat_map(|component| &component.enums);
    let Some(groups) = groups.find(|found| found.name == "navigation_mode_group_t") else { return };
    let bits: BTreeSet<i128> = groups.entries.iter().map(|entry| entry.value).collect();
    for constant in schema.messages.iter().flat_map(|message| &message.constants) {
        let Some(name) = constant.name.strip_prefix("NAVIGATION_STATE_") else { continue };
        let Value::Int(state @ 0..32) = constant.value else { continue };
        if !bits.contains(&(1 << state)) && !UNUSED.iter().any(|word| name.contains(word)) {
            let message =
                format!("`{}` ({state}) has no bit in `{}` of event metadata", constant.name, groups.name);
            sink.report(constant.span, message, format!("add the bit {} to the metadata", 1_u64 << state));
        }
    }
}
