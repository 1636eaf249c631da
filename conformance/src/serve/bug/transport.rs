//! Bugs in how messages travel. What listens asks for those that don't change messages.

use super::Bug;

pub(super) const BUGS: &[Bug] = &[
    Bug::behaviour("FW-TCP-01", "Over TCP, notifications are written in several lines."),
    Bug::behaviour("FW-TCP-02", "Over TCP, only the first of several requests in a segment is taken."),
    Bug::behaviour("FW-TCP-03", "Over TCP, a line that is no JSON ends the connection."),
    Bug::behaviour(
        "FW-TCP-04",
        "Over TCP, the beginning of a message is forgotten that ends in another segment.",
    )
    .with(&["FW-TCP-02"]),
    Bug::behaviour("FW-UDP-01", "Over UDP, each notification is twice in its datagram."),
    Bug::behaviour("FW-UDP-02", "Over UDP, answers go to the port after that of the sender."),
    Bug::behaviour("FW-UDP-03", "Over UDP, a datagram that is no JSON ends the service."),
    Bug::behaviour("FW-SIO-01", "Over Socket.IO, messages travel as events flockwave."),
    Bug::behaviour("FW-SIO-02", "Over Socket.IO, long polling is refused."),
    Bug::behaviour(
        "FW-SIO-03",
        "Over Socket.IO, nothing is answered any more after an event that is none of Flockwave.",
    ),
];
