//! `uavspec serve --px4`.

use std::sync::mpsc::{TryRecvError, channel};

use serde_json::json;
use uavspec_live::bus::{self, Address};
use uavspec_live::vehicle;
use uavspec_model::clock::Clock;
use uavspec_model::text::terminal;
use uavspec_rules::px4::Side;
use uavspec_schema::msg::Dialect;

use super::{ServeArgs, bug, end_on_request};
use crate::app::{Exit, Format, Status, library};

/// Runs a reference participant until the time has passed, or the end is requested.
pub(super) fn serve_vehicle(args: &ServeArgs, address: &Address) -> Exit {
    let library = library(args.definitions.as_deref(), Some(Dialect::Px4), &[])?;
    let (side, name) =
        if args.component { (Side::Component, "component") } else { (Side::Autopilot, "autopilot") };
    let failed = |problem: String| Status::Unreadable.because(format_args!("{address}: {problem}"));
    let mut bus = bus::connect(address, &args.peer, &[]).map_err(failed)?;
    let (sender, ending) = channel();
    end_on_request(args, sender)?;
    match args.format {
        Format::Text => terminal::println!("{name} {address}"),
        Format::Json => {
            terminal::println!("{}", json!({ "role": name, "address": address.to_string() }));
        }
    }
    bug::announce(args.bug.as_ref());
    let started = Clock::real().now();
    let is_over = || {
        let is_requested = ending.try_recv() != Err(TryRecvError::Empty);
        is_requested || args.time.is_some_and(|time| Clock::real().now() >= started + time)
    };
    let bug = args.bug.as_ref().and_then(|bug| bug.of_vehicle);
    let served = vehicle::serve(&mut *bus, &library, &args.namespace, side, bug, &is_over);
    served.map(|()| Status::Conforms).map_err(failed)
}
