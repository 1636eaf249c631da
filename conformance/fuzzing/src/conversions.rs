//! The target for conversions of captures.

use std::io::{Cursor, Read};
use std::path::Path;
use std::sync::{Arc, LazyLock};

use uavspec_capture::mcap::{Event, Reader};
use uavspec_capture::{MCAP_MAGIC, ULOG_MAGIC, ulog};
use uavspec_check::Opened;
use uavspec_check::convert::{Action, ConversionReport, Format, Output, Plan, Settings, convert};
use uavspec_rules::definitions::Library;
use uavspec_rules::sample::{Bag, BagChannel, Flight};
use uavspec_runtime::cdr::ByteOrder;
use uavspec_schema::Failure;

use super::Pieces;

/// The number of channels in a seed.
const SEED_CHANNELS: usize = 12;

/// The release of the seeds.
static SOURCE: LazyLock<Library> = LazyLock::new(|| release("px4@1.17"));

/// The plan for the conversion to another release. Creating a plan takes longer than converting an input.
static PLAN: LazyLock<Plan> = LazyLock::new(|| {
    let source = Arc::clone(SOURCE.base());
    valid(Plan::new(source, &Library::built_in(), Some(&release("px4@1.16")), None))
});

fn release(label: &str) -> Library {
    valid(Library::release(label))
}

fn valid<T>(result: Result<T, Failure>) -> T {
    result.unwrap_or_else(|failure| panic!("{failure}"))
}

/// The plan for a conversion to another format.
static SAME: LazyLock<Plan> =
    LazyLock::new(|| valid(Plan::new(Arc::clone(SOURCE.base()), &Library::built_in(), None, None)));

/// Converts a log to an MCAP file, and this file to a log. Both must be readable, and must contain all messages except those
/// that the report lists as left out.
pub(super) fn log(data: &[u8]) {
    if !data.starts_with(&ULOG_MAGIC) {
        return;
    }
    let change = |kind, data: &[u8], format| {
        let mut output = Vec::new();
        let bytes: Box<dyn Read + Send> = Box::new(Cursor::new(data.to_vec()));
        let opened =
            Opened { kind, definitions: Arc::clone(SOURCE.base()), bytes, database: None, state: None };
        let settings = Settings { format: Some(format), ..Settings::default() };
        let report = convert((Path::new("fuzz"), opened), &SAME, settings, Output::Stream(&mut output));
        (report.unwrap_or_else(|error| panic!("{error:?}")), output)
    };
    let (report, bag) = change("ULog", data, Format::Mcap);
    assert_eq!(messages(&bag), kept(&report));
    let (report, log) = change("MCAP", &bag, Format::Log);
    let of_topics = |report: ConversionReport| {
        let topics = report.topics.into_iter().filter(|topic| topic.renamed.is_some());
        ConversionReport { topics: topics.collect(), ..report }
    };
    assert_eq!(records(&log), kept(&of_topics(report)));
}

/// The number of messages that an output must contain.
fn kept(report: &ConversionReport) -> u64 {
    let kept = report.topics.iter().filter(|topic| topic.action != Action::LeftOut);
    kept.map(|topic| topic.messages - topic.unreadable).sum()
}

/// The number of data messages in a log.
fn records(output: &[u8]) -> u64 {
    let (mut reader, mut log, mut count) = (ulog::Reader::new(output), ulog::Log::default(), 0);
    while let Some(item) = reader.next().unwrap_or_else(|error| panic!("memory: {error}")) {
        if let ulog::Event::Problem(problem) = &item.event {
            panic!("the output has a problem: {problem}");
        }
        let record = log.take(&item, &mut |_, problem| panic!("the output has a problem: {problem}"));
        count += u64::from(record.is_some());
    }
    count
}

/// The plan for the conversion to another distribution of ROS 2. The schemas of the bag describe the messages.
static ROS: LazyLock<Plan> = LazyLock::new(|| {
    let source = Arc::clone(SOURCE.base());
    valid(Plan::new(source, &Library::built_in(), Some(&release("ros2@humble")), None))
});

/// The types of ROS 2 in a seed.
const SEED_TYPES: [&str; 5] = [
    "sensor_msgs/msg/Range",
    "nav_msgs/msg/Odometry",
    "std_srvs/srv/SetBool_Event",
    "rcl_interfaces/msg/ParameterEvent",
    "action_msgs/srv/CancelGoal_Request",
];

/// Converts an MCAP file. The output must be readable, and must contain all messages except those that the report lists
/// as left out.
pub(super) fn mcap(data: &[u8]) {
    if !data.starts_with(&MCAP_MAGIC) {
        return;
    }
    for (plan, keeps_unconverted) in [(&PLAN, false), (&PLAN, true), (&ROS, false)] {
        let settings = Settings { keeps_unconverted, ..Settings::default() };
        let (report, output) = converted(Box::new(Cursor::new(data.to_vec())), plan, settings);
        assert_eq!(messages(&output), kept(&report));
        let (_, in_pieces) = converted(Box::new(Pieces::new(data)), plan, settings);
        assert!(output == in_pieces, "the output depends on the lengths of reads");
    }
}

fn converted<'b>(
    bytes: Box<dyn Read + Send + 'b>,
    plan: &Plan,
    settings: Settings,
) -> (ConversionReport, Vec<u8>) {
    let mut output = Vec::new();
    let opened =
        Opened { kind: "MCAP", definitions: Arc::clone(SOURCE.base()), bytes, database: None, state: None };
    let report = convert((Path::new("fuzz.mcap"), opened), plan, settings, Output::Stream(&mut output));
    (report.unwrap_or_else(|error| panic!("{error:?}")), output)
}

/// The number of messages in an output.
fn messages(output: &[u8]) -> u64 {
    let (mut reader, mut count) = (Reader::new(output), 0);
    while let Some(item) = reader.next().unwrap_or_else(|error| panic!("memory: {error}")) {
        match item.event {
            Event::Problem(problem) => panic!("the output has a problem: {problem}"),
            Event::Message { .. } => count += 1,
            _ => {}
        }
    }
    count
}

/// Bags with a few channels each.
pub(super) fn mcap_seeds() -> Vec<Vec<u8>> {
    let mut flight = Flight::new(SOURCE.base());
    flight.messages.truncate(flight.topics.len());
    let whole = flight.bag();
    let parts = whole.channels.chunks(SEED_CHANNELS).enumerate();
    let part = |(number, channels): (usize, &[_])| {
        let first = number * SEED_CHANNELS;
        let own = |(channel, time, payload): &(u16, u64, Vec<u8>)| {
            let channel = usize::from(*channel).checked_sub(first).filter(|at| *at < channels.len())?;
            Some((u16::try_from(channel).ok()?, *time, payload.clone()))
        };
        Bag {
            application: Vec::new(),
            channels: channels.to_vec(),
            endpoints: Vec::new(),
            messages: whole.messages.iter().filter_map(own).collect(),
        }
        .to_bytes()
    };
    parts.map(part).chain([ros_seed()]).collect()
}

/// A bag with messages of ROS 2, and their schemas.
fn ros_seed() -> Vec<u8> {
    let library = release("ros2@jazzy");
    let definitions = library.base();
    let (mut channels, mut messages) = (Vec::new(), Vec::new());
    for (number, name) in (0_u16..).zip(SEED_TYPES) {
        let id = definitions.message_of_type(name).unwrap_or_else(|| panic!("{name}"));
        let message = definitions.types().get(id).default().to_cdr(ByteOrder::LittleEndian);
        messages.push((number, 7, message.unwrap_or_else(|error| panic!("{name}: {error}"))));
        channels.push(BagChannel {
            topic: format!("/topic{number}"),
            schema: name.to_owned(),
            text: definitions.bag_text(id),
            hash: definitions.captured_hash(definitions.schema.message(id)),
        });
    }
    Bag { application: Vec::new(), channels, endpoints: Vec::new(), messages }.to_bytes()
}
