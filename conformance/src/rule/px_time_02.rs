//! `PX-TIME-02`.

use super::{Channel, Check, Checker, Judged, Level, Message, Place, Rule};

pub(super) const RULE: Rule = Rule {
    id: "PX-TIME-02",
    level: Level::Info,
    statement: "Where a topic that comes regularly pauses for more than ten of its periods, a dropout stands nearby.",
    source: "derived: PX4's logger writes a dropout where it lost data",
    check: Check::State(|| Box::new(Gaps::default())),
};

/// How many periods a channel is looked at before anything is said of it.
const LEARNED: u32 = 32;

/// A pause is one from so many periods on.
const PAUSE: u64 = 10;

/// How far a dropout reaches beyond its length, in µs: what was lost then was published shortly before.
const NEARBY: u64 = 1_000_000;

#[derive(Default)]
struct Gaps {
    channels: Vec<Rhythm>,
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
    fn opened(&mut self, channel: &Channel<'_>, _: &mut Judged<'_>) {
        let count = self.channels.len().max(channel.index + 1);
        self.channels.resize(count, Rhythm::default());
        self.channels[channel.index] = Rhythm::default();
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, judged: &mut Judged<'_>) {
        let (Some(timestamp), Some(rhythm)) = (message.timestamp, self.channels.get_mut(channel.index))
        else {
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
        if pause > PAUSE * period && latest > self.excused_until {
            judged.report(channel.topic, message.place, || {
                format!("{} ms without a message, where one comes each {} ms", pause / 1000, period / 1000)
            });
        }
    }

    fn dropout(&mut self, milliseconds: u16, _: Place) {
        self.excused_until = self.now + u64::from(milliseconds) * 1000 + NEARBY;
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
