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

use super::hub::{Answer, Call, Hub};

/// What answers the requests of a family.
type Family = fn(&mut Hub, &Call<'_>) -> Answer;

/// The families that the server has, by the first part of their types.
const FAMILIES: [(&str, Family); 15] = [
    ("ACK", acknowledge),
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

/// Answers a request.
pub(super) fn answer(hub: &mut Hub, call: &Call<'_>) -> Answer {
    let name = call.kind.split('-').next().unwrap_or_default();
    let family = FAMILIES.iter().find(|(known, _)| *known == name).map(|(_, family)| family);
    match family {
        Some(_) if name == "DEV" && hub.breaks("FW-ENV-24") => Err(unknown(call)),
        Some(family) => family(hub, call),
        None => Err(unknown(call)),
    }
}

/// Why a type of its family isn't answered.
fn unknown(call: &Call<'_>) -> String {
    // A type can be as long as a message.
    let name: String = call.kind.chars().take(40).collect();
    format!("no handler for requests of type {name}")
}

/// Nobody asks for acknowledgments: they are answers.
fn acknowledge(_hub: &mut Hub, call: &Call<'_>) -> Answer {
    match call.kind {
        "ACK-ACK" | "ACK-NAK" => Err("acknowledgments come as responses only".to_owned()),
        _ => Err(unknown(call)),
    }
}
