//! `FW-SIO-02`.

use uavspec_flockwave::transport::endpoint::Carrier;

use super::prelude::*;

/// The rule.
pub static RULE: FlockwaveRule = FlockwaveRule::new(Rule {
    id: "FW-SIO-02",
    name: "Socket.IO long polling",
    level: Level::Should,
    status: Status::Advisory,
    statement: "Over Socket.IO, messages can also be exchanged by long polling.",
    source: source::TRANSPORT,
    applies_to: served::APPLIES_TO,
    why: "Socket.IO clients start with long polling by default, and keep polling if a proxy blocks \
          WebSockets. If long polling is unavailable, these clients cannot connect.",
    example: "→ GET /socket.io/?EIO=4&transport=polling\n← HTTP/1.1 400 Bad Request",
    fix: "Enable the `polling` transport of the Socket.IO server, and allow it in every proxy in front of \
          the server.",
})
.checks(&[Check::Exchange(served::check)])
.bug(Bug::behaviour("Over Socket.IO, long polling is refused.").needs(Needs::SocketIo))
.trial(Trial::Attempts(Strain::Sound, attempts))
.mutants(&served::mutants("socketio#9"));

fn attempts(endpoint: &Endpoint) -> Vec<Attempt> {
    let Endpoint::SocketIo { carrier, .. } = endpoint else { return Vec::new() };
    let other = (*carrier == Carrier::WebSocket).then(|| endpoint.by(Carrier::Polling));
    vec![Attempt { endpoint: other, ..Attempt::new("long polling", [Step::request("one")]) }]
}
