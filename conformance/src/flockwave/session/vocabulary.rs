//! What following a session needs to know of the message types of Flockwave 2.10 beside their definitions.

/// How a reply tells about each of several objects that were asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Parts {
    /// The field of the request that names them.
    pub request_field: &'static str,
    /// The fields of the reply, in exactly one of which each of them stands: maps, or lists.
    pub reply_fields: &'static [&'static str],
}

/// The types of which a reply tells of each object at once, with an error, or with a receipt.
pub(crate) const OPERATIONS: [&str; 21] = [
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

/// What takes long is told in a third part.
pub(crate) const OPERATION: Parts =
    Parts { request_field: "ids", reply_fields: &["result", "error", "receipt"] };

const STATUS: Parts = Parts { request_field: "ids", reply_fields: &["status", "error"] };

const RECEIPTS: Parts = Parts { request_field: "ids", reply_fields: &["success", "error"] };

const SUBSCRIPTIONS: Parts = Parts { request_field: "paths", reply_fields: &["success", "error"] };

/// The types of which a reply tells piece by piece, but those of operations. That each object stands in exactly one
/// part is a matter of words; the definitions have no table that says it.
pub(crate) const PARTS: [(&str, Parts); 14] = [
    ("ASYNC-CANCEL", RECEIPTS),
    ("ASYNC-RESUME", RECEIPTS),
    ("BCN-INF", STATUS),
    ("CLK-INF", STATUS),
    ("CONN-INF", STATUS),
    ("DEV-INF", Parts { request_field: "paths", reply_fields: &["values", "error"] }),
    ("DEV-LIST", Parts { request_field: "ids", reply_fields: &["devices", "error"] }),
    ("DEV-SUB", SUBSCRIPTIONS),
    ("DEV-UNSUB", SUBSCRIPTIONS),
    ("EXT-INF", STATUS),
    ("RTK-INF", Parts { request_field: "ids", reply_fields: &["preset", "error"] }),
    ("UAV-INF", STATUS),
    ("UAV-PREFLT", STATUS),
    ("WTH-INF", STATUS),
];

/// Where a reply of this type tells about what was asked for, if it does so piece by piece.
pub(crate) fn parts(type_name: &str) -> Option<Parts> {
    if OPERATIONS.contains(&type_name) {
        return Some(OPERATION);
    }
    PARTS.iter().find(|(name, _)| *name == type_name).map(|(_, parts)| *parts)
}
