//! The report of a conversion.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fmt::Write as _;
use std::io;
use std::path::Path;

use serde::Serialize;
use uavspec_model::text::{plural, shown, thousands};
use uavspec_schema::json_text;

use super::Format;
use super::plan::Plan;

/// The version of the JSON form.
const VERSION: u32 = 1;

/// The maximum number of problems to list.
const MAX_PROBLEMS: usize = 100;

/// The result of a conversion.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
pub struct ConversionReport {
    /// The version of this format.
    pub version: u32,
    /// The version of the program.
    pub uavspec: String,
    /// The path of the capture.
    pub capture: String,
    /// The releases that the capture agrees with, such as `px4@1.18`, or the path of its definitions.
    pub from: Vec<String>,
    /// The target: a release, or the path of definitions. `None` if the messages keep their types.
    pub to: Option<String>,
    /// The format of the capture.
    pub from_format: Format,
    /// The format of the output.
    pub to_format: Format,
    /// The topics, by name.
    pub topics: Vec<TopicReport>,
    /// The parts of the capture that can't be read.
    pub problems: Vec<String>,
    /// The number of problems that aren't listed.
    pub more_problems: u64,
    /// Notes on the output.
    pub notes: Vec<String>,
}

/// A topic of the capture.
#[derive(Clone, Debug, Default, Serialize, schemars::JsonSchema)]
pub struct TopicReport {
    /// The name in the capture.
    pub topic: String,
    /// The name in the output, if it differs.
    pub renamed: Option<String>,
    /// The treatment of the messages.
    pub action: Action,
    /// The release of the source message. `None` if a schema of the capture defines it.
    pub from: Option<String>,
    /// The reason why messages are left out or copied unchanged.
    pub reason: Option<String>,
    /// The number of messages.
    pub messages: u64,
    /// The number of unreadable messages, which are left out.
    pub unreadable: u64,
    /// The error of the first unreadable message.
    pub error: Option<String>,
    /// The data that the conversion loses.
    pub losses: Vec<Loss>,
    /// The fields that may have a value that the target's definition excludes.
    pub unchecked: Vec<String>,
}

/// The treatment of a topic.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Action {
    /// The messages have a definition of the target, or of the release that they agree with.
    Converted,
    /// The messages keep their fields.
    Copied,
    /// The messages aren't in the output.
    #[default]
    LeftOut,
}

impl Action {
    fn text(self) -> &'static str {
        match self {
            Self::Converted => "converted",
            Self::Copied => "copied",
            Self::LeftOut => "left out",
        }
    }
}

/// Data that the conversion of a topic loses.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
pub struct Loss {
    /// The loss, in the words of the conversion.
    pub text: String,
    /// The number of messages that contain the data; `None` if it isn't counted.
    pub messages: Option<u64>,
}

/// The problems in a capture, and notes on the output.
#[derive(Clone, Debug, Default)]
pub(super) struct Problems {
    listed: Vec<String>,
    more: u64,
    notes: Vec<String>,
}

impl Problems {
    pub(super) fn add(&mut self, problem: String) {
        if self.listed.len() < MAX_PROBLEMS {
            self.listed.push(problem);
        } else {
            self.more += 1;
        }
    }

    /// Adds the error that ended the reading, if there is one.
    pub(super) fn add_unreadable_rest(&mut self, byte: u64, error: Option<&io::Error>) {
        if let Some(error) = error {
            self.add(format!("byte {byte}: the rest is unreadable: {error}"));
        }
    }

    /// Adds the problems and notes of another part.
    pub(super) fn merge(&mut self, other: Self) {
        other.listed.into_iter().for_each(|problem| self.add(problem));
        self.more += other.more;
        for note in other.notes {
            if !self.notes.contains(&note) {
                self.notes.push(note);
            }
        }
    }

    /// The problems of a file of a bag.
    pub(super) fn of_file(mut self, file: &str) -> Self {
        self.listed.iter_mut().for_each(|problem| problem.insert_str(0, &format!("{file}: ")));
        self
    }

    pub(super) fn note(&mut self, note: &str) {
        self.notes.push(note.to_owned());
    }
}

impl ConversionReport {
    pub(super) fn new(
        path: &Path,
        plan: &Plan,
        formats: (Format, Format),
        mut topics: Vec<TopicReport>,
        problems: Problems,
    ) -> Self {
        topics.sort_by(|left, right| (left.action, &left.topic).cmp(&(right.action, &right.topic)));
        Self {
            version: VERSION,
            uavspec: env!("CARGO_PKG_VERSION").to_owned(),
            capture: path.to_string_lossy().into_owned(),
            from: plan.sources(),
            to: plan.target_label().map(str::to_owned),
            from_format: formats.0,
            to_format: formats.1,
            topics,
            problems: problems.listed,
            more_problems: problems.more,
            notes: problems.notes,
        }
    }

    /// True if all data in the capture could be read.
    pub fn is_complete(&self) -> bool {
        self.problems.is_empty() && self.topics.iter().all(|topic| topic.unreadable == 0)
    }

    /// The number of topics with this action.
    pub fn count(&self, action: Action) -> usize {
        self.topics.iter().filter(|topic| topic.action == action).count()
    }

    /// The report in JSON.
    pub fn to_json(&self) -> String {
        json_text::pretty(self)
    }

    /// The report for people.
    pub fn to_text(&self) -> String {
        let mut parts = Vec::new();
        let from = shown(&self.from.join(", "));
        match &self.to {
            Some(to) if from.is_empty() => {
                let is_converted = self.count(Action::Converted) > 0;
                let from = if is_converted { "its own definitions" } else { "no known release" };
                parts.push(format!("{from} to {}", shown(to)));
            }
            Some(to) => parts.push(format!("{from} to {}", shown(to))),
            None if from.is_empty() => {}
            None => parts.push(from),
        }
        if self.from_format != self.to_format {
            parts.push(format!("{} to {}", self.from_format.name(), self.to_format.name()));
        }
        let mut text = format!("{}: {}\n", shown(&self.capture), parts.join(", "));
        for topic in &self.topics {
            topic.write(&mut text);
        }
        for problem in &self.problems {
            let _ = writeln!(text, "  problem    {}", shown(problem));
        }
        if self.more_problems > 0 {
            let _ = writeln!(text, "  problem    {} more", thousands(self.more_problems));
        }
        for note in &self.notes {
            let _ = writeln!(text, "  note       {}", shown(note));
        }
        let [converted, copied, left_out] =
            [Action::Converted, Action::Copied, Action::LeftOut].map(|action| self.count(action));
        let _ = writeln!(
            text,
            "{} converted, {copied} copied unchanged, {left_out} left out",
            plural(converted, "topic")
        );
        text
    }
}

/// Combines the topics of several files: topics with the same name and the same treatment.
pub(super) fn merged(topics: Vec<TopicReport>) -> Vec<TopicReport> {
    let mut all: BTreeMap<_, TopicReport> = BTreeMap::new();
    for topic in topics {
        let TopicReport { action, renamed, from, reason, .. } = &topic;
        let key = (topic.topic.clone(), *action, renamed.clone(), from.clone(), reason.clone());
        match all.entry(key) {
            Entry::Vacant(entry) => _ = entry.insert(topic),
            Entry::Occupied(mut entry) => entry.get_mut().add(topic),
        }
    }
    all.into_values().collect()
}

impl TopicReport {
    /// Adds the same topic of another file.
    fn add(&mut self, other: Self) {
        self.messages += other.messages;
        self.unreadable += other.unreadable;
        self.error = self.error.take().or(other.error);
        for loss in other.losses {
            match self.losses.iter_mut().find(|known| known.text == loss.text) {
                Some(known) => {
                    known.messages = known.messages.zip(loss.messages).map(|(one, other)| one + other);
                }
                None => self.losses.push(loss),
            }
        }
    }

    fn write(&self, text: &mut String) {
        let Self { topic, renamed, action, reason, messages, .. } = self;
        let _ = write!(text, "  {:<10} {}", action.text(), shown(topic));
        if let Some(renamed) = renamed {
            let _ = write!(text, " as {}", shown(renamed));
        }
        let _ = write!(text, ": {}", plural(*messages, "message"));
        if let Some(reason) = reason {
            let _ = write!(text, "; {}", shown(reason));
        }
        text.push('\n');
        for loss in &self.losses {
            let _ = match loss.messages {
                Some(0) => continue,
                Some(count) => {
                    writeln!(text, "             {} ({})", shown(&loss.text), plural(count, "message"))
                }
                None => writeln!(text, "             {}", shown(&loss.text)),
            };
        }
        if let Some(error) = &self.error {
            let count = plural(self.unreadable, "unreadable message");
            let _ = writeln!(text, "             {count} left out; the first: {}", shown(error));
        }
    }
}
