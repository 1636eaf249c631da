//! The releases that a capture is checked against.

use std::io::{self, Read};

use serde::Serialize;
use uavspec_capture::input::UpToError;
use uavspec_model::text::shown;
use uavspec_rules::definitions::{Definitions, LoadedRelease};
use uavspec_schema::MessageId;

use super::Line;

/// The maximum number of bytes that are read before the release is chosen.
pub(super) const MAX_AHEAD: u64 = 8 << 20;

/// The release that a capture was checked against.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
pub struct ReleaseMatch {
    /// The release, such as `px4@1.16`.
    pub release: String,
    /// The name of the release in text.
    #[serde(skip)]
    pub title: String,
    /// The number of topics that have the same format in the release.
    pub matching: u64,
    /// The number of topics.
    pub topics: u64,
    /// The topics that were checked against other releases.
    pub others: Vec<OtherRelease>,
}

impl ReleaseMatch {
    /// The release that a topic was checked against, if the topic is in `others`.
    pub fn other_of(&self, topic: &str) -> Option<&str> {
        self.others.iter().find(|other| other.topic == topic).map(|other| other.release.as_str())
    }

    /// The reason to assume that the capture is from another release: most topics match no known release. `None` if
    /// there is no such reason.
    pub fn problem(&self) -> Option<String> {
        let Self { title, matching, topics, others, .. } = self;
        let known = matching + others.len() as u64;
        (known * 2 < *topics).then(|| format!("only {matching} of {topics} topics match {title}"))
    }
}

/// A topic that was checked against another release than most topics.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
pub struct OtherRelease {
    /// The topic.
    pub topic: String,
    /// The release, such as `px4@1.15`.
    pub release: String,
}

/// A topic, compared with its definition.
#[derive(Clone, Copy, Debug)]
pub(super) struct ComparedTopic<'t> {
    pub(super) topic: &'t str,
    pub(super) definition: Option<MessageId>,
    pub(super) is_equal: bool,
}

/// Compares topics with the releases that were chosen for a capture.
pub(super) fn release_matches<'t>(
    definitions: &Definitions,
    topics: &(impl Iterator<Item = ComparedTopic<'t>> + Clone),
) -> Vec<ReleaseMatch> {
    let matches = definitions.releases().iter().map(|release| {
        let LoadedRelease { family, label, title } = release;
        let mut found = ReleaseMatch {
            release: label.clone(),
            title: title.clone(),
            matching: 0,
            topics: 0,
            others: Vec::new(),
        };
        for ComparedTopic { topic, definition, is_equal } in topics.clone() {
            let origin = definition.and_then(|id| definitions.release_of(id));
            // Nothing is known about topics without a definition.
            if origin.is_some_and(|origin| origin.family != *family) {
                continue;
            }
            found.topics += 1;
            match origin {
                Some(origin) if origin.label == *label => found.matching += u64::from(is_equal),
                Some(origin) => {
                    found
                        .others
                        .push(OtherRelease { topic: topic.to_owned(), release: origin.label.clone() });
                }
                None => {}
            }
        }
        found
    });
    matches.filter(|found| found.topics > 0).collect()
}

/// The lines about releases in reports for people. `compared` is the line about all topics.
pub(super) fn release_lines(matches: &[ReleaseMatch], compared: Line) -> Vec<Line> {
    if let [ReleaseMatch { title, others, .. }] = matches
        && others.is_empty()
    {
        let text = format!("{}: {}", shown(title), compared.text);
        return vec![Line { text, ..compared }];
    }
    matches.iter().map(release_line).chain([compared]).collect()
}

/// The line about a release in reports for people.
pub(super) fn release_line(found: &ReleaseMatch) -> Line {
    let ReleaseMatch { title, matching, topics, others, .. } = found;
    let text = format!("{}: {matching} of {topics} topics match", shown(title));
    let others = others.iter().map(|other| (other.topic.as_str(), shown(&other.release)));
    Line::new("release", text).list("other", others)
}

/// A reader that keeps the bytes that it has read. It ends at a limit or at an error.
pub(super) struct Ahead<'r> {
    input: UpToError<io::Take<&'r mut dyn Read>>,
    pub(super) bytes: Vec<u8>,
}

impl<'r> Ahead<'r> {
    pub(super) fn new(input: &'r mut dyn Read) -> Self {
        Self { input: UpToError::new(input.take(MAX_AHEAD)), bytes: Vec::new() }
    }
}

impl Read for Ahead<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let length = self.input.read(out)?;
        self.bytes.extend_from_slice(&out[..length]);
        Ok(length)
    }
}
