//! `PX-EVT-08`.

use uavspec_dynamic::DynamicView;
use uavspec_px4::event::{ARMED, ARMING_EVENTS, RawEvent};

use super::evt::{events, is_event};
use super::ext::number;
use super::prelude::*;
use crate::sample::{Entry, Log};

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-EVT-08",
    name: "Events about arming agree with the state",
    level: Level::Info,
    status: Status::Advisory,
    statement: "After an event about arming or disarming, the next `vehicle_status` of the log has the \
                same arming state and the same reason.",
    source: "`arming_state`, `latest_arming_reason` and `latest_disarming_reason` of VehicleStatus",
    applies_to: "logs",
    why: "Tools that read the state and ground stations that show events give the operator contradictory \
          information.",
    example: "10.486 s commander_disarmed_by: 6 (landing)\n\
              10.486 s vehicle_status.latest_disarming_reason: 8",
    fix: "Before the event is sent, set the reason in VehicleStatus to the number in the event.",
})
.check(Check::State(|| Box::new(Changes::default())))
.mutants(&[
    Mutant::ulog("a state whose reason differs from the event", |flight, log| with_status(flight, log, 2, 4)),
    Mutant::ulog("a disarmed state after an event about arming", |flight, log| {
        with_status(flight, log, 1, 3)
    }),
]);

/// Compares events about arming with the vehicle states that follow them. Only the first instances of both topics
/// count.
#[derive(Default)]
struct Changes {
    /// The latest event that no state has followed yet, with its time in µs.
    event: Option<(u64, Event)>,
}

#[derive(Clone, Copy)]
struct State {
    is_armed: bool,
    /// The reasons for arming and disarming.
    reasons: [Option<u8>; 2],
}

#[derive(Clone)]
struct Event {
    /// The index in [`ARMING_EVENTS`].
    change: usize,
    reason: u8,
    topic: String,
    location: Location,
}

impl Checker for Changes {
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest {
        let is_relevant = channel.topic == STATUS || is_event(channel, context);
        if channel.multi_id == Some(0) && is_relevant { Interest::Values } else { Interest::Nothing }
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, context: &mut RuleContext<'_>) {
        let (Some(values), Some(time)) = (message.values, message.timestamp) else { return };
        if channel.topic == STATUS {
            let Some(armed) = number::<u8>(values, "arming_state") else { return };
            let reasons = ARMING_EVENTS.map(|(_, field)| number(values, field));
            if let Some((_, event)) = self.event.take_if(|(sent, _)| *sent <= time) {
                State { is_armed: armed == ARMED, reasons }.judge(&event, context);
            }
        } else if let Some(event) = change(channel, values, message.location, context) {
            self.event = Some((time, event));
        }
    }

    fn dropout(&mut self, _: u16, _: Location) {
        *self = Self::default();
    }

    fn corruption(&mut self, _: Location) {
        *self = Self::default();
    }
}

/// The topic with the vehicle states.
const STATUS: &str = "vehicle_status";

/// The arming or disarming that a message reports. `None` if it contains another event.
fn change(
    channel: &Channel<'_>,
    values: DynamicView<'_>,
    location: Location,
    context: &RuleContext<'_>,
) -> Option<Event> {
    let event = RawEvent::read(values)?.decode(events(context)?).ok()?;
    let change = ARMING_EVENTS.iter().position(|(name, _)| event.event.name == *name)?;
    let reason = event.values.first()?.integer()?.try_into().ok()?;
    Some(Event { change, reason, topic: channel.full_topic.to_owned(), location })
}

impl State {
    fn judge(self, event: &Event, context: &mut RuleContext<'_>) {
        context.covered();
        let (name, field) = ARMING_EVENTS[event.change];
        let arms = event.change == 0;
        let stated = self.reasons[event.change];
        let detail = if self.is_armed != arms {
            let state = |is_armed: bool| if is_armed { "armed" } else { "disarmed" };
            Detail::new(format!("after {name}, the vehicle is {} according to vehicle_status", state(!arms)))
                .expected(state(arms))
                .actual(state(!arms))
        } else if let Some(other) = stated.filter(|stated| *stated != event.reason) {
            Detail::new(format!("{name} and vehicle_status.{field} have different reasons"))
                .expected(other.to_string())
                .actual(event.reason.to_string())
        } else {
            return;
        };
        let topic = SubjectName { name: &event.topic, instance: Some(0) };
        context.violation_of(topic, event.location, None, || detail);
    }
}

/// Adds a state after the last event, which is about arming. The sample has no topic `vehicle_status`.
fn with_status(flight: &Flight<'_>, mut log: Log, armed: u8, reason: u8) -> Option<Log> {
    let last = flight.messages.get(flight.last_event(3)?)?;
    let time = last.value["timestamp"].as_u64()?;
    let fields = "uint64_t timestamp;uint8_t arming_state;uint8_t latest_arming_reason;".to_owned();
    let id = u16::MAX;
    log.entries.insert(1, Entry::Format(STATUS.to_owned(), fields));
    log.entries.push(Entry::Subscription(id, 0, STATUS.to_owned()));
    log.entries.push(Entry::Data(id, [&time.to_le_bytes()[..], &[armed, reason]].concat()));
    Some(log)
}
