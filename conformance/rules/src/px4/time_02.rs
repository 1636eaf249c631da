//! `PX-TIME-02`.

use std::mem;

use uavspec_model::MAX_EXAMPLES;

use super::ext::is_of_px4;
use super::prelude::*;

pub(super) static RULE: Px4Rule = Px4Rule::new(Rule {
    id: "PX-TIME-02",
    name: "Pauses have a dropout record",
    level: Level::Info,
    status: Status::Advisory,
    statement: "If a topic with a regular period pauses for more than ten periods, the capture contains a \
                dropout record near the pause. A topic of a bag is checked only if its messages are in \
                the order of their log times.",
    source: "derived: PX4's logger records a dropout when it loses data",
    applies_to: "message sequences",
    why: "If there is no dropout record, either the publisher stopped or the loss was not recorded. Tools \
          interpolate over the gap.",
    example: "battery_status, every 20 ms: … 1.00 s, 1.02 s, 1.04 s, 2.51 s, 2.53 s …\n\
              \x20                            (no dropout near 1.04 s)",
    fix: "Check the publisher, and check the load of the logger during the pause. If the topic is meant \
          to pause, no change is necessary.",
})
.check(Check::State(|| Box::new(Gaps::default())))
.mutants(&[Mutant::flight("a pause of a topic with a regular period", pause)]);

/// The number of pauses from which the period of a channel is learned.
const LEARNING_PERIODS: usize = 32;

/// The minimum number of these pauses that must be between half the period and twice the period. Otherwise, the topic has
/// no regular period.
const REGULAR: usize = 28;

/// The maximum pause, in periods.
const PAUSE: u64 = 10;

/// The time after a dropout during which pauses are excused, in µs. The lost data was published shortly before the
/// dropout.
const DROPOUT_MARGIN: u64 = 1_000_000;

#[derive(Default)]
struct Gaps {
    channels: PerChannel<Rhythm>,
    /// The times of the latest messages; 0 if unknown.
    latest: PerChannel<u64>,
    /// The time of the latest message of any channel.
    now: u64,
    /// Pauses that start before this time are excused, because of a dropout.
    excused_until: u64,
}

/// The rhythm of a channel. The period starts as the median of the first pauses. Each further pause changes the period
/// by at most a small step, so rare long pauses have little effect.
#[derive(Clone, Default)]
struct Rhythm {
    /// Set if log times are known, as in bags. `ULog` files lack them, and have so many messages that a small `Rhythm`
    /// pays off.
    order: Option<Box<Order>>,
    /// `None` until the topic has shown a regular period.
    period: Option<u64>,
    first: Vec<u64>,
}

/// Tracks whether the messages of a channel are in the order of their log times, and stores the results, which don't
/// count otherwise.
#[derive(Clone, Default)]
struct Order {
    /// The latest log time.
    logged: u64,
    /// True if the messages aren't in the order of their log times. The messages of a pause may follow later.
    is_lost: bool,
    /// The number of pauses that were checked.
    checked: u64,
    /// The number of findings.
    found: u64,
    /// The locations of the first findings.
    examples: Vec<Location>,
}

impl Checker for Gaps {
    fn opened(&mut self, channel: &Channel<'_>, context: &mut RuleContext<'_>) -> Interest {
        if !is_of_px4(channel, context) {
            return Interest::Nothing;
        }
        self.channels.open(channel, Rhythm::default());
        self.latest.open(channel, 0);
        Interest::Times
    }

    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>, context: &mut RuleContext<'_>) {
        let (Some(timestamp), Some(rhythm)) = (message.timestamp, self.channels.get(channel)) else {
            return;
        };
        if let Some(logged) = message.logged {
            let order = rhythm.order.get_or_insert_default();
            if !order.is_lost && logged < order.logged {
                order.is_lost = true;
                let definition = context.defined(channel.definition);
                let found = (order.found, &*order.examples);
                context.findings.remove(context.rule, channel.subject(), definition, found);
                *context.coverage -= order.checked;
            }
            order.logged = logged;
        }
        if rhythm.order.as_ref().is_some_and(|order| order.is_lost) {
            return;
        }
        self.now = self.now.max(timestamp);
        let period = rhythm.period;
        // After a step back, which PX-TIME-01 checks, the clock is unknown.
        let follow = |latest: &mut u64| {
            let next = if timestamp < *latest { 0 } else { timestamp };
            mem::replace(latest, next)
        };
        let latest = self.latest.get(channel).map_or(0, follow);
        let pause = timestamp.saturating_sub(latest);
        if latest > 0 && pause > 0 {
            rhythm.learn(pause);
        }
        let Some(period) = period else { return };
        if let Some(order) = &mut rhythm.order {
            order.checked += 1;
        }
        context.covered();
        if pause > period.saturating_mul(PAUSE) && latest > self.excused_until {
            if let Some(order) = &mut rhythm.order {
                order.found += 1;
                if order.examples.len() < MAX_EXAMPLES {
                    order.examples.push(message.location);
                }
            }
            let definition = context.defined(channel.definition);
            context.violation_of(channel.subject(), message.location, definition, || {
                let (pause, max) = (time_text(pause), time_text(period.saturating_mul(PAUSE)));
                let period = time_text(period);
                Detail::new(format!("no message for {pause}, but the period is {period}"))
                    .expected(format!("at most {max}, or a dropout record"))
                    .actual(pause)
            });
        }
    }

    fn corruption(&mut self, _: Location) {
        // The corrupt part may have contained messages.
        self.latest.reset();
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
            let median = *first.select_nth_unstable(LEARNING_PERIODS / 2).1;
            let is_similar = |pause: &&u64| (median / 2..=median.saturating_mul(2)).contains(*pause);
            self.period = Some(median).filter(|_| first.iter().filter(is_similar).count() >= REGULAR);
        }
    }
}

fn time_text(time: u64) -> String {
    match time {
        0..1_000 => format!("{time} µs"),
        1_000.. => format!("{} ms", time / 1_000),
    }
}

/// An hour, in µs: longer than any test flight.
const HOUR: u64 = 3_600_000_000;

/// Delays the last message of a topic.
fn pause<'d>(flight: &Flight<'d>) -> Option<Flight<'d>> {
    flight.with_last(flight.regular(|_| true)?, |message| message["timestamp"] = HOUR.into())
}
