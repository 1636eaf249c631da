//! A fast path for status reports without new findings. Nearly all status reports take this path.
//!
//! The fast path reads a line in one pass, without building a tree, and compares each value with its schema. Besides
//! these comparisons, only a few properties determine the findings in a report. Implausible values take the general path. These properties are the report's
//! version and, for each state, the present fields, the null fields, and the text of the error codes ([`Kind`]).
//!
//! When a state of a new kind appears, all message checks ([`Check::Message`](crate::rules::flockwave::Check)) run on a
//! report that contains only this state. The signature of these checks guarantees that nothing else affects them, so
//! the results apply to all states of that kind. A line takes the general path if its findings are still needed as
//! examples, or if they name a UAV for the first time. Later lines are only counted. The other checks still receive
//! each report as a [`StatusReport`](crate::rules::flockwave::StatusReport).
//!
//! Lines in an unusual form, and other messages, take the general path.

mod known;

use std::borrow::Cow;
use std::collections::HashSet;

use self::known::{Kind, Known};
use crate::definitions::Definitions;
use crate::flockwave::body_schema::Members;
use crate::json::{Token, Tokens, Tree, Unclear};
use crate::model::Findings;
use crate::rules::flockwave::plausible;
use uavspec_codegen::schema::json_type::Direction;

/// The type of the message.
const TYPE: &str = "UAV-INF";

/// The maximum length of a line on this path, in bytes. The limit ensures that no line exceeds the maximum number of
/// values in a tree.
const MAX_LINE: usize = 1 << 20;

/// The maximum length of a message id, in bytes. Lines with longer ids are rare, and take the general path.
const MAX_ID: usize = 36;

/// The maximum number of findings in a report on this path. The general path limits the number of findings in each
/// body.
const MAX_VIOLATIONS: u64 = 1_000;

/// The maximum number of fields in a state. Each field takes one bit.
const MAX_FIELDS: usize = 64;

/// A line with a status report that has no new findings.
#[derive(Debug)]
pub(super) struct Report<'l> {
    /// The name of the connection.
    pub(super) name: &'l str,
    /// The time, in seconds.
    pub(super) time: f64,
    /// The whole line.
    pub(super) text: &'l str,
    /// The message. The states in it contain only their timestamps.
    pub(super) message: Tree<'l>,
    /// The index of the report's version.
    version: usize,
}

/// Reads status reports.
pub(super) struct Reports<'d> {
    /// The fields of states; `None` if this path can't be used.
    fields: Option<Fields<'d>>,
    known: Known<'d>,
    /// The kind of each state in the latest report.
    kinds: Vec<usize>,
}

/// The fields of states.
struct Fields<'d> {
    members: Members<'d>,
    id: usize,
    timestamp: usize,
    errors: usize,
    /// For each field, the field that most recently followed it. The last item is the field that most recently came
    /// first in a state.
    next: Vec<usize>,
}

/// The members of a line.
#[derive(Default)]
struct Line<'l> {
    time: Option<f64>,
    name: Option<&'l str>,
    is_from_server: bool,
    message: Option<Message<'l>>,
}

/// The members of a message.
#[derive(Default)]
struct Message<'l> {
    version: Option<&'l str>,
    id: Option<&'l str>,
    body: Option<Body<'l>>,
}

/// The members of a body.
#[derive(Default)]
struct Body<'l> {
    is_report: bool,
    states: Option<States<'l>>,
}

/// The UAVs, each with its state reduced to the timestamp.
type States<'l> = Vec<(Cow<'l, str>, Tree<'l>)>;

impl<'d> Reports<'d> {
    /// Creates a reader for the status reports of these definitions.
    pub(super) fn new(definitions: &'d Definitions) -> Self {
        let members =
            definitions.defined_schemas().members(TYPE, Direction::Notification, "status", plausible);
        let fields = members.filter(|members| members.len() <= MAX_FIELDS).and_then(Fields::new);
        Self { fields, known: Known::new(definitions), kinds: Vec::new() }
    }

    /// Creates a reader that leaves all lines to the general path.
    pub(super) fn disabled(definitions: &'d Definitions) -> Self {
        Self { fields: None, known: Known::new(definitions), kinds: Vec::new() }
    }

    /// Reads a line, if it is a status report without new findings.
    pub(super) fn read<'l>(&mut self, bytes: &'l [u8], findings: &Findings) -> Option<Report<'l>> {
        if self.fields.is_none() || bytes.len() > MAX_LINE {
            return None;
        }
        let text = str::from_utf8(bytes).ok()?;
        let mut tokens = Tokens::new(text);
        let line = self.line(&mut tokens, findings).ok().filter(|_| tokens.end().is_ok())?;
        let message = line.message?;
        let body = message.body.filter(|body| body.is_report)?;
        let id = message.id.filter(|id| (1..=MAX_ID).contains(&id.len()))?;
        let states = body.states?;
        if !line.is_from_server || !are_different(&states) {
            return None;
        }
        let version = message.version?;
        let index = self.known.version(version, findings)?;
        let body =
            vec![(Cow::Borrowed("type"), Tree::Text(TYPE.into())), ("status".into(), Tree::Object(states))];
        let message = vec![
            (Cow::Borrowed("$fw.version"), Tree::Text(version.into())),
            ("id".into(), Tree::Text(id.into())),
            ("body".into(), Tree::Object(body)),
        ];
        let message = Tree::Object(message);
        Some(Report { name: line.name?, time: line.time?, text, message, version: index })
    }

    /// Counts the most recently read report.
    pub(super) fn count(&mut self, report: &Report<'_>) {
        self.known.count(report.version, &self.kinds);
    }

    /// The number of counted reports.
    #[cfg(test)]
    pub(super) fn seen(&self) -> u64 {
        self.known.seen()
    }

    /// Adds the results of all counted reports to the findings.
    pub(super) fn report_counted(&self, findings: &mut Findings) {
        self.known.report_counted(findings);
    }

    fn line<'l>(&mut self, tokens: &mut Tokens<'l>, findings: &Findings) -> Result<Line<'l>, Unclear> {
        let mut line = Line::default();
        tokens.members(|tokens, key| {
            match &*key {
                "t" if line.time.is_none() => line.time = Some(time(&tokens.token()?)?),
                "conn" if line.name.is_none() => line.name = Some(plain(tokens)?),
                "dir" if !line.is_from_server && plain(tokens)? == "in" => line.is_from_server = true,
                "msg" if line.message.is_none() => line.message = Some(self.message(tokens, findings)?),
                _ => return Err(Unclear),
            }
            Ok(())
        })?;
        Ok(line)
    }

    fn message<'l>(&mut self, tokens: &mut Tokens<'l>, findings: &Findings) -> Result<Message<'l>, Unclear> {
        let mut message = Message::default();
        tokens.members(|tokens, key| {
            match &*key {
                "$fw.version" if message.version.is_none() => message.version = Some(plain(tokens)?),
                "id" if message.id.is_none() => message.id = Some(plain(tokens)?),
                "body" if message.body.is_none() => message.body = Some(self.body(tokens, findings)?),
                _ => return Err(Unclear),
            }
            Ok(())
        })?;
        Ok(message)
    }

    fn body<'l>(&mut self, tokens: &mut Tokens<'l>, findings: &Findings) -> Result<Body<'l>, Unclear> {
        let mut body = Body::default();
        tokens.members(|tokens, key| {
            match &*key {
                "type" if !body.is_report && plain(tokens)? == TYPE => body.is_report = true,
                "status" if body.states.is_none() => body.states = Some(self.states(tokens, findings)?),
                _ => return Err(Unclear),
            }
            Ok(())
        })?;
        Ok(body)
    }

    fn states<'l>(&mut self, tokens: &mut Tokens<'l>, findings: &Findings) -> Result<States<'l>, Unclear> {
        // The previous report probably had about the same number of states.
        let mut states = Vec::with_capacity(self.kinds.len());
        self.kinds.clear();
        let fields = self.fields.as_mut().ok_or(Unclear)?;
        let mut num_violations = 0;
        tokens.members(|tokens, uav| {
            let Cow::Borrowed(uav) = uav else { return Err(Unclear) };
            let start = tokens.at();
            let (timestamp, kind) = fields.state(tokens, uav)?;
            let known = self.known.kind(kind, (uav, tokens.since(start)), findings);
            let (kind, count) = known.ok_or(Unclear)?;
            self.kinds.push(kind);
            num_violations += count;
            let members = vec![("timestamp".into(), Tree::Int(timestamp))];
            states.push((uav.into(), Tree::Object(members)));
            Ok(())
        })?;
        if num_violations <= MAX_VIOLATIONS { Ok(states) } else { Err(Unclear) }
    }
}

impl<'d> Fields<'d> {
    fn new(members: Members<'d>) -> Option<Self> {
        Some(Self {
            id: members.field("id")?,
            timestamp: members.field("timestamp")?,
            errors: members.field("errors")?,
            next: (0..=members.len()).map(|next| next % members.len()).collect(),
            members,
        })
    }

    /// Reads the timestamp and the kind of a UAV's state.
    fn state<'l>(&mut self, tokens: &mut Tokens<'l>, uav: &str) -> Result<(i128, Kind<'l>), Unclear> {
        let mut kind = Kind::default();
        let mut timestamp = None;
        let mut before = self.members.len();
        tokens.object(|tokens| {
            let field = self.field(tokens, before)?;
            let bit = 1 << field;
            if kind.fields & bit != 0 {
                return Err(Unclear);
            }
            kind.fields |= bit;
            before = field;
            let fits = if field == self.id {
                let id = plain(tokens)?;
                id == uav && self.members.accepts(field, &Token::Text(id.into()))
            } else if field == self.timestamp {
                let value = tokens.integer().ok_or(Unclear)?.into();
                timestamp = Some(value);
                self.members.accepts(field, &Token::Int(value))
            } else if tokens.takes_null() {
                kind.nulls |= bit;
                true
            } else if field == self.errors {
                kind.errors = tokens.flat_list().ok_or(Unclear)?;
                true
            } else {
                self.members.takes(field, tokens)?;
                true
            };
            if !fits {
                return Err(Unclear);
            }
            Ok(())
        })?;
        // States with and without an id are of different kinds.
        Ok((timestamp.ok_or(Unclear)?, kind))
    }

    /// Reads the key of the next field. The fields probably have the same order as in the previous state.
    fn field(&mut self, tokens: &mut Tokens<'_>, before: usize) -> Result<usize, Unclear> {
        let guess = self.next[before];
        if tokens.takes_key(self.members.name(guess)) {
            return Ok(guess);
        }
        let field = self.members.field(&tokens.key()?).ok_or(Unclear)?;
        self.next[before] = field;
        Ok(field)
    }
}

/// A string without escapes.
fn plain<'l>(tokens: &mut Tokens<'l>) -> Result<&'l str, Unclear> {
    tokens.plain_text().ok_or(Unclear)
}

/// A time in seconds.
fn time(token: &Token<'_>) -> Result<f64, Unclear> {
    match token {
        #[allow(clippy::cast_precision_loss)] // times in seconds are small enough
        Token::Int(value) => Ok(*value as f64),
        Token::Float(value, _) => Ok(*value),
        _ => Err(Unclear),
    }
}

/// True if no UAV appears twice. Most servers sort the states by UAV id.
fn are_different(states: &States<'_>) -> bool {
    let mut seen = HashSet::new();
    states.is_sorted_by(|(one, _), (other, _)| one < other) || states.iter().all(|(uav, _)| seen.insert(uav))
}
