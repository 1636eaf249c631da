//! Judges a source: its records go to the plans of their formats and to the rules.

mod flockwave;
mod json;
pub mod known;
mod log;
mod mcap;
pub mod parallel;
mod topic;

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::io::{self, Read};

use uavspec_codegen::dynamic::{MessageType, Placed, PlacedElement};
use uavspec_codegen::schema::{MessageId, Shape};
use uavspec_codegen::source::Span;
use uavspec_runtime::Scalar;

pub use self::flockwave::{FlockwaveJudge, FlockwaveSource, TypeCount};
pub use self::json::{JsonSource, judge_json, judge_json_thoroughly};
pub use self::log::{LogSource, judge_ulog};
pub use self::mcap::{Basis, McapChannel, McapSource, Standing, judge_mcap};
use crate::capture::{ENCRYPTED_MAGIC, MCAP_MAGIC, ULOG_MAGIC};
use crate::definitions::Definitions;
use crate::flockwave::record::{Connection, Direction, Exchange};
use crate::flockwave::session::{Conversations, Turn};
use crate::model::{Channel, Extent, Findings, Message, Place, Rule};
use crate::rules::flockwave::EachExchange;
use crate::rules::px4::Interest;
use crate::rules::{Judged, flockwave as session_rules, px4};
use crate::text::Grouped;

/// What is said of an encrypted log.
const ENCRYPTED: &str = "an encrypted log of PX4 (.ulge): decrypt it first, with its key, as \
    https://docs.px4.io/main/en/dev_log/log_encryption tells";

/// So many bytes of a magic tell what a source is that ends there.
const MIN_MAGIC: usize = 4;

/// How many kinds of damage are kept.
const MAX_DAMAGE: usize = 100;

/// What a source is, and what came of it.
#[derive(Debug)]
pub struct Judgement {
    /// What it says of itself.
    pub source: Source,
    /// How many bytes were read.
    pub bytes: u64,
    /// From its first to its last timestamp, in µs.
    pub duration: u64,
    /// How many messages it has.
    pub records: u64,
    /// How many of them have a type, can be read as it, and were judged.
    pub judged: u64,
    /// What can't be read, and where first, in that order.
    pub damage: Vec<(Place, String)>,
    /// How much more of that there is.
    pub more_damage: u64,
    /// How much of it could be read.
    pub extent: Extent,
    /// What breaks rules.
    pub findings: Findings,
}

/// What kinds of sources say of themselves.
#[derive(Debug)]
pub enum Source {
    /// A log of PX4.
    Log(LogSource),
    /// Messages as JSON.
    Json(JsonSource),
    /// A file of MCAP.
    Mcap(McapSource),
    /// Recorded conversations of Flockwave.
    Flockwave(FlockwaveSource),
}

/// Judges a source of any kind, which is seen by how it begins: a log of PX4, MCAP, or else JSON
/// (recorded conversations of Flockwave among it). Where `of` names
/// a message, the JSON is messages of that type and nothing around them.
///
/// An error is one of reading its first bytes, or says that the source is encrypted, or nothing that can be judged. What
/// is wrong with it later on, and that it can't be read any further, is part of the judgement.
pub fn judge(
    mut input: impl Read,
    of: Option<MessageId>,
    definitions: &Definitions,
) -> io::Result<Judgement> {
    let mut start = Vec::new();
    input.by_ref().take(MCAP_MAGIC.len() as u64).read_to_end(&mut start)?;
    if start.starts_with(&ENCRYPTED_MAGIC) {
        return Err(io::Error::new(io::ErrorKind::Unsupported, ENCRYPTED));
    }
    let (is_log, is_mcap) = (is_begun(&start, &ULOG_MAGIC), is_begun(&start, &MCAP_MAGIC));
    if !is_log && !is_mcap && is_binary(&start) {
        let bytes: Vec<String> = start.iter().map(|byte| format!("{byte:02x}")).collect();
        let text = format!("byte 0: no ULog, no MCAP and no JSON: it begins with {}", bytes.join(" "));
        return Err(io::Error::new(io::ErrorKind::InvalidData, text));
    }
    let whole = io::Cursor::new(start).chain(input);
    Ok(match (is_log, is_mcap) {
        (true, _) => judge_ulog(whole, definitions),
        (_, true) => judge_mcap(whole, definitions),
        _ => judge_json(whole, of, definitions),
    })
}

/// Whether a source begins with a magic, or ends within it so late that it can hardly be anything else.
fn is_begun(start: &[u8], magic: &[u8]) -> bool {
    start.starts_with(magic) || start.len() >= MIN_MAGIC && magic.starts_with(start)
}

/// Whether a source begins neither as JSON nor as any text does. One byte that is wrong may be damage.
fn is_binary(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    if text.trim_start_matches('\u{feff}').trim_start().starts_with(['{', '[']) {
        return false;
    }
    let is_foreign = |character: &char| {
        *character == char::REPLACEMENT_CHARACTER || character.is_control() && !character.is_whitespace()
    };
    text.chars().filter(is_foreign).count() > 1
}

/// What all kinds of sources have in common: messages that come on channels, and the rules that follow them.
struct Course<'d> {
    definitions: &'d Definitions,
    findings: Findings,
    /// The rules on messages.
    followers: Vec<Follower<dyn px4::Checker>>,
    /// The rules on sessions.
    listeners: Vec<Follower<dyn session_rules::Checker>>,
    /// Indices of the listeners that don't judge reports on UAVs by what these say alone.
    around: Vec<usize>,
    /// By the index of a channel.
    channels: Vec<Followed>,
    conversations: Conversations,
    records: u64,
    judged: u64,
    first: Option<u64>,
    last: u64,
    /// By what is told, which is told once.
    damage: HashMap<String, Told>,
    more_damage: u64,
    extent: Extent,
}

/// Damage: where it was first, and how often it was.
struct Told {
    number: usize,
    place: Place,
    times: u64,
}

/// A rule that follows the records.
struct Follower<C: ?Sized> {
    rule: &'static Rule,
    checker: Box<C>,
    exercised: u64,
}

/// Who follows a channel.
#[derive(Default)]
struct Followed {
    /// Indices of the followers that want its messages.
    by: Vec<usize>,
    /// What most of them want to know.
    interest: Interest,
}

impl<C: ?Sized> Follower<C> {
    fn judge<T>(
        &mut self,
        definitions: &Definitions,
        findings: &mut Findings,
        what: impl FnOnce(&mut C, &mut Judged<'_>) -> T,
    ) -> T {
        let Self { rule, checker, exercised } = self;
        what(&mut **checker, &mut Judged { rule, definitions, findings, exercised })
    }
}

impl<'d> Course<'d> {
    fn new(definitions: &'d Definitions) -> Self {
        let followers = px4::RULES.iter().filter_map(|rule| match rule.check {
            px4::Check::State(start) => Some(Follower { rule: &rule.rule, checker: start(), exercised: 0 }),
            px4::Check::Value | px4::Check::Source => None,
        });
        let listeners = session_rules::RULES.iter().map(|rule| {
            let checker: Box<dyn session_rules::Checker> = match rule.check {
                session_rules::Check::State(start) => start(),
                session_rules::Check::Exchange(judge) | session_rules::Check::Context(judge) => {
                    Box::new(EachExchange(judge))
                }
            };
            Follower { rule: &rule.rule, checker, exercised: 0 }
        });
        let looks_around =
            |rule: &session_rules::FlockwaveRule| !matches!(rule.check, session_rules::Check::Exchange(_));
        let around =
            (0..session_rules::RULES.len()).filter(|at| looks_around(session_rules::RULES[*at])).collect();
        Self {
            definitions,
            findings: Findings::default(),
            followers: followers.collect(),
            listeners: listeners.collect(),
            around,
            channels: Vec::new(),
            conversations: Conversations::default(),
            records: 0,
            judged: 0,
            first: None,
            last: 0,
            damage: HashMap::new(),
            more_damage: 0,
            extent: Extent::Whole,
        }
    }

    /// A number for the next channel.
    fn number_channel(&mut self) -> usize {
        self.channels.push(Followed::default());
        self.channels.len() - 1
    }

    fn opened(&mut self, channel: &Channel<'_>) {
        let mut followed = Followed::default();
        for (at, follower) in self.followers.iter_mut().enumerate() {
            let opened = |checker: &mut (dyn px4::Checker + 'static), judged: &mut Judged<'_>| {
                checker.opened(channel, judged)
            };
            let interest = follower.judge(self.definitions, &mut self.findings, opened);
            if interest > Interest::Nothing {
                followed.by.push(at);
                followed.interest = followed.interest.max(interest);
            }
        }
        self.channels[channel.index] = followed;
    }

    fn closed(&mut self, channel: &Channel<'_>) {
        self.followers.iter_mut().for_each(|follower| follower.checker.closed(channel));
    }

    /// When the source was begun, in µs since system start.
    fn started(&mut self, time: u64) {
        self.followers.iter_mut().for_each(|follower| follower.checker.started(time));
    }

    /// Whether a rule wants to know what the messages of a channel say.
    fn wants_values(&self, channel: usize) -> bool {
        self.channels[channel].interest == Interest::Values
    }

    /// A message that was judged by itself.
    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>) {
        self.judged += 1;
        self.pass(message.timestamp);
        for at in &self.channels[channel.index].by {
            let message = |checker: &mut (dyn px4::Checker + 'static), judged: &mut Judged<'_>| {
                checker.message(channel, message, judged);
            };
            self.followers[*at].judge(self.definitions, &mut self.findings, message);
        }
    }

    /// A time in µs, which is between the first and the last.
    fn pass(&mut self, timestamp: Option<u64>) {
        if let Some(timestamp) = timestamp.filter(|timestamp| *timestamp > 0) {
            self.first = Some(self.first.map_or(timestamp, |first| first.min(timestamp)));
            self.last = self.last.max(timestamp);
        }
    }

    /// A time in seconds.
    fn pass_time(&mut self, time: Option<f64>) {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // it saturates
        self.pass(time.map(|time| (time * 1e6) as u64));
    }

    /// Something goes over a connection, or happens to it.
    fn exchanged(&mut self, exchange: &Exchange<'_>) {
        let turn = self.conversations.follow(exchange, self.definitions);
        self.tell(&turn);
    }

    /// The same, of a report on UAVs that rules have judged already which go by what it says alone.
    fn reported(&mut self, exchange: &Exchange<'_>) {
        let turn = self.conversations.follow_told(exchange);
        for at in &self.around {
            self.listeners[*at].judge(self.definitions, &mut self.findings, |checker, judged| {
                checker.exchanged(&turn, judged);
            });
        }
    }

    /// A connection, or all that is known of it, comes to its end, and perhaps it is known why.
    fn disconnected(&mut self, connection: Connection<'_>, why: Option<&str>) {
        let (serial, unanswered) = self.conversations.ended(connection.index);
        for asked in unanswered {
            let exchange = Exchange {
                connection,
                direction: Direction::Event,
                time: None,
                text: "",
                value: None,
                trial: None,
                note: why,
                place: asked.place,
            };
            self.tell(&Turn::unanswered(&exchange, serial, asked));
        }
    }

    fn tell(&mut self, turn: &Turn<'_>) {
        for follower in &mut self.listeners {
            follower.judge(self.definitions, &mut self.findings, |checker, judged| {
                checker.exchanged(turn, judged);
            });
        }
    }

    fn dropout(&mut self, milliseconds: u16, place: Place) {
        self.followers.iter_mut().for_each(|follower| follower.checker.dropout(milliseconds, place));
    }

    /// A message of a channel can't be read: who follows that doesn't know all that was said.
    fn lost(&mut self, channel: usize, place: Place) {
        for at in &self.channels[channel].by {
            self.followers[*at].checker.damage(place);
        }
    }

    /// The same, where nobody knows of which channel it is.
    fn lost_any(&mut self, place: Place) {
        self.followers.iter_mut().for_each(|follower| follower.checker.damage(place));
        self.listeners.iter_mut().for_each(|listener| listener.checker.damage(place));
    }

    /// Where the definition of a topic is, if it has one.
    fn definition_of(&self, topic: &str) -> Option<Span> {
        let id = self.definitions.message_of_topic(topic)?;
        Some(self.definitions.schema.message(id).span)
    }

    /// Something that can't be read, and is passed over.
    fn gap(&mut self, place: Place, text: String) {
        self.damage(place, text, Extent::WithGaps);
    }

    /// Something is wrong with the source, of which so much can be read.
    fn damage(&mut self, place: Place, text: String, extent: Extent) {
        self.extent = self.extent.max(extent);
        self.lost_any(place);
        self.conversations.lose();
        let number = self.damage.len();
        match self.damage.entry(text) {
            Entry::Occupied(mut known) => known.get_mut().times += 1,
            // Why nothing follows is told, however much goes before.
            Entry::Vacant(new) if number < MAX_DAMAGE || extent == Extent::BrokenOff => {
                _ = new.insert(Told { number, place, times: 1 });
            }
            Entry::Vacant(_) => self.more_damage += 1,
        }
    }

    /// The source can't be read any further.
    fn unreadable(&mut self, place: Place, error: &io::Error) {
        self.damage(place, format!("what follows can't be read: {error}"), Extent::BrokenOff);
    }

    fn finish(mut self, bytes: u64, source: Source) -> Judgement {
        for follower in &mut self.followers {
            follower.judge(self.definitions, &mut self.findings, |checker, judged| checker.end(judged));
            self.findings.exercise(follower.rule, follower.exercised);
        }
        for listener in &mut self.listeners {
            listener.judge(self.definitions, &mut self.findings, |checker, judged| checker.end(judged));
            self.findings.exercise(listener.rule, listener.exercised);
        }
        let mut damage: Vec<(String, Told)> = self.damage.into_iter().collect();
        damage.sort_by_key(|(_, told)| told.number);
        let told = |(text, told): (String, Told)| match told.times {
            1 => (told.place, text),
            times => (told.place, format!("{text} ({} times)", Grouped(times))),
        };
        Judgement {
            source,
            bytes,
            duration: self.first.map_or(0, |first| self.last - first),
            records: self.records,
            judged: self.judged,
            damage: damage.into_iter().map(told).collect(),
            more_damage: self.more_damage,
            extent: self.extent,
            findings: self.findings,
        }
    }
}

/// Where in memory messages of a type have their `timestamp`.
fn timestamp_offset(of: MessageType<'_>) -> Option<usize> {
    let is_timestamp = |field: &Placed<'_>| {
        field.name == "timestamp"
            && matches!(field.element, PlacedElement::Scalar(Scalar::UInt64))
            && field.shape == Shape::Single
    };
    of.layout().find(is_timestamp).map(|field| field.offset)
}
