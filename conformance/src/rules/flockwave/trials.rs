//! Rules that show only where someone tries them: requests that have to be served, whatever goes before them and however
//! they come. A rule each, of one form.
//!
//! Who tries them says so in the recording, and how. A request that is refused isn't served either, so nothing is to be
//! tried with what a server may refuse for other reasons.

use super::fw;
use super::{Check, FlockwaveRule, Level, Mutant, Rule, Status};

/// The rule of an id, with what tries it.
macro_rules! rule {
    ($rule:ident, $id:literal, $connection:literal, $level:expr, $status:expr, $source:expr, $statement:literal) => {
        #[doc = concat!("`", $id, "`.")]
        pub(super) static $rule: FlockwaveRule = FlockwaveRule {
            rule: Rule {
                id: $id,
                level: $level,
                status: $status,
                statement: $statement,
                source: $source,
                applies_to: "requests that try it",
            },
            check: Check::Exchange(|exchange, context| {
                fw::served(exchange, context);
            }),
            mutants: &[
                Mutant {
                    name: "a trial without an answer",
                    make: || fw::unanswered($connection, $id),
                    also: &[],
                },
                Mutant { name: "a trial that is refused", make: || fw::refused($connection, $id), also: &[] },
                Mutant {
                    name: "a trial for which there is no connection",
                    make: || fw::then(|session| session.refused($id, "no connection", "Nobody is there")),
                    also: &[],
                },
            ],
        };
    };
}

rule!(
    ENV_21,
    "FW-ENV-21",
    "tcp#9",
    Level::Info,
    Status::Advisory,
    fw::DERIVED,
    "A request whose id is unusual but allowed is answered, and the answer has that id: 36 characters, letters that aren't ASCII, spaces."
);

rule!(
    SIO_01,
    "FW-SIO-01",
    "socketio#9",
    Level::Must,
    Status::Normative,
    fw::TRANSPORT,
    "Over Socket.IO connections are upgraded and opened as its protocol says, and messages travel as events `fw`."
);

rule!(
    SIO_02,
    "FW-SIO-02",
    "socketio#9",
    Level::Must,
    Status::Normative,
    fw::TRANSPORT,
    "Over Socket.IO messages also travel by long polling."
);

rule!(
    SIO_03,
    "FW-SIO-03",
    "socketio#9",
    Level::Info,
    Status::Advisory,
    fw::DERIVED,
    "An event that isn't `fw`, or whose argument is no message, doesn't end the service."
);

rule!(
    TCP_02,
    "FW-TCP-02",
    "tcp#9",
    Level::Must,
    Status::Normative,
    fw::TRANSPORT,
    "Over TCP a message may come in several segments, and several in one."
);

rule!(
    TCP_03,
    "FW-TCP-03",
    "tcp#9",
    Level::Should,
    Status::Normative,
    fw::TRANSPORT,
    "Over TCP a line that is no JSON is passed over, and the next one is served."
);

rule!(
    TCP_04,
    "FW-TCP-04",
    "tcp#9",
    Level::Info,
    Status::Advisory,
    fw::DERIVED,
    "Over TCP half a message waits for the rest of it."
);
