//! `command-parameters`: a command without seven parameters.

use uavspec_schema::enumeration;

use super::constant_without_enum;
use super::prelude::*;

pub(super) const RULE: Rule = Rule {
    id: "command-parameters",
    statement: "A VehicleCommand command whose comment does not list seven parameters separated by `|`.",
    why: "Readers can't tell which parameter is which, and the command's documentation lists no parameters.",
    fix: "List all seven parameters, and write `Unused` for parameters without a meaning.",
    levels: Levels::both(Level::Warning),
    bad: Example {
        path: "VehicleCommand.msg",
        text: "# Command to the vehicle\n\nuint64 timestamp  # [us] Time since system start\n\n\
               uint16 VEHICLE_CMD_TOW = 900  # Tow a glider |[m] Height|[m/s] Speed|\n\n\
               uint16 command  # [@enum VEHICLE_CMD] Command\n",
    },
    good: Example {
        path: "VehicleCommand.msg",
        text: "# Command to the vehicle\n\nuint64 timestamp  # [us] Time since system start\n\n\
               uint16 VEHICLE_CMD_TOW = 900  # Tow a glider |[m] Height|[m/s] Speed|Unused|Unused|Unused|Unused|Unused|\n\nuint16 command  # [@enum VEHICLE_CMD] Command\n",
    },
    measured: Some(Measured { findings: 42, sample: 30, right: 28 }),
    check: Check::Message(Scope::Px4Messages, check),
};

/// The number of parameters of a `MAVLink` command.
const COUNT: usize = 7;

fn check(subject: &Subject<'_>, sink: &mut Sink<'_>) {
    if subject.message.name != "VehicleCommand" {
        return;
    }
    let names = constant_without_enum::names(subject.message);
    for (constant, line) in subject.constants() {
        let is_command = constant.name.starts_with("VEHICLE_CMD_")
            && !enumeration::is_sentinel_among(&constant.name, &names);
        if !is_command || !constant.parameters.is_empty() {
            continue;
        }
        let text = line.comment.as_ref().map_or("", |comment| comment.text);
        let found = match text.split('|').count() {
            1 => 0,
            // If the closing `|` is missing, the text after the last `|` is a parameter too.
            parts => parts - 2 + usize::from(!text.trim_end().ends_with('|')),
        };
        let found = match found {
            0 => "no parameters".to_owned(),
            1 => "one parameter".to_owned(),
            found => format!("{found} parameters"),
        };
        sink.report(
            constant.span,
            format!("`{}` has {found}, expected {COUNT}", constant.name),
            "end the comment with `|p1|p2|p3|p4|p5|p6|p7|`",
        );
    }
}
