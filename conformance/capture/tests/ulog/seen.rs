//! Owned copies of log items, for comparisons.

use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::io::Read;

use uavspec_capture::ulog::{Event, Item, Log, LogProblem, Problem, Reader};

/// An item of a reader, without borrowed data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Seen {
    pub(crate) offset: u64,
    /// A checksum of the event.
    pub(crate) digest: u64,
    /// The kind of the message, if the event is a message.
    pub(crate) kind: &'static str,
    pub(crate) problem: Option<Problem>,
}

impl Seen {
    fn new(item: &Item<'_>) -> Self {
        let mut hasher = DefaultHasher::new();
        let kind = match &item.event {
            Event::Data { id, payload } => {
                (id, payload).hash(&mut hasher);
                "data"
            }
            Event::Start { .. } => "start",
            Event::Problem(_) => "problem",
            other => {
                format!("{other:?}").hash(&mut hasher);
                "other"
            }
        };
        let problem = match &item.event {
            Event::Problem(problem) => Some(problem.clone()),
            _ => None,
        };
        Self { offset: item.offset, digest: hasher.finish(), kind, problem }
    }

    pub(crate) fn is_message(&self) -> bool {
        matches!(self.kind, "data" | "other")
    }
}

/// All items of a log. The items must follow each other without gaps.
pub(crate) fn read(bytes: &[u8]) -> Vec<Seen> {
    let seen = read_from(bytes);
    check_extents(bytes, &seen);
    seen
}

/// All items of a log.
pub(crate) fn read_from(input: impl Read) -> Vec<Seen> {
    let mut reader = Reader::new(input);
    let mut seen = Vec::new();
    while let Some(item) = reader.next().expect("an input without errors") {
        seen.push(Seen::new(&item));
    }
    assert_eq!(reader.next().expect("an end"), None, "nothing follows the end");
    seen
}

/// The problems that the reader and the log report, as texts with offsets, and the number of typed records.
pub(crate) fn problems(bytes: &[u8]) -> (Vec<String>, usize) {
    let (mut reader, mut log) = (Reader::new(bytes), Log::default());
    let (mut found, mut records) = (Vec::new(), 0);
    while let Some(item) = reader.next().expect("a slice") {
        if let Event::Problem(problem) = &item.event {
            found.push(format!("{}: {problem}", item.offset));
        }
        let mut report = |offset, problem: LogProblem| found.push(format!("{offset}: {problem}"));
        if let Some(record) = log.take(&item, &mut report) {
            record.message_type.view_uorb(record.payload).expect("data of the right size");
            records += 1;
        }
    }
    log.finish(&mut |offset, problem| found.push(format!("{offset}: {problem}")));
    (found, records)
}

/// Asserts that every byte after the header belongs to exactly one item, as documented.
fn check_extents(bytes: &[u8], seen: &[Seen]) {
    let size = bytes.len() as u64;
    let message_end = |offset: u64| {
        let at = usize::try_from(offset).expect("an offset");
        offset + 3 + u64::from(u16::from_le_bytes([bytes[at], bytes[at + 1]]))
    };
    let mut position = 0;
    let mut is_refused = false;
    for item in seen {
        let end = match (&item.problem, item.kind) {
            (None, "start") => 16,
            (None | Some(Problem::Malformed { .. }), _) => message_end(item.offset),
            (Some(Problem::Skipped { to, .. } | Problem::Straddles { appended: to }), _) => *to,
            (Some(Problem::EndsInHeader { .. } | Problem::EndsInPayload { .. }), _) => size,
            (Some(problem), _) => {
                is_refused |= matches!(
                    problem,
                    Problem::ForeignMagic(_) | Problem::ShortHeader { .. } | Problem::UnknownIncompatible(_)
                );
                assert!(item.offset <= position, "{item:?} is ahead of {position}");
                continue;
            }
        };
        assert_eq!(item.offset, position, "{item:?}");
        assert!(end <= size, "{item:?} goes beyond {size}");
        position = end;
    }
    assert!(is_refused || position == size, "read up to {position} of {size}");
}
