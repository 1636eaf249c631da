//! `FW-UST-…`: what servers say of a UAV, field by field. A rule each, of one form: the field has the shape that the
//! definitions give it ([`crate::flockwave::body_schema::Shapes`]).

use serde_json::json;

use super::fw::{self, Exchange};
use super::{Check, FlockwaveRule, Level, Mutant, Rule, RuleContext, Status};

/// What the specification says of null.
const NULL: Status = Status::Disputed(
    "The published schemas don't let a field be null that isn't required; the advice to the authors of the specification \
     does. Here null is a deviation.",
);

/// The same, and that of batteries.
const NULL_AND_NEGATIVE: Status = Status::Disputed(
    "The published schemas don't let a field be null that isn't required; the advice to the authors of the specification \
     does. Here null is a deviation. Any negative percentage says that it is unknown by the text, -1 alone by the \
     schema; here any does.",
);

/// The rule on a field.
macro_rules! rule {
    ($rule:ident, $field:literal, $status:expr, $statement:literal, $mutants:expr) => {
        #[doc = concat!("The rule on `", $field, "`.")]
        pub(super) static $rule: FlockwaveRule = FlockwaveRule {
            rule: Rule {
                id: concat!("FW-UST-", stringify!($rule)),
                level: Level::Must,
                status: $status,
                statement: $statement,
                source: fw::TYPES,
                applies_to: "states of UAV-INF",
            },
            check: Check::Exchange(|exchange, context| judge(exchange, context, $field)),
            mutants: &$mutants,
        };
    };
}

/// A mutant: the field has another value.
macro_rules! set {
    ($field:literal, $name:literal, $value:tt) => {
        Mutant { name: $name, make: || fw::state(|kite| kite[$field] = json!($value)), also: &[] }
    };
}

/// A mutant: the field is absent.
macro_rules! absent {
    ($field:literal) => {
        Mutant {
            name: concat!("no `", $field, "`"),
            make: || fw::state(|kite| fw::remove(kite, $field)),
            also: &[],
        }
    };
}

rule!(
    ID,
    "id",
    Status::Normative,
    "`id` is a string of 1 to 64 characters without `/`.",
    [absent!("id"), set!("id", "a number", 7), set!("id", "null", null),]
);

rule!(
    TIMESTAMP,
    "timestamp",
    Status::Normative,
    "`timestamp` is an integer, in milliseconds.",
    [absent!("timestamp"), set!("timestamp", "a word", "noon"), set!("timestamp", "null", null),]
);

rule!(
    ATTITUDE,
    "attitude",
    NULL,
    "`attitude` is roll and pitch, integers from -1800 to 1799, and yaw, 0 to 3599, in tenths of a degree.",
    [
        set!("attitude", "null", null),
        set!("attitude", "a yaw of 3600", [0, 0, 3600]),
        set!("attitude", "no yaw", [0, 0]),
    ]
);

rule!(
    BATTERY,
    "battery",
    NULL_AND_NEGATIVE,
    "`battery` is the voltage, an integer in tenths of a volt from 0 on; the percentage, 100 at most; and whether it is charged.",
    [
        set!("battery", "a fraction of a volt", [11.8, 84]),
        set!("battery", "101 percent", [118, 101]),
        set!("battery", "a number where true or false should be", [118, 84, 1]),
    ]
);

rule!(
    DEBUG,
    "debug",
    NULL,
    "`debug` is Base64.",
    [set!("debug", "no Base64", "glide!"), set!("debug", "a number", 7),]
);

rule!(
    ERRORS,
    "errors",
    NULL,
    "`errors` is a list of integers.",
    [set!("errors", "one code without a list", 1), set!("errors", "null", null),]
);

rule!(
    GPS,
    "gps",
    NULL,
    "`gps` is the type of the fix, 0 to 7; then the number of satellites, and the horizontal and the vertical accuracy in mm, integers or null.",
    [
        set!("gps", "a fix of 8", [8]),
        set!("gps", "nothing", []),
        set!("gps", "the fix alone, without a list", 3),
    ]
);

rule!(
    HEADING,
    "heading",
    NULL,
    "`heading` is an integer from 0 to 3599, in tenths of a degree.",
    [set!("heading", "3600", 3600), set!("heading", "-1", (-1)), set!("heading", "a fraction", 271.5),]
);

rule!(
    LIGHT,
    "light",
    NULL,
    "`light` is a colour in 16 bits, an integer from 0 to 65535.",
    [set!("light", "65536", 65536), set!("light", "a name", "green"),]
);

rule!(MODE, "mode", NULL, "`mode` is a string.", [set!("mode", "a number", 4), set!("mode", "null", null),]);

rule!(
    POSITION,
    "position",
    NULL,
    "`position` is latitude and longitude, integers in units of 1e-7 degrees, and up to three altitudes in mm, integers or null.",
    [
        set!("position", "null", null),
        set!("position", "degrees", [46.541, 11.552]),
        set!("position", "a longitude of 180°", [0, 1_800_000_000]),
        set!("position", "no longitude", [465_410_000]),
        set!("position", "six elements", [465_410_000, 115_520_000, 1, 2, 3, 4]),
    ]
);

rule!(
    POSITIONXYZ,
    "positionXYZ",
    NULL,
    "`positionXYZ` is three integers, in mm.",
    [
        set!("positionXYZ", "null", null),
        set!("positionXYZ", "two", [1, 2]),
        set!("positionXYZ", "a fraction", [1.5, 0, 0]),
    ]
);

rule!(
    RSSI,
    "rssi",
    NULL,
    "`rssi` is a list of integers from -1 to 100.",
    [set!("rssi", "-80", [-80]), set!("rssi", "one number without a list", 71),]
);

rule!(
    VELOCITY,
    "velocity",
    NULL,
    "`velocity` is three integers, in mm/s: to the north, to the east and down.",
    [
        set!("velocity", "null", null),
        set!("velocity", "two", [1, 2]),
        set!("velocity", "a fraction", [1.5, 0, 0]),
    ]
);

rule!(
    VELOCITYXYZ,
    "velocityXYZ",
    NULL,
    "`velocityXYZ` is three integers, in mm/s.",
    [
        set!("velocityXYZ", "null", null),
        set!("velocityXYZ", "two", [1, 2]),
        set!("velocityXYZ", "a fraction", [1.5, 0, 0]),
    ]
);

fn judge(exchange: &Exchange<'_>, context: &mut RuleContext<'_>, field: &str) {
    let id = context.rule.id;
    for (_, state) in fw::states(exchange, "UAV-INF") {
        if state.get(field).is_some() {
            context.covered();
        }
    }
    for deviation in exchange.deviations.iter().flatten().filter(|deviation| deviation.told_by == Some(id)) {
        exchange.deviates(context, &exchange.subject(), deviation);
    }
}
