//! The families of messages, each with what answers its requests.

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
mod system;
mod uav;
mod weather;

use uavspec::flockwave::json::Request;

use super::hub::{Answer, Hub, SessionId};
use crate::rules::flockwave::env_24;

/// What answers the requests of a family.
type Family = fn(&mut Hub, SessionId, Request) -> Answer;

/// The families that the server has, by the first part of their types.
const FAMILIES: [(&str, Family); 14] = [
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
    ("SYS", system::answer),
    ("UAV", uav::answer),
    ("WTH", weather::answer),
];

/// Answers a request that came on a connection.
pub(super) fn answer(hub: &mut Hub, session: SessionId, request: Request) -> Answer {
    let name = request.message_type().split('-').next().unwrap_or_default();
    let family = FAMILIES.iter().find(|(known, _)| *known == name).map(|(_, family)| family);
    match family {
        Some(_) if name == "DEV" && hub.has_bug(&env_24::RULE) => Err(unknown(&request)),
        Some(family) => family(hub, session, request),
        None if ["ACK-ACK", "ACK-NAK"].contains(&request.message_type()) => {
            Err("acknowledgments come as responses only".to_owned())
        }
        None => Err(unknown(&request)),
    }
}

/// Why a type isn't answered.
fn unknown(request: &Request) -> String {
    // A type can be as long as a message.
    let name: String = request.message_type().chars().take(40).collect();
    format!("no handler for requests of type {name}")
}
