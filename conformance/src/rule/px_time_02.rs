//! `PX-TIME-02`.

use super::{
    Channel, Check, Checker, Detail, Interest, Judged, Level, Message, Mutant, PerChannel, Place, Rule,
    Status,
};
use crate::sample::Flight;

pub(super) static RULE: Rule = Rule {
    id: "PX-TIME-02",
    level: Level::Info,
    status: Status::Advisory,
    statement: "Where a topic that comes regularly pauses for more than ten of its periods, a dropout stands nearby.",
    source: "derived: PX4's logger writes a dropout where it lost data",
    applies_to: "messages over time",
    check: Check::State(|| Box::new(Gaps::default())),
    mutants: &[
        Mutant {
            name: "a topic pauses, in a log",
            make: |flight| Some(pause(flight)?.log().to_bytes()),
            also: &[],
        },
        Mutant {
            name: "a topic pauses, as JSON",
            make: |flight| Some(pause(flight)?.lines().to_bytes()),
            also: &[],
        },
        Mutant {
            name: "a topic pauses, in MCAP",
            make: |flight| Some(pause(flight)?.bag().to_bytes()),
            also: &[],
        },
    ],
};

/// How many periods a channel is looked at before anything is said of it.
const LEARNED: u32 = 32;

/// A pause is one from so many periods on.
const PAUSE: u64 = 10;

/// How far a dropout reaches beyond its length, in µs: what was lost then was published shortly before.
const NEARBY: u64 = 1_000_000;

#[derive(Default)]
struct Gaps {
    channels: PerChannel<Rhythm>,
    /// The time of the latest message of any channel.
    now: u64,
    /// Up to when pauses have a reason.
    excused_until: u64,
}

/// The rhythm of a channel. The period is an estimate of the median that needs no memory: it goes up and down
/// by a small step, so that rare pauses don't move it.
#[derive(Clone, Copy, Default)]
struct Rhythm {
    latest: u64,
    period: u64,
    seen: u32,
}

impl Checker for Gaps {
    fn opened(&mut self, channel: &Channel<'_>, _: &mut Judged<'_>) -> Interest {
        self.channels.open(channel, Rhythm::default());
        Interest::Times
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, judged: &mut Judged<'_>) {
        let (Some(timestamp), Some(rhythm)) = (message.timestamp, self.channels.of(channel)) else {
            return;
        };
        self.now = self.now.max(timestamp);
        let Rhythm { latest, period, seen } = *rhythm;
        let pause = timestamp.saturating_sub(latest);
        if latest > 0 && pause > 0 {
            rhythm.learn(pause);
        }
        rhythm.latest = timestamp;
        if seen <= LEARNED {
            return;
        }
        judged.exercise();
        if pause > period.saturating_mul(PAUSE) && latest > self.excused_until {
            let definition = judged.defined(channel.definition);
            judged.report_defined(channel.topic, message.place, definition, || {
                let (pause, period) = (pause / 1000, period / 1000);
                Detail::new(format!("{pause} ms without a message, where one comes each {period} ms"))
                    .expected(format!("{} ms at most, or a dropout", PAUSE * period))
                    .actual(format!("{pause} ms"))
            });
        }
    }

    fn dropout(&mut self, milliseconds: u16, _: Place) {
        let reach = u64::from(milliseconds) * 1000 + NEARBY;
        self.excused_until = self.now.saturating_add(reach);
    }
}

impl Rhythm {
    fn learn(&mut self, pause: u64) {
        let step = (self.period / 16).max(1);
        self.period = match self.seen {
            0 => pause,
            _ if pause > self.period => self.period + step.min(pause - self.period),
            _ => self.period - step.min(self.period - pause),
        };
        self.seen = self.seen.saturating_add(1);
    }
}

/// An hour, in µs: longer than any flight of tests.
const HOUR: u64 = 3_600_000_000;

/// The last message of a topic comes late.
fn pause<'d>(flight: &Flight<'d>) -> Option<Flight<'d>> {
    flight.with_last(flight.regular(|_| true)?, |message| message["timestamp"] = HOUR.into())
}
