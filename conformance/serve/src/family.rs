//! Request handlers, one module per message family.

mod asynchronous;
mod authentication;
mod beacon;
mod clock;
mod connection;
mod device;
mod extension;
mod log;
mod object;
mod parameter;
mod rtk;
mod show;
mod system;
mod uav;
mod weather;

use uavspec_rules::flockwave::env_24;
use uavspec_types::flockwave::json::Request;

use super::hub::{Answer, Hub, RequestHandler, SessionId};

/// The handlers of all families, by the first part of the message type.
const FAMILIES: [(&str, RequestHandler); 15] = [
    ("ASYNC", asynchronous::answer),
    ("AUTH", authentication::answer),
    ("BCN", beacon::answer),
    ("CLK", clock::answer),
    ("CONN", connection::answer),
    ("DEV", device::answer),
    ("EXT", extension::answer),
    ("LOG", log::answer),
    ("OBJ", object::answer),
    ("PRM", parameter::answer),
    ("RTK", rtk::answer),
    ("SHOW", show::answer),
    ("SYS", system::answer),
    ("UAV", uav::answer),
    ("WTH", weather::answer),
];

/// Answers a request.
pub(super) fn answer(hub: &mut Hub, session: SessionId, request: Request) -> Answer {
    let name = request.message_type().split('-').next().unwrap_or_default();
    let family = FAMILIES.iter().find(|(known, _)| *known == name).map(|(_, family)| family);
    match family {
        Some(_) if name == "DEV" && hub.has_bug(&env_24::RULE) => Err(unknown(&request)),
        Some(family) => family(hub, session, request),
        None if ["ACK-ACK", "ACK-NAK"].contains(&request.message_type()) => {
            Err("acknowledgments are responses, not requests".to_owned())
        }
        None => Err(unknown(&request)),
    }
}

/// The error for an unsupported type.
fn unknown(request: &Request) -> String {
    // The type may be as long as the whole message.
    let name: String = request.message_type().chars().take(40).collect();
    format!("no handler for requests of type {name}")
}
