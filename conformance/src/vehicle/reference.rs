//! Reference participants of a vehicle's arming checks, for tests of other programs.

use std::slice;
use std::time::{Duration, Instant};

use super::actor::{Actor, role, step};
use super::role::Purpose;
use crate::bus::{Bus, Event};
use crate::rules::px4::{Bug, Side};

/// The maximum time until a reference notices that it was asked to stop.
const NOTICE_TIME: Duration = Duration::from_millis(50);

/// Takes part in arming checks until `is_over` returns true. `bug` makes the reference violate a rule. `has_battery` is
/// true if a reference autopilot publishes its battery: the bus must announce type hashes then.
///
/// # Errors
/// Fails if the bus refuses a topic, or if the connection ends. The text describes the problem.
pub(crate) fn serve(
    bus: &mut dyn Bus,
    side: Side,
    has_battery: bool,
    bug: Option<&'static Bug>,
    is_over: &dyn Fn() -> bool,
) -> Result<(), String> {
    let role = role(side, Purpose::Reference { has_battery });
    let (mut actor, _) = Actor::join(bus, role, bug)?;
    while !is_over() {
        let step = step(slice::from_mut(&mut actor), bus, Instant::now() + NOTICE_TIME);
        if let Some(Event::Closed(reason)) = step.received {
            return Err(reason);
        }
        if let Some(problem) = actor.problems.pop() {
            return Err(problem);
        }
    }
    actor.leave(bus);
    Ok(())
}
