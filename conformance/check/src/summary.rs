//! The summary of a capture, in a form that all reports can print.

use uavspec_model::text::{plural, shown, thousands};

/// The maximum number of names that a line lists.
pub const MAX_LISTED: usize = 8;

/// The parts of a summary that human-readable reports print. All text is safe to print on one line.
pub trait Describe {
    /// The facts on the first line, in order.
    fn facts(&self, totals: Totals) -> Vec<String>;

    /// The lines below the first line.
    fn lines(&self) -> Vec<Line>;

    /// The noun for a capture of this kind.
    fn noun(&self) -> &'static str {
        "file"
    }

    /// True if the capture is a session. Different rules apply to sessions than to PX4 messages.
    fn is_session(&self) -> bool {
        false
    }
}

/// The counts that all captures have.
#[derive(Clone, Copy, Debug)]
pub struct Totals {
    /// The number of messages.
    pub records: u64,
    /// The time from the first to the last timestamp, in µs.
    pub duration_us: u64,
}

/// A line of a summary.
#[derive(Clone, Debug)]
pub struct Line {
    /// A short description of the content.
    pub label: &'static str,
    /// The content in brief.
    pub text: String,
    /// The lists that belong to the line.
    pub lists: Vec<List>,
    /// The full content, for reports with enough space; empty if `text` is complete.
    pub details: Vec<String>,
}

/// A list that belongs to a line.
#[derive(Clone, Debug)]
pub struct List {
    /// A short description of each item.
    pub label: &'static str,
    /// The items.
    pub items: Vec<String>,
}

impl Totals {
    /// The duration, with units.
    pub(crate) fn duration(self) -> String {
        let seconds = self.duration_us / 1_000_000;
        match (seconds / 3600, seconds / 60 % 60, seconds % 60) {
            (0, 0, seconds) => format!("{seconds} s"),
            (0, minutes, seconds) => format!("{minutes} min {seconds} s"),
            (hours, minutes, _) => format!("{} h {minutes} min", thousands(hours)),
        }
    }

    /// The number of messages, followed by the noun.
    pub(crate) fn messages(self) -> String {
        plural(self.records, "message")
    }
}

impl Line {
    /// A line without lists.
    pub fn new(label: &'static str, text: impl Into<String>) -> Self {
        Self { label, text: text.into(), lists: Vec::new(), details: Vec::new() }
    }

    /// Adds a list. Each item consists of a subject and its description.
    #[must_use]
    pub fn list<'i>(
        mut self,
        label: &'static str,
        items: impl IntoIterator<Item = (&'i str, String)>,
    ) -> Self {
        let item = |(subject, text): (&str, String)| format!("{}: {text}", shown(subject));
        self.lists.push(List { label, items: items.into_iter().map(item).collect() });
        self
    }
}

/// The first names, and the number of the remaining names.
pub fn names<'n>(names: impl ExactSizeIterator<Item = &'n str>) -> String {
    let more = names.len().saturating_sub(MAX_LISTED);
    let first: Vec<String> = names.take(MAX_LISTED).map(shown).collect();
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{}{more}", first.join(", "))
}
