//! The summary of a bag.

use serde::Serialize;
use uavspec_model::text::{plural, shown, thousands};
use uavspec_px4::json::Dialects;

use super::network::{BusTopic, network_line};
use super::open::{BagChannel, ChannelResult};
use crate::release::{ReleaseMatch, release_lines};
use crate::{Describe, Line, List, Totals};

/// The summary of an MCAP file.
#[derive(Clone, Debug, Serialize, schemars::JsonSchema)]
#[schemars(rename = "Mcap")]
pub struct McapSummary {
    /// The profile, e.g. `ros2`.
    pub profile: String,
    /// The library that wrote the file.
    pub library: String,
    /// The channels, by topic.
    pub channels: Vec<BagChannel>,
    /// The accepted deviations of JSON messages from the published schemas.
    pub dialects: Dialects,
    /// The releases that the schemas were compared with.
    pub releases: Vec<ReleaseMatch>,
    /// The topics of a live vehicle, with their publishers and subscribers. Empty unless the file is a recording of
    /// `probe`.
    pub bus: Vec<BusTopic>,
}

/// The summary of a rosbag2 bag: a `SQLite` file, or a folder with `metadata.yaml`.
#[derive(Clone, Debug, Default, Serialize, schemars::JsonSchema)]
#[schemars(rename = "Rosbag2")]
pub struct BagSummary {
    /// The storage format: `sqlite3` or `mcap`.
    pub storage: String,
    /// The ROS distribution that recorded the bag; may be empty.
    pub distribution: String,
    /// The number of files.
    #[serde(rename = "files")]
    pub num_files: u64,
    /// The channels, by topic.
    pub channels: Vec<BagChannel>,
    /// The accepted deviations of JSON messages from the published schemas.
    pub dialects: Dialects,
    /// The releases that the schemas were compared with.
    pub releases: Vec<ReleaseMatch>,
}

impl BagChannel {
    /// The topic, with the differences or the reason why there was no comparison.
    fn described(&self) -> (&str, String) {
        (&self.topic, shown(&self.message))
    }

    /// The reason why some or all of the channel's messages aren't read. `None` if all are read.
    fn not_read(&self) -> Option<String> {
        match self.result {
            ChannelResult::Unsupported => Some(format!("unsupported encoding `{}`", shown(&self.encoding))),
            _ if self.other_cdr > 0 => Some(format!(
                "{} messages in a CDR encoding other than plain version 1",
                thousands(self.other_cdr)
            )),
            _ => None,
        }
    }
}

impl Describe for McapSummary {
    fn facts(&self, totals: Totals) -> Vec<String> {
        let or = |text: &str, default: &str| if text.is_empty() { default.to_owned() } else { shown(text) };
        vec![
            format!("{} ({})", or(&self.profile, "no profile"), or(&self.library, "unknown library")),
            totals.duration(),
            plural(self.channels.len(), "channel"),
            totals.messages(),
        ]
    }

    fn lines(&self) -> Vec<Line> {
        let mut lines = lines(&self.channels, self.dialects, &self.releases);
        lines.extend(network_line(&self.bus));
        lines
    }
}

impl Describe for BagSummary {
    fn facts(&self, totals: Totals) -> Vec<String> {
        let mut storage = vec![shown(&self.storage)];
        if !self.distribution.is_empty() {
            storage.push(shown(&self.distribution));
        }
        if self.num_files != 1 {
            storage.push(plural(self.num_files, "file"));
        }
        vec![
            format!("rosbag2 ({})", storage.join(", ")),
            totals.duration(),
            plural(self.channels.len(), "channel"),
            totals.messages(),
        ]
    }

    fn lines(&self) -> Vec<Line> {
        lines(&self.channels, self.dialects, &self.releases)
    }

    fn noun(&self) -> &'static str {
        "bag"
    }
}

/// The lines that describe the comparison of the channels' schemas with the definitions.
fn lines<'c>(channels: &'c [BagChannel], dialects: Dialects, releases: &[ReleaseMatch]) -> Vec<Line> {
    let with_result = |wanted| channels.iter().filter(move |channel| channel.result == wanted);
    let messages = |wanted| with_result(wanted).map(BagChannel::described);
    let text = format!(
        "{} of {} channels match, {} differ, {} without a comparable schema, {} unknown",
        with_result(ChannelResult::Equal).count(),
        channels.len(),
        with_result(ChannelResult::Differs).count(),
        with_result(ChannelResult::ByName).count(),
        with_result(ChannelResult::Undefined).count() + with_result(ChannelResult::OwnSchema).count(),
    );
    let undefined = |channel: &BagChannel| {
        let schema = channel.schema.as_deref().map_or_else(|| "no schema".to_owned(), shown);
        if channel.message.is_empty() { schema } else { format!("{schema}: {}", shown(&channel.message)) }
    };
    let not_read = |channel: &'c BagChannel| Some((channel.topic.as_str(), channel.not_read()?));
    let mut line = Line::new("definitions", text)
        .list("differs", messages(ChannelResult::Differs))
        .list("by name", messages(ChannelResult::ByName))
        .list("not read", channels.iter().filter_map(not_read))
        .list(
            "undefined",
            with_result(ChannelResult::Undefined).map(|channel| (&*channel.topic, undefined(channel))),
        )
        .list("own schema", messages(ChannelResult::OwnSchema).filter(|(_, remark)| !remark.is_empty()));
    line.lists.push(List { label: "dialect", items: dialects.iter().map(|one| one.to_string()).collect() });
    release_lines(releases, line)
}
