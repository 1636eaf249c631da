//! The message types of Flockwave 2.10, as far as following a conversation needs to know them.

/// A type of messages.
#[derive(Debug)]
pub struct MessageType {
    /// Its name.
    pub name: &'static str,
    /// Whether servers may send it unasked.
    pub is_notification: bool,
    /// Where a reply tells about what was asked for, piece by piece.
    pub parts: Option<Parts>,
}

/// How a reply tells about each of several objects that were asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parts {
    /// The field of the request that names them.
    pub asked: &'static str,
    /// The fields of the reply, in exactly one of which each of them stands: maps, or lists.
    pub told: &'static [&'static str],
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

const fn plain(name: &'static str) -> MessageType {
    MessageType { name, is_notification: false, parts: None }
}

const fn notification(name: &'static str) -> MessageType {
    MessageType { name, is_notification: true, parts: None }
}

const fn by_part(
    name: &'static str,
    asked: &'static str,
    told: &'static [&'static str],
    is_notification: bool,
) -> MessageType {
    MessageType { name, is_notification, parts: Some(Parts { asked, told }) }
}

/// What takes long is told in a third part.
const OPERATION: &[&str] = &["result", "error", "receipt"];

const STATUS: &[&str] = &["status", "error"];

const fn operation(name: &'static str) -> MessageType {
    by_part(name, "ids", OPERATION, false)
}

/// All types, by name.
pub static TYPES: [MessageType; 82] = [
    plain("ACK-ACK"),
    plain("ACK-NAK"),
    by_part("ASYNC-CANCEL", "ids", &["success", "error"], false),
    notification("ASYNC-RESP"),
    by_part("ASYNC-RESUME", "ids", &["success", "error"], false),
    notification("ASYNC-ST"),
    notification("ASYNC-TIMEOUT"),
    plain("AUTH-INF"),
    plain("AUTH-REQ"),
    plain("AUTH-RESP"),
    plain("AUTH-WHOAMI"),
    by_part("BCN-INF", "ids", STATUS, false),
    operation("BCN-PROPS"),
    by_part("CLK-INF", "ids", STATUS, true),
    plain("CLK-LIST"),
    notification("CONN-DEL"),
    by_part("CONN-INF", "ids", STATUS, true),
    plain("CONN-LIST"),
    by_part("DEV-INF", "paths", &["values", "error"], true),
    by_part("DEV-LIST", "ids", &["devices", "error"], false),
    plain("DEV-LISTSUB"),
    by_part("DEV-SUB", "paths", &["success", "error"], false),
    by_part("DEV-UNSUB", "paths", &["success", "error"], false),
    plain("DOCK-INF"),
    plain("EXT-CFG"),
    by_part("EXT-INF", "ids", STATUS, false),
    plain("EXT-LIST"),
    plain("EXT-LOAD"),
    plain("EXT-RELOAD"),
    plain("EXT-SETCFG"),
    plain("EXT-UNLOAD"),
    plain("FW-OBJECT-LIST"),
    plain("FW-TARGET-INF"),
    plain("FW-TARGET-LIST"),
    operation("FW-UPLOAD"),
    plain("LCN-INF"),
    plain("LOG-DATA"),
    operation("LOG-INF"),
    operation("OBJ-CMD"),
    notification("OBJ-DEL"),
    plain("OBJ-LIST"),
    operation("PRM-GET"),
    operation("PRM-SET"),
    operation("PRM-SET-MANY"),
    by_part("RTK-INF", "ids", &["preset", "error"], false),
    plain("RTK-LIST"),
    plain("RTK-SOURCE"),
    plain("RTK-STAT"),
    plain("RTK-SURVEY"),
    plain("SHOW-CFG"),
    plain("SHOW-CRTH-PLAN"),
    plain("SHOW-CRTH-START"),
    plain("SHOW-LIGHTS"),
    plain("SHOW-SETCFG"),
    plain("SHOW-SETLIGHTS"),
    notification("SYS-CLOSE"),
    notification("SYS-MSG"),
    plain("SYS-PING"),
    plain("SYS-PORTS"),
    plain("SYS-TIME"),
    plain("SYS-VER"),
    notification("TIMESYNC-STATUS"),
    operation("UAV-CALIB"),
    operation("UAV-FLY"),
    operation("UAV-HALT"),
    operation("UAV-HOVER"),
    by_part("UAV-INF", "ids", STATUS, true),
    operation("UAV-LAND"),
    plain("UAV-LIST"),
    operation("UAV-MOTOR"),
    by_part("UAV-PREFLT", "ids", STATUS, true),
    operation("UAV-RST"),
    operation("UAV-RTH"),
    operation("UAV-SIGNAL"),
    operation("UAV-SLEEP"),
    operation("UAV-TAKEOFF"),
    operation("UAV-TEST"),
    operation("UAV-VER"),
    operation("UAV-WAKEUP"),
    plain("WTH-AT"),
    by_part("WTH-INF", "ids", STATUS, false),
    plain("WTH-LIST"),
];

/// The type of a name, where it is known.
pub fn message_type(name: &str) -> Option<&'static MessageType> {
    TYPES.binary_search_by_key(&name, |known| known.name).ok().map(|at| &TYPES[at])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn types_are_sorted_so_that_they_can_be_looked_up() {
        assert!(TYPES.windows(2).all(|pair| pair[0].name < pair[1].name));
        assert!(TYPES.iter().all(|known| message_type(known.name).is_some()));
        assert!(message_type("UAV-SOAR").is_none());
    }
}
