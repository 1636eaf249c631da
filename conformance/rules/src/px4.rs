//! The PX4 rules (`PX-…`), one file each.

mod arr_01;
mod bool_01;
mod bug;
mod cdr_01;
mod cdr_02;
mod data_01;
mod data_02;
mod data_03;
mod endpoints;
mod enum_01;
mod evt;
mod evt_01;
mod evt_02;
mod evt_03;
mod evt_04;
mod evt_05;
mod evt_06;
mod evt_07;
mod evt_08;
mod ext;
mod ext_01;
mod ext_02;
mod ext_03;
mod ext_04;
mod ext_05;
mod ext_06;
mod ext_07;
mod fmt_01;
mod fmt_02;
mod fmt_03;
mod fsf_03;
mod hash_01;
mod hash_02;
mod json_01;
mod json_02;
mod len_01;
mod nan_01;
mod prelude;
mod qos_01;
mod queue_01;
mod range_01;
mod str_01;
mod time_01;
mod time_02;
mod type_01;
mod ver_01;

use uavspec_model::{ApplicationType, Channel, Detail, Endpoint, Location, Message, Rule, SubjectName};
use uavspec_px4::ValueRules;
use uavspec_runtime::ConstraintKind;
use uavspec_schema::MessageId;

pub use self::bug::{Bug, Needs, Sent, Side, merge};
/// The names of mode requirements, and the flags that belong to them.
pub use self::fsf_03::{REQUIREMENT, belongs_to};
/// The rules checked by capture readers.
pub use self::{
    cdr_01::RULE as CDR_01, cdr_02::RULE as CDR_02, data_01::RULE as DATA_01, data_02::RULE as DATA_02,
    evt_01::RULE as EVT_01, fmt_01::RULE as FMT_01, fmt_02::RULE as FMT_02, fmt_03::RULE as FMT_03,
    hash_01::RULE as HASH_01,
};
use super::RuleContext;
use super::sample::{Bag, Encoding, Flight, Lines, Log};

/// The PX4 rules, sorted by id.
pub static RULES: [&Px4Rule; 41] = [
    &arr_01::RULE,
    &bool_01::RULE,
    &cdr_01::RULE,
    &cdr_02::RULE,
    &data_01::RULE,
    &data_02::RULE,
    &data_03::RULE,
    &enum_01::RULE,
    &evt_01::RULE,
    &evt_02::RULE,
    &evt_03::RULE,
    &evt_04::RULE,
    &evt_05::RULE,
    &evt_06::RULE,
    &evt_07::RULE,
    &evt_08::RULE,
    &ext_01::RULE,
    &ext_02::RULE,
    &ext_03::RULE,
    &ext_04::RULE,
    &ext_05::RULE,
    &ext_06::RULE,
    &ext_07::RULE,
    &fmt_01::RULE,
    &fmt_02::RULE,
    &fmt_03::RULE,
    &fsf_03::RULE,
    &hash_01::RULE,
    &hash_02::RULE,
    &json_01::RULE,
    &json_02::RULE,
    &len_01::RULE,
    &nan_01::RULE,
    &qos_01::RULE,
    &queue_01::RULE,
    &range_01::RULE,
    &str_01::RULE,
    &time_01::RULE,
    &time_02::RULE,
    &type_01::RULE,
    &ver_01::RULE,
];

/// The rules on single values.
pub static VALUES: ValueRules = ValueRules {
    bool: &bool_01::RULE.rule,
    text: &str_01::RULE.rule,
    number: |demand| match demand {
        ConstraintKind::Count => &len_01::RULE.rule,
        ConstraintKind::Enum => &enum_01::RULE.rule,
        ConstraintKind::Nan => &nan_01::RULE.rule,
        ConstraintKind::Range => &range_01::RULE.rule,
        ConstraintKind::Bound => &cdr_02::RULE.rule,
        ConstraintKind::Text => &str_01::RULE.rule,
    },
    members: &json_01::RULE.rule,
    json_type: &json_02::RULE.rule,
    length: &arr_01::RULE.rule,
};

/// A PX4 rule with its check and its mutants.
#[derive(Debug)]
pub struct Px4Rule {
    /// The statement.
    pub rule: Rule,
    /// The check.
    pub check: Check,
    /// A bug in a reference participant that violates the rule, if there is one.
    pub bug: Option<Bug>,
    /// Changes that violate the rule.
    pub mutants: &'static [Mutant],
}

impl Px4Rule {
    /// Creates a rule from its text. The other functions set its check and its mutants, which each rule needs, and its
    /// bug.
    const fn new(rule: Rule) -> Self {
        Self { rule, check: Check::Value, bug: None, mutants: &[] }
    }

    /// Sets the check.
    const fn check(self, check: Check) -> Self {
        Self { check, ..self }
    }

    /// Sets the bug in a reference participant that violates the rule.
    const fn bug(self, bug: Bug) -> Self {
        Self { bug: Some(bug), ..self }
    }

    /// Sets the changes that violate the rule.
    const fn mutants(self, mutants: &'static [Mutant]) -> Self {
        Self { mutants, ..self }
    }
}

/// The way a rule is checked.
#[derive(Clone, Copy, Debug)]
pub enum Check {
    /// A plan that is compiled for the format checks each value.
    Value,
    /// The capture reader itself reports violations, because a violation makes the data unreadable for other checks.
    Source,
    /// A stateful checker receives the records of a capture.
    State(fn() -> Box<dyn Checker>),
}

/// A small change to a flight or its capture that violates a rule.
#[derive(Debug)]
pub struct Mutant {
    /// A description of the change.
    pub name: &'static str,
    /// The change.
    pub change: Change,
    /// Other rules that the change also violates.
    pub also: &'static [&'static Px4Rule],
}

impl Mutant {
    /// Creates a mutant that changes the flight. The flight is written in each encoding that can represent the change.
    const fn flight(name: &'static str, change: for<'d> fn(&Flight<'d>) -> Option<Flight<'d>>) -> Self {
        Self { name, change: Change::Flight(change), also: &[] }
    }

    /// Like [`Self::flight`], for a rule that applies only to these encodings.
    const fn flight_in(
        name: &'static str,
        encodings: &'static [Encoding],
        change: for<'d> fn(&Flight<'d>) -> Option<Flight<'d>>,
    ) -> Self {
        Self { name, change: Change::FlightIn(encodings, change), also: &[] }
    }

    /// Creates a mutant that changes the `ULog` of a flight.
    const fn ulog(name: &'static str, change: fn(&Flight<'_>, Log) -> Option<Log>) -> Self {
        Self { name, change: Change::Ulog(change), also: &[] }
    }

    /// Creates a mutant that changes the MCAP file of a flight.
    const fn mcap(name: &'static str, change: fn(&Flight<'_>, Bag) -> Option<Bag>) -> Self {
        Self { name, change: Change::Mcap(change), also: &[] }
    }

    /// Creates a mutant that changes the text of JSON Lines files in both encodings.
    const fn json(name: &'static str, change: fn(Lines) -> Option<Lines>) -> Self {
        Self { name, change: Change::Json(change), also: &[] }
    }

    /// Sets the rules that the mutant violates in addition to its own rule.
    const fn also(self, also: &'static [&'static Px4Rule]) -> Self {
        Self { also, ..self }
    }
}

/// The function that makes a mutant. The function returns `None` if the definitions don't allow the change.
#[derive(Clone, Copy, Debug)]
pub enum Change {
    /// Changes the flight. The result is written in each encoding that can represent the change.
    Flight(for<'d> fn(&Flight<'d>) -> Option<Flight<'d>>),
    /// Like `Flight`, for a rule that applies only to these encodings.
    FlightIn(&'static [Encoding], for<'d> fn(&Flight<'d>) -> Option<Flight<'d>>),
    /// Changes the `ULog` of a flight.
    Ulog(fn(&Flight<'_>, Log) -> Option<Log>),
    /// Changes the MCAP file of a flight.
    Mcap(fn(&Flight<'_>, Bag) -> Option<Bag>),
    /// Changes the text of JSON Lines files in both encodings.
    Json(fn(Lines) -> Option<Lines>),
}

impl Change {
    /// The changed captures of a flight, one for each encoding that can represent the change.
    pub(super) fn captures(&self, flight: &Flight<'_>) -> Vec<(Encoding, Vec<u8>)> {
        let written: [Option<(Encoding, Vec<u8>)>; Encoding::ALL.len()] = match self {
            Self::Flight(change) | Self::FlightIn(_, change) => {
                let changed = change(flight);
                Encoding::ALL.map(|encoding| {
                    let changed = changed.as_ref().filter(|_| self.applies_to(encoding))?;
                    Some((encoding, encoding.write_change(flight, changed)?))
                })
            }
            Self::Ulog(change) => {
                let log = change(flight, flight.log());
                [log.map(|log| (Encoding::Ulog, log.to_bytes())), None, None, None]
            }
            Self::Mcap(change) => {
                let bag = change(flight, flight.bag());
                [bag.map(|bag| (Encoding::Mcap, bag.to_bytes())), None, None, None]
            }
            Self::Json(change) => {
                let [typed, published] =
                    [flight.lines(), flight.rosbridge()].map(|lines| Some(change(lines)?.to_bytes()));
                [
                    typed.map(|bytes| (Encoding::Lines, bytes)),
                    published.map(|bytes| (Encoding::Rosbridge, bytes)),
                    None,
                    None,
                ]
            }
        };
        written.into_iter().flatten().collect()
    }

    /// True if the rule applies to an encoding of the changed flight.
    fn applies_to(&self, encoding: Encoding) -> bool {
        match self {
            Self::FlightIn(encodings, _) => encodings.contains(&encoding),
            _ => true,
        }
    }
}

/// The parts of a channel that a rule needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Interest {
    /// Only the opening of the channel.
    #[default]
    Nothing,
    /// The times of the messages.
    Times,
    /// The times and values of the messages.
    Values,
}

/// Checks the records of one capture.
pub trait Checker {
    /// Handles a new channel, and returns the checker's interest in it. For [`Interest::Nothing`], [`Self::message`]
    /// isn't called.
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest;

    /// Handles the end of a channel: the channel was unsubscribed, or another channel took its index. May be called
    /// twice.
    fn closed(&mut self, _channel: &Channel<'_>) {}

    /// Receives the start time of the capture, in µs since boot.
    fn started(&mut self, _time: u64) {}

    /// Checks a message.
    fn message(&mut self, _channel: &Channel<'_>, _message: &Message<'_>, _context: &mut RuleContext<'_>) {}

    /// Handles a dropout, during which records were lost.
    fn dropout(&mut self, _milliseconds: u16, _place: Location) {}

    /// Handles unreadable data, which may have contained records that the rule needs.
    fn corruption(&mut self, _place: Location) {}

    /// Handles a publisher or subscriber that was discovered, or whose quality of service changed.
    fn endpoint(&mut self, _endpoint: &Endpoint, _place: Location, _context: &mut RuleContext<'_>) {}

    /// Handles the end of a publisher or subscriber.
    fn endpoint_ended(&mut self, _id: &str) {}

    /// Receives a type in an application that was compared with the vehicle.
    fn application(&mut self, _ty: &ApplicationType) {}

    /// Handles the end of the capture.
    fn end(&mut self, _context: &mut RuleContext<'_>) {}
}

/// A state for each channel.
#[derive(Debug)]
struct PerChannel<T> {
    /// The states by the index of the channel, each with the number of resets before it was set.
    states: Vec<(u64, T)>,
    /// The number of resets.
    resets: u64,
}

impl<T: Default + Clone> PerChannel<T> {
    /// Sets the initial state of a channel.
    fn open(&mut self, channel: &Channel<'_>, state: T) {
        let count = self.states.len().max(channel.index + 1);
        self.states.resize(count, (self.resets, T::default()));
        self.states[channel.index] = (self.resets, state);
    }

    /// Sets the states of all channels to the default. This takes constant time, because a capture with many channels
    /// may lose a message of each of them.
    fn reset(&mut self) {
        self.resets += 1;
    }

    /// The state of an open channel.
    fn get(&mut self, channel: &Channel<'_>) -> Option<&mut T> {
        let (resets, state) = self.states.get_mut(channel.index)?;
        if *resets != self.resets {
            (*resets, *state) = (self.resets, T::default());
        }
        Some(state)
    }
}

impl<T> Default for PerChannel<T> {
    fn default() -> Self {
        Self { states: Vec::new(), resets: 0 }
    }
}

impl RuleContext<'_> {
    /// Reports a violation in a field of a channel's messages.
    fn violation_in_field(
        &mut self,
        channel: &Channel<'_>,
        name: &str,
        location: Location,
        detail: impl FnOnce() -> Detail,
    ) {
        self.violation_in(channel.subject(), (channel.definition, name), location, detail);
    }

    /// Reports a violation in a field of a topic's messages.
    fn violation_in(
        &mut self,
        topic: SubjectName<'_>,
        (definition, field): (Option<MessageId>, &str),
        location: Location,
        detail: impl FnOnce() -> Detail,
    ) {
        let definition = self.field(definition, field);
        let name = &format!("{}.{field}", topic.name);
        self.violation_of(SubjectName { name, ..topic }, location, definition, detail);
    }
}
