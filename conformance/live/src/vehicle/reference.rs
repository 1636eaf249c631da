//! Reference participants of a vehicle's arming checks, for tests of other programs.

use std::slice;
use std::sync::Arc;

use uavspec_rules::definitions::Library;
use uavspec_rules::px4::{Bug, Side};

use super::NOTICE_TIME;
use super::actor::{Actor, role, step};
use super::namespace::Namespace;
use super::release::Release;
use super::role::Purpose;
use crate::bus::{Bus, Event};

/// Takes part in arming checks until `is_over` returns true. Uses the newest release, unless the user requests another
/// one. With `bug`, the reference violates a rule.
///
/// # Errors
/// Fails if the bus refuses a topic, or if the connection ends. The error describes the problem.
pub fn serve(
    bus: &mut dyn Bus,
    library: &Library,
    namespace: &Namespace,
    side: Side,
    bug: Option<&'static Bug>,
    is_over: &dyn Fn() -> bool,
) -> Result<(), String> {
    let release = Arc::new(Release::new(library.base(), library, namespace.clone()));
    let role = role(side, Purpose::Reference, &release);
    let (mut actor, _) = Actor::join(bus, role, release, bug)?;
    let clock = bus.clock();
    while !is_over() {
        let step = step(slice::from_mut(&mut actor), bus, clock.now() + NOTICE_TIME);
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
