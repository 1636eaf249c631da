//! The roles that this program can take on a vehicle's bus.
//!
//! A role is a state machine that does no input or output, and has no clock. An [`Actor`](super::actor::Actor) connects
//! a role to a bus.

use uavspec_model::Endpoint;
use uavspec_rules::px4::Sent;

/// A participant of the bus. All times are in µs since boot.
pub(crate) trait Role {
    /// The folder of the topics that this participant publishes: `in` or `out`. The received topics are in the other
    /// folder.
    fn folder(&self) -> &'static str;

    /// The types of the published messages.
    fn published(&self) -> &'static [&'static str];

    /// The types of the received messages.
    fn received(&self) -> &'static [&'static str];

    /// Handles a publisher or subscriber that was discovered.
    fn discovered(&mut self, _endpoint: &Endpoint, _now: u64) {}

    /// Handles a message. Returns the messages to send.
    fn receive(&mut self, message: &Sent, now: u64) -> Vec<Sent>;

    /// Returns the messages that are due.
    fn tick(&mut self, now: u64) -> Vec<Sent>;

    /// The time of the next [`tick`](Self::tick). `None` if nothing is due.
    fn next_tick(&self) -> Option<u64>;

    /// Ends the role. Returns the last messages to send.
    fn leave(&mut self) -> Vec<Sent> {
        Vec::new()
    }

    /// Notable events for the report.
    fn notes(&self) -> Vec<String>;
}

/// The purpose of a role.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Purpose {
    /// The role tests other participants: it sends unusual but valid messages.
    Judge,
    /// The role is a reference for other programs.
    Reference,
}
