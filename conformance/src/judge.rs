//! Judges a source: its records go to the plans of their formats and to the rules.

mod json;
mod log;
mod mcap;

use std::io::{self, Read};

use uavspec_codegen::schema::MessageId;

pub use self::json::{JsonSource, judge_json};
pub use self::log::{LogSource, judge_ulog};
pub use self::mcap::{Basis, McapChannel, McapSource, Standing, judge_mcap};
use crate::definitions::Definitions;
use crate::finding::Findings;
use crate::record::{Channel, Message, Place};
use crate::rule::{Check, Checker, Judged, RULES, Rule};
use crate::source::{MCAP_MAGIC, ULOG_MAGIC};

/// How many places of damage are kept.
const MAX_DAMAGE: usize = 100;

/// What a source is, and what came of it.
#[derive(Debug)]
pub struct Judgement {
    /// What it says of itself.
    pub source: Source,
    /// How many bytes it has, or were read.
    pub bytes: u64,
    /// From its first to its last timestamp, in µs.
    pub duration: u64,
    /// How many messages it has.
    pub records: u64,
    /// How many of them have a type, can be read as it, and were judged.
    pub judged: u64,
    /// What can't be read, and where; the first of it.
    pub damage: Vec<(Place, String)>,
    /// How much more of that there is.
    pub more_damage: u64,
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
}

/// Judges a source of any kind, which is seen by how it begins: a log of PX4, MCAP, or else JSON. Where `of` names
/// a message, the JSON is messages of that type and nothing around them.
///
/// An error is one of reading; what is wrong with the source itself is part of the judgement.
pub fn judge(
    mut input: impl Read,
    of: Option<MessageId>,
    definitions: &Definitions,
) -> io::Result<Judgement> {
    let mut start = Vec::new();
    input.by_ref().take(MCAP_MAGIC.len() as u64).read_to_end(&mut start)?;
    let (is_log, is_mcap) = (start.starts_with(&ULOG_MAGIC), start == MCAP_MAGIC);
    let whole = io::Cursor::new(start).chain(input);
    match (is_log, is_mcap) {
        (true, _) => judge_ulog(whole, definitions),
        (_, true) => judge_mcap(whole, definitions),
        _ => judge_json(whole, of, definitions),
    }
}

/// What all kinds of sources have in common: messages that come on channels, and the rules that follow them.
struct Course<'d> {
    definitions: &'d Definitions,
    findings: Findings,
    checkers: Vec<(&'static Rule, Box<dyn Checker>)>,
    channels: usize,
    records: u64,
    judged: u64,
    first: Option<u64>,
    last: u64,
    damage: Vec<(Place, String)>,
    more_damage: u64,
}

impl<'d> Course<'d> {
    fn new(definitions: &'d Definitions) -> Self {
        let checkers = RULES.iter().filter_map(|rule| match rule.check {
            Check::State(start) => Some((*rule, start())),
            Check::Value | Check::Source => None,
        });
        Self {
            definitions,
            findings: Findings::default(),
            checkers: checkers.collect(),
            channels: 0,
            records: 0,
            judged: 0,
            first: None,
            last: 0,
            damage: Vec::new(),
            more_damage: 0,
        }
    }

    /// A number for the next channel.
    fn number_channel(&mut self) -> usize {
        self.channels += 1;
        self.channels - 1
    }

    fn opened(&mut self, channel: &Channel<'_>) {
        for (rule, checker) in &mut self.checkers {
            let (definitions, findings) = (self.definitions, &mut self.findings);
            checker.opened(channel, &mut Judged { rule, definitions, findings });
        }
    }

    /// A message that was judged by itself.
    fn message(&mut self, channel: &Channel<'_>, message: &Message<'_>) {
        self.judged += 1;
        if let Some(timestamp) = message.timestamp.filter(|timestamp| *timestamp > 0) {
            self.first = Some(self.first.map_or(timestamp, |first| first.min(timestamp)));
            self.last = self.last.max(timestamp);
        }
        for (rule, checker) in &mut self.checkers {
            let (definitions, findings) = (self.definitions, &mut self.findings);
            checker.message(channel, message, &mut Judged { rule, definitions, findings });
        }
    }

    fn dropout(&mut self, milliseconds: u16, place: Place) {
        self.checkers.iter_mut().for_each(|(_, checker)| checker.dropout(milliseconds, place));
    }

    fn damage(&mut self, place: Place, text: String) {
        if self.damage.len() < MAX_DAMAGE {
            self.damage.push((place, text));
        } else {
            self.more_damage += 1;
        }
    }

    fn finish(mut self, bytes: u64, source: Source) -> Judgement {
        for (rule, checker) in &mut self.checkers {
            let (definitions, findings) = (self.definitions, &mut self.findings);
            checker.end(&mut Judged { rule, definitions, findings });
        }
        Judgement {
            source,
            bytes,
            duration: self.first.map_or(0, |first| self.last - first),
            records: self.records,
            judged: self.judged,
            damage: self.damage,
            more_damage: self.more_damage,
            findings: self.findings,
        }
    }
}
