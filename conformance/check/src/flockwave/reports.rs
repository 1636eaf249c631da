//! A fast path for status reports without new findings. Nearly all status reports take this path.
//!
//! The fast path reads a line in one pass, without building a tree, and compares each value with its schema. Lines with
//! implausible values take the general path. Apart from these comparisons, only a few properties determine the findings
//! in a report: its version and, for each state, the present fields, the null fields, and the text of the error codes
//! ([`Kind`]).
//!
//! When a state of a new kind appears, all message checks ([`Check::Message`](uavspec_rules::flockwave::Check)) run on a
//! report that contains only this state. The signature of these checks guarantees that nothing else affects them, so
//! the results apply to all states of that kind. A line takes the general path if its findings are still needed as
//! examples, or if they name a UAV for the first time. Later lines are only counted. The other checks still receive
//! each report as a [`StatusReport`](uavspec_rules::flockwave::StatusReport).
//!
//! Lines in an unusual form, and other messages, take the general path.

mod cache;

use std::borrow::Cow;
use std::collections::HashSet;

use uavspec_flockwave::body_schema::Members;
use uavspec_model::Findings;
use uavspec_model::json::{Token, Tokens, Tree, Unclear};
use uavspec_rules::definitions::Definitions;
use uavspec_rules::flockwave::plausible;
use uavspec_schema::json_type::Direction;

use self::cache::{Kind, Known};

/// The maximum length of a line on this path, in bytes. The limit ensures that no line exceeds the maximum number of
/// values in a tree.
const MAX_LINE: usize = 1 << 20;

/// The maximum length of a message id, in bytes. Lines with longer ids are rare, and take the general path.
const MAX_ID: usize = 36;

/// The maximum number of fields in a state. Each field is represented by one bit.
const MAX_FIELDS: usize = 64;

/// The keys of a line, its message and its body.
const KEYS: [&str; 9] = ["t", "conn", "dir", "msg", "$fw.version", "id", "body", "type", "status"];

/// A line with a status report.
#[derive(Debug)]
pub(crate) struct Report<'l> {
    /// The name of the connection.
    pub(super) name: &'l str,
    /// The time, in seconds.
    pub(super) time: f64,
    /// The whole line.
    pub(super) text: &'l str,
    /// The `id` of the message.
    pub(crate) id: &'l str,
    /// The ids of the UAVs, and the timestamps of their states.
    pub(crate) timestamps: Vec<(&'l str, Tree<'l>)>,
    version: &'l str,
}

/// Reads status reports.
pub(super) struct Reports<'d> {
    /// The reader for states. `None` if the fast path can't be used.
    states: Option<States<'d>>,
}

/// Reads the states in a report.
struct States<'d> {
    members: Members<'d>,
    id: usize,
    timestamp: usize,
    errors: usize,
    known: Known<'d>,
    /// The kind of each state in the latest report.
    kinds: Vec<usize>,
}

/// The values of a line.
#[derive(Default)]
struct Line<'l> {
    time: Option<f64>,
    name: Option<&'l str>,
    version: Option<&'l str>,
    id: Option<&'l str>,
    timestamps: Option<Vec<(&'l str, Tree<'l>)>>,
    /// One bit for each of [`KEYS`] that was read.
    keys: u16,
}

impl Report<'_> {
    /// The type of the message.
    pub(crate) const TYPE: &'static str = "UAV-INF";

    /// The number of values in the body: `type` and `status`.
    pub(super) const NUM_VALUES: u64 = 2;
}

impl<'d> Reports<'d> {
    /// Creates a reader for the status reports of these definitions.
    pub(super) fn new(definitions: &'d Definitions) -> Self {
        let members =
            definitions.defined_schemas().members(Report::TYPE, Direction::Notification, "status", plausible);
        let members = members.filter(|members| members.num_fields() <= MAX_FIELDS);
        let states = members.and_then(|members| States::new(members, Known::new(definitions)));
        Self { states }
    }

    /// Creates a reader that leaves all lines to the general path.
    pub(super) fn disabled() -> Self {
        Self { states: None }
    }

    /// Reads a line, if it is a status report whose findings may be known.
    pub(super) fn read<'l>(&mut self, bytes: &'l [u8]) -> Option<Report<'l>> {
        let states = self.states.as_mut().filter(|_| bytes.len() <= MAX_LINE)?;
        let text = str::from_utf8(bytes).ok()?;
        let line = Line::read(text, states).ok()?;
        let (id, timestamps) = (line.id?, line.timestamps?);
        let is_usual = (1..=MAX_ID).contains(&id.len()) && are_different(&timestamps);
        let report =
            Report { name: line.name?, time: line.time?, text, id, timestamps, version: line.version? };
        is_usual.then_some(report)
    }

    /// Counts the most recently read report, and returns true, unless it has new findings. If this returns false, the
    /// report must take the general path, which reports the findings.
    pub(super) fn count(&mut self, report: &Report<'_>, findings: &Findings) -> bool {
        let Some(States { kinds, known, .. }) = &mut self.states else { return false };
        let uavs = report.timestamps.iter().map(|(uav, _)| *uav);
        known.count(report.version, kinds.iter().copied().zip(uavs), findings).is_some()
    }

    /// The number of counted reports.
    pub(super) fn seen(&self) -> u64 {
        self.states.as_ref().map_or(0, |states| states.known.seen())
    }

    /// Adds the results of all counted reports to the findings.
    pub(super) fn report_counted(&self, findings: &mut Findings) {
        if let Some(states) = &self.states {
            states.known.report_counted(findings);
        }
    }
}

impl<'l> Line<'l> {
    /// Marks a known key as read. Fails if the key is repeated, because other readers may use the other value.
    fn add_key(&mut self, key: &str) -> Result<(), Unclear> {
        let bit = 1 << KEYS.iter().position(|known| *known == key).ok_or(Unclear)?;
        if self.keys & bit != 0 {
            return Err(Unclear);
        }
        self.keys |= bit;
        Ok(())
    }

    /// Reads a line. Fails unless it has exactly the [`KEYS`], because other checks examine other members.
    fn read(text: &'l str, states: &mut States<'_>) -> Result<Self, Unclear> {
        let mut line = Self::default();
        let mut tokens = Tokens::new(text);
        tokens.members(|tokens, key| {
            line.add_key(&key)?;
            match &*key {
                "t" => line.time = Some(time(&tokens.token()?)?),
                "conn" => line.name = Some(plain(tokens)?),
                "dir" => expect(tokens, "in")?,
                "msg" => tokens.members(|tokens, key| line.member(&key, tokens, states))?,
                _ => return Err(Unclear),
            }
            Ok(())
        })?;
        tokens.end()?;
        if line.keys.count_ones() as usize == KEYS.len() { Ok(line) } else { Err(Unclear) }
    }

    /// Reads a member of the message.
    fn member(&mut self, key: &str, tokens: &mut Tokens<'l>, states: &mut States<'_>) -> Result<(), Unclear> {
        self.add_key(key)?;
        match key {
            "$fw.version" => self.version = Some(plain(tokens)?),
            "id" => self.id = Some(plain(tokens)?),
            "body" => tokens.members(|tokens, key| {
                self.add_key(&key)?;
                match &*key {
                    "type" => expect(tokens, Report::TYPE)?,
                    "status" => self.timestamps = Some(states.read(tokens)?),
                    _ => return Err(Unclear),
                }
                Ok(())
            })?,
            _ => return Err(Unclear),
        }
        Ok(())
    }
}

impl<'d> States<'d> {
    fn new(members: Members<'d>, known: Known<'d>) -> Option<Self> {
        Some(Self {
            id: members.field("id", None)?,
            timestamp: members.field("timestamp", None)?,
            errors: members.field("errors", None)?,
            members,
            known,
            kinds: Vec::new(),
        })
    }

    /// Reads the states in a report. Returns the ids of the UAVs, and the timestamps of their states.
    fn read<'l>(&mut self, tokens: &mut Tokens<'l>) -> Result<Vec<(&'l str, Tree<'l>)>, Unclear> {
        // The previous report probably had about the same number of states.
        let mut timestamps = Vec::with_capacity(self.kinds.len());
        self.kinds.clear();
        tokens.members(|tokens, uav| {
            let Cow::Borrowed(uav) = uav else { return Err(Unclear) };
            let (timestamp, kind) = self.state(tokens, uav)?;
            self.kinds.push(kind);
            timestamps.push((uav, Tree::Int(timestamp.into())));
            Ok(())
        })?;
        Ok(timestamps)
    }

    /// Reads the state of a UAV. Returns the timestamp and the kind.
    fn state(&mut self, tokens: &mut Tokens<'_>, uav: &str) -> Result<(i64, usize), Unclear> {
        let start = tokens.at();
        let mut kind = Kind::default();
        let (mut timestamp, mut previous) = (None, None);
        tokens.object(|tokens| {
            let field = self.members.field(&tokens.key()?, previous).ok_or(Unclear)?;
            previous = Some(field);
            let bit = 1 << field;
            if kind.fields & bit != 0 {
                return Err(Unclear);
            }
            kind.fields |= bit;
            let fits = if field == self.id {
                let id = plain(tokens)?;
                id == uav && self.members.accepts_text(field, id)
            } else if field == self.timestamp {
                let value = tokens.integer().ok_or(Unclear)?;
                timestamp = Some(value);
                self.members.accepts(field, &Token::Int(value.into()))
            } else if tokens.takes_null() {
                kind.nulls |= bit;
                true
            } else if field == self.errors {
                kind.errors = tokens.flat_list().ok_or(Unclear)?;
                // Some findings about other values concern the whole message, not each state.
                let is_usual = |byte| matches!(byte, b'[' | b']' | b',' | b' ' | b'0'..=b'9');
                kind.errors.bytes().all(is_usual)
            } else {
                self.members.takes(field, tokens)?;
                true
            };
            if fits { Ok(()) } else { Err(Unclear) }
        })?;
        let timestamp = timestamp.ok_or(Unclear)?;
        let state = tokens.since(start);
        let kind = self.known.kind(kind, (uav, state)).ok_or(Unclear)?;
        Ok((timestamp, kind))
    }
}

/// Reads a string without escapes.
fn plain<'l>(tokens: &mut Tokens<'l>) -> Result<&'l str, Unclear> {
    tokens.plain_text().ok_or(Unclear)
}

/// Reads a string, if it is this text.
fn expect(tokens: &mut Tokens<'_>, text: &str) -> Result<(), Unclear> {
    if plain(tokens)? == text { Ok(()) } else { Err(Unclear) }
}

/// Reads a time in seconds.
fn time(token: &Token<'_>) -> Result<f64, Unclear> {
    match token {
        #[allow(clippy::cast_precision_loss)] // times in seconds are small enough
        Token::Int(value) => Ok(*value as f64),
        Token::Float(value, _) => Ok(*value),
        _ => Err(Unclear),
    }
}

/// True if no UAV appears twice. Fast for most servers, which sort the states by UAV id.
fn are_different(timestamps: &[(&str, Tree<'_>)]) -> bool {
    let mut seen = HashSet::new();
    timestamps.is_sorted_by(|(one, _), (other, _)| one < other)
        || timestamps.iter().all(|(uav, _)| seen.insert(uav))
}
