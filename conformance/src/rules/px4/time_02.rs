//! `PX-TIME-02`.

use super::{
    Change, Channel, Check, Checker, Detail, Interest, Level, Location, Message, Mutant, PerChannel, Px4Rule,
    Rule, RuleContext, Status,
};
use crate::rules::sample::Flight;

pub(super) static RULE: Px4Rule = Px4Rule {
    rule: Rule {
        id: "PX-TIME-02",
        level: Level::Info,
        status: Status::Advisory,
        statement: "Where a topic that comes regularly pauses for more than ten of its periods, a dropout stands nearby.",
        source: "derived: PX4's logger writes a dropout where it lost data",
        applies_to: "messages over time",
        why: "",
        example: "",
        fix: "",
    },
    check: Check::State(|| Box::new(Gaps::default())),
    mutants: &[Mutant { name: "a topic pauses", change: Change::Flight(pause), also: &[] }],
};

/// How many periods a channel is looked at before anything is said of it.
const LEARNING_PERIODS: usize = 32;

/// A pause is one from so many periods on.
const PAUSE: u64 = 10;

/// How far a dropout reaches beyond its length, in µs: what was lost then was published shortly before.
const DROPOUT_MARGIN: u64 = 1_000_000;

#[derive(Default)]
struct Gaps {
    channels: PerChannel<Rhythm>,
    /// The time of the latest message of any channel.
    now: u64,
    /// Up to when pauses have a reason.
    excused_until: u64,
}

/// The rhythm of a channel. Its period is the median of the first pauses; from then on an estimate of the median that
/// needs no memory: it goes up and down by a small step, so that rare pauses don't move it.
#[derive(Clone, Default)]
struct Rhythm {
    latest: u64,
    /// None until it is learned.
    period: Option<u64>,
    first: Vec<u64>,
}

impl Checker for Gaps {
    fn opened(&mut self, channel: &Channel<'_>, _: &mut RuleContext<'_>) -> Interest {
        self.channels.open(channel, Rhythm::default());
        Interest::Times
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, context: &mut RuleContext<'_>) {
        let (Some(timestamp), Some(rhythm)) = (message.timestamp, self.channels.get(channel)) else {
            return;
        };
        self.now = self.now.max(timestamp);
        let Rhythm { latest, period, .. } = *rhythm;
        let pause = timestamp.saturating_sub(latest);
        if latest > 0 && pause > 0 {
            rhythm.learn(pause);
        }
        rhythm.latest = timestamp;
        let Some(period) = period else { return };
        context.covered();
        if pause > period.saturating_mul(PAUSE) && latest > self.excused_until {
            let definition = context.defined(channel.definition);
            context.violation_of(channel.topic, message.location, definition, || {
                let (pause, most) = (time_text(pause), time_text(period.saturating_mul(PAUSE)));
                let period = time_text(period);
                Detail::new(format!("{pause} without a message, where one comes each {period}"))
                    .expected(format!("{most} at most, or a dropout"))
                    .actual(pause)
            });
        }
    }

    fn dropout(&mut self, milliseconds: u16, _: Location) {
        let reach = u64::from(milliseconds) * 1000 + DROPOUT_MARGIN;
        self.excused_until = self.now.saturating_add(reach);
    }
}

impl Rhythm {
    fn learn(&mut self, pause: u64) {
        if let Some(period) = &mut self.period {
            let step = (*period / 16).max(1);
            *period = pause.clamp(period.saturating_sub(step), period.saturating_add(step));
            return;
        }
        self.first.push(pause);
        if self.first.len() == LEARNING_PERIODS {
            let mut first = std::mem::take(&mut self.first);
            let (_, median, _) = first.select_nth_unstable(LEARNING_PERIODS / 2);
            self.period = Some(*median);
        }
    }
}

fn time_text(time: u64) -> String {
    match time {
        0..1_000 => format!("{time} µs"),
        1_000.. => format!("{} ms", time / 1_000),
    }
}

/// An hour, in µs: longer than any flight of tests.
const HOUR: u64 = 3_600_000_000;

/// The last message of a topic comes late.
fn pause<'d>(flight: &Flight<'d>) -> Option<Flight<'d>> {
    flight.with_last(flight.regular(|_| true)?, |message| message["timestamp"] = HOUR.into())
}
