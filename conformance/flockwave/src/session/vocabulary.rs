//! Facts about Flockwave 2.10 message types that session tracking needs but the definitions don't contain.

/// The fields of a response that reports on several requested objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parts {
    /// The field of the request that lists the objects.
    pub request_field: &'static str,
    /// The fields of the response, which are maps or lists. Each object appears in exactly one of these fields.
    pub reply_fields: &'static [&'static str],
}

/// The types whose response reports the result, an error or a receipt for each object.
pub const OPERATIONS: [&str; 21] = [
    "BCN-PROPS",
    "FW-UPLOAD",
    "LOG-INF",
    "OBJ-CMD",
    "PRM-GET",
    "PRM-SET",
    "PRM-SET-MANY",
    "UAV-CALIB",
    "UAV-FLY",
    "UAV-HALT",
    "UAV-HOVER",
    "UAV-LAND",
    "UAV-MOTOR",
    "UAV-RST",
    "UAV-RTH",
    "UAV-SIGNAL",
    "UAV-SLEEP",
    "UAV-TAKEOFF",
    "UAV-TEST",
    "UAV-VER",
    "UAV-WAKEUP",
];

/// The fields of operations. If an operation continues after the response, the response contains a receipt.
pub const OPERATION: Parts = Parts { request_field: "ids", reply_fields: &["result", "error", "receipt"] };

const STATUS: Parts = Parts { request_field: "ids", reply_fields: &["status", "error"] };

const RECEIPTS: Parts = Parts { request_field: "ids", reply_fields: &["success", "error"] };

const SUBSCRIPTIONS: Parts = Parts { request_field: "paths", reply_fields: &["success", "error"] };

/// The types whose response reports on each object, except the types in [`OPERATIONS`]. Each object must appear in
/// exactly one part. The specification states this only in its text, so the tables in the definitions don't contain
/// this requirement.
pub const PARTS: [(&str, Parts); 16] = [
    ("ASYNC-CANCEL", RECEIPTS),
    ("ASYNC-RESUME", RECEIPTS),
    ("BCN-INF", STATUS),
    ("CLK-INF", STATUS),
    ("CONN-INF", STATUS),
    ("DEV-INF", Parts { request_field: "paths", reply_fields: &["values", "error"] }),
    ("DEV-LIST", Parts { request_field: "ids", reply_fields: &["devices", "error"] }),
    ("DEV-SUB", SUBSCRIPTIONS),
    ("DEV-UNSUB", SUBSCRIPTIONS),
    ("DOCK-INF", STATUS),
    ("EXT-INF", STATUS),
    ("FW-TARGET-INF", Parts { request_field: "ids", reply_fields: &["result", "error"] }),
    ("RTK-INF", Parts { request_field: "ids", reply_fields: &["preset", "error"] }),
    ("UAV-INF", STATUS),
    ("UAV-PREFLT", STATUS),
    ("WTH-INF", STATUS),
];

/// The fields that report on each requested object in responses of this type. `None` if there are no such fields.
pub fn parts(type_name: &str) -> Option<Parts> {
    if OPERATIONS.contains(&type_name) {
        return Some(OPERATION);
    }
    PARTS.iter().find(|(name, _)| *name == type_name).map(|(_, parts)| *parts)
}
