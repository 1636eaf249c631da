//! Events and reports, for the `PX-EVT-…` rules.
//!
//! These rules are checked with the event metadata of the capture, or with a file that the user names. uavspec itself
//! knows the events of one release only, so another firmware may use their ids with other arguments.

use uavspec_dynamic::event::Events;
use uavspec_px4::checks::{Reports, Step};
use uavspec_px4::event::{EventOrigin, RawEvent};

use super::ext::{is_reply, px4_message};
use super::prelude::*;

/// True if the messages of a channel are events.
pub(super) fn is_event(channel: &Channel<'_>, context: &RuleContext<'_>) -> bool {
    px4_message(channel, context) == Some("Event")
}

/// The events of the firmware. `None` if they aren't known.
pub(super) fn events<'c>(context: &RuleContext<'c>) -> Option<&'c Events> {
    let events = (context.events.origin != EventOrigin::BuiltIn).then(|| context.events.events());
    events.filter(|events| !events.is_empty())
}

/// A rule on single events, including events in replies of external components. The function returns the field that
/// violates the rule.
pub(super) struct Each(pub(super) fn(&RawEvent, &Events) -> Option<(&'static str, Detail)>);

impl Checker for Each {
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest {
        let has_events = is_event(channel, context) || is_reply(channel, context);
        if has_events { Interest::Values } else { Interest::Nothing }
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, context: &mut RuleContext<'_>) {
        let (Some(values), Some(events)) = (message.values, events(context)) else { return };
        let single = RawEvent::read(values);
        let is_nested = single.is_none();
        for event in single.into_iter().chain(RawEvent::of_reply(values)) {
            context.covered();
            if let Some((field, detail)) = (self.0)(&event, events) {
                let field = if is_nested { "events" } else { field };
                context.violation_in_field(channel, field, message.location, || detail);
            }
        }
    }
}

/// Checks the next step of a report. Returns the violation, if the step is one.
type Judge = fn(&Step, &Reports, &mut RuleContext<'_>) -> Option<Detail>;

/// A rule on the reports of a channel.
pub(super) struct Follow {
    channels: PerChannel<Reports>,
    judge: Judge,
}

impl Follow {
    pub(super) fn new(judge: Judge) -> Self {
        Self { channels: PerChannel::default(), judge }
    }
}

impl Checker for Follow {
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest {
        self.channels.open(channel, Reports::default());
        if is_event(channel, context) { Interest::Values } else { Interest::Nothing }
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, context: &mut RuleContext<'_>) {
        let (Some(events), Some(reports)) = (events(context), self.channels.get(channel)) else { return };
        let Some(event) = message.values.and_then(RawEvent::read) else { return };
        let step = reports.follow(&event, event.decode(events).ok().as_ref());
        if let Some(detail) = (self.judge)(&step, reports, context) {
            context.violation_in_field(channel, "id", message.location, || detail);
        }
    }

    fn dropout(&mut self, _: u16, _: Location) {
        self.channels.reset();
    }

    fn corruption(&mut self, _: Location) {
        self.channels.reset();
    }
}
