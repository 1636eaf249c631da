//! `event-enum-differs`: a constant whose value differs from the value in event metadata.

use uavspec_schema::value::Value;
use uavspec_schema::{EventEnum, Schema};

use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "event-enum-differs",
    statement: "A constant of a message whose value differs from the entry with the same name in an enum of event metadata.",
    why: "Both sources define the same value, but the firmware uses only one of them: PX4 1.15 to 1.17 write the reasons for \
          arming with the values of the metadata, so readers of `VehicleStatus` show a wrong reason.",
    fix: "Give the constant the value that the firmware writes.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "VehicleStatus.msg",
        text: "uint64 timestamp\nuint8 latest_disarming_reason\nuint8 ARM_DISARM_REASON_LANDING = 7\n",
    },
    good: Example {
        path: "VehicleStatus.msg",
        text: "uint64 timestamp\nuint8 latest_disarming_reason\nuint8 ARM_DISARM_REASON_LANDING = 6\n",
    },
    measured: None,
    check: Check::Schema(check),
};

fn check(schema: &Schema, sink: &mut Sink<'_>) {
    let components = schema.packages.iter().flat_map(|package| &package.components);
    for enumeration in components.flat_map(|component| &component.enums) {
        check_enum(schema, enumeration, sink);
    }
}

fn check_enum(schema: &Schema, enumeration: &EventEnum, sink: &mut Sink<'_>) {
    let prefix = enumeration.name.trim_end_matches('t').to_uppercase();
    for constant in schema.messages.iter().flat_map(|message| &message.constants) {
        let Some(name) = constant.name.strip_prefix(&prefix) else { continue };
        let entry = enumeration.entries.iter().find(|entry| entry.name.eq_ignore_ascii_case(name));
        let (Some(entry), Value::Int(value)) = (entry, &constant.value) else { continue };
        if entry.value != *value {
            let of = format!("`{}` of `{}` is {}", entry.name, enumeration.name, entry.value);
            let message = format!("`{}` is {value}, but {of} in event metadata", constant.name);
            sink.report(constant.span, message, format!("write {} if the firmware uses it", entry.value));
        }
    }
}
