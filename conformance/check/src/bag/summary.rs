//! The summary of a bag.

use serde::{Serialize, Serializer};
use uavspec_model::text::{plural, shown, thousands};
use uavspec_px4::comparison::Comparison;
use uavspec_px4::json::Dialects;

use super::network::{BusTopic, network_line};
use super::open::{BagChannel, Basis, CheckStatus};
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
    #[serde(serialize_with = "rows")]
    #[schemars(with = "Vec<Row>")]
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
    #[serde(serialize_with = "rows")]
    #[schemars(with = "Vec<Row>")]
    pub channels: Vec<BagChannel>,
    /// The accepted deviations of JSON messages from the published schemas.
    pub dialects: Dialects,
    /// The releases that the schemas were compared with.
    pub releases: Vec<ReleaseMatch>,
}

/// A channel, with the result of comparing its schema with the definition.
#[derive(Serialize, schemars::JsonSchema)]
#[schemars(rename = "McapChannel")]
struct Row<'c> {
    /// The topic.
    topic: &'c str,
    /// The encoding of the channel's messages, e.g. `cdr`.
    encoding: &'c str,
    /// The name of the channel's schema.
    schema: Option<&'c str>,
    /// The encoding of the channel's schema, e.g. `ros2msg`.
    schema_encoding: Option<&'c str>,
    /// The number of messages.
    messages: u64,
    /// The number of messages in unsupported CDR encodings: parameter lists and CDR version 2.
    other_cdr: u64,
    /// The result of comparing the channel's schema with the definition.
    result: ChannelResult,
    /// The differences, or the reason why there was no comparison; may be empty.
    message: String,
}

/// The result of comparing the schema of a channel with its definition.
#[derive(Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "lowercase")]
enum ChannelResult {
    /// The fields have the same types and the same order.
    Equal,
    /// Something differs.
    Differs,
    /// There is no comparable schema. The schema name or the topic identifies the definition.
    #[serde(rename = "by name")]
    ByName,
    /// There is no known definition for the channel. Its messages were checked against its own schema.
    #[serde(rename = "own schema")]
    OwnSchema,
    /// There is no known definition for the channel.
    Undefined,
    /// The channel's messages are neither CDR nor JSON.
    Unsupported,
}

impl<'c> Row<'c> {
    fn new(channel: &'c BagChannel) -> Self {
        let remark = || channel.remark.clone().unwrap_or_default();
        let (result, message) = match &channel.status {
            CheckStatus::Checked(Basis::Compared(comparison)) => match &**comparison {
                Comparison::Differs(differences) => {
                    let hash = if channel.has_other_hash { "; its hash differs as well" } else { "" };
                    (ChannelResult::Differs, format!("{differences}{hash}"))
                }
                Comparison::Equal | Comparison::Undefined => (ChannelResult::Equal, String::new()),
            },
            CheckStatus::Checked(basis) => (ChannelResult::ByName, basis.problem().unwrap_or_default()),
            CheckStatus::OwnSchema => (ChannelResult::OwnSchema, remark()),
            CheckStatus::Undefined => (ChannelResult::Undefined, remark()),
            CheckStatus::Unsupported => (ChannelResult::Unsupported, String::new()),
        };
        let (schema, schema_encoding) =
            channel.schema.as_ref().map(|(name, encoding)| (&**name, &**encoding)).unzip();
        Self {
            topic: &channel.topic,
            encoding: &channel.encoding,
            schema,
            schema_encoding,
            messages: channel.messages,
            other_cdr: channel.other_cdr,
            result,
            message,
        }
    }

    /// The reason why some or all of the channel's messages aren't read.
    fn not_read(&self) -> Option<String> {
        match self.result {
            ChannelResult::Unsupported => Some(format!("unsupported encoding `{}`", shown(self.encoding))),
            _ if self.other_cdr > 0 => Some(format!(
                "{} messages in a CDR encoding other than plain version 1",
                thousands(self.other_cdr)
            )),
            _ => None,
        }
    }
}

fn rows<S: Serializer>(channels: &[BagChannel], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(channels.iter().map(Row::new))
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

/// The results of comparing the schemas of the channels with the definitions.
fn lines(channels: &[BagChannel], dialects: Dialects, releases: &[ReleaseMatch]) -> Vec<Line> {
    let rows: Vec<Row<'_>> = channels.iter().map(Row::new).collect();
    let with_result = |wanted| rows.iter().filter(move |row| row.result == wanted);
    let messages = |wanted| with_result(wanted).map(|row| (row.topic, shown(&row.message)));
    let text = format!(
        "{} of {} channels match, {} differ, {} without a comparable schema, {} unknown",
        with_result(ChannelResult::Equal).count(),
        rows.len(),
        with_result(ChannelResult::Differs).count(),
        with_result(ChannelResult::ByName).count(),
        with_result(ChannelResult::Undefined).count() + with_result(ChannelResult::OwnSchema).count(),
    );
    let undefined = |row: &Row<'_>| {
        let schema = row.schema.map_or_else(|| "no schema".to_owned(), shown);
        if row.message.is_empty() { schema } else { format!("{schema}: {}", shown(&row.message)) }
    };
    let has_remark = |row: &&Row<'_>| !row.message.is_empty();
    let mut line = Line::new("definitions", text)
        .list("differs", messages(ChannelResult::Differs))
        .list("by name", messages(ChannelResult::ByName))
        .list("not read", rows.iter().filter_map(|row| Some((row.topic, row.not_read()?))))
        .list("undefined", with_result(ChannelResult::Undefined).map(|row| (row.topic, undefined(row))))
        .list(
            "own schema",
            with_result(ChannelResult::OwnSchema)
                .filter(has_remark)
                .map(|row| (row.topic, shown(&row.message))),
        );
    line.lists.push(List { label: "dialect", items: dialects.iter().map(|one| one.to_string()).collect() });
    release_lines(releases, line)
}
