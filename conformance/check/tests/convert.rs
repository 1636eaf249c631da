//! Tests of conversions of captures: the output agrees with the target release.

mod bags;
mod definitions;
mod files;
mod formats;
mod json;
mod releases;
mod schema;
mod ulog;

use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::path::Path;
use std::sync::{Arc, LazyLock, Mutex, OnceLock, PoisonError};

use tempfile::TempDir;
use uavspec_check::convert::{Action, ConversionReport, Error, Output, Plan, Settings, convert};
use uavspec_check::{Checked, check_path, open_path};
use uavspec_rules::definitions::{Definitions, Library};
use uavspec_rules::sample::{Bag, Flight};
use uavspec_test_support::extent;

static LIBRARY: LazyLock<Library> = LazyLock::new(Library::built_in);

/// A release, and a short flight with its topics. Both are created when a test first needs them.
struct Release {
    library: Library,
    flight: OnceLock<Flight<'static>>,
}

static RELEASES: LazyLock<BTreeMap<String, Release>> = LazyLock::new(|| {
    let index = LIBRARY.index();
    let labels = index.releases().map(|release| index.label(release));
    let releases = labels.map(|label| {
        let library = Library::release(&label).expect("a release");
        (label, Release { library, flight: OnceLock::new() })
    });
    releases.collect()
});

fn release(label: &str) -> &'static Library {
    &RELEASES[label].library
}

/// A short flight with all topics of a release.
fn short_flight(label: &str) -> &'static Flight<'static> {
    let Release { library, flight } = &RELEASES[label];
    flight.get_or_init(move || {
        let mut flight = Flight::new(library.base());
        flight.messages.truncate(2 * flight.topics.len());
        flight
    })
}

/// The recording of a short flight with all topics of a release.
fn flight(label: &str) -> Bag {
    short_flight(label).bag()
}

/// A short flight with the topics of a release that are selected by their index and name. The topics of external
/// components stay together, because rules compare them.
fn flight_with(label: &str, is_selected: impl Fn(usize, &str) -> bool) -> Flight<'static> {
    let mut flight = short_flight(label).clone();
    let names = flight.topics.iter().map(|topic| topic.name.as_str()).enumerate();
    let is_kept = |at: usize, name: &str| {
        is_selected(at, name) || name.starts_with("arming_check_") || name.contains("register_ext_component")
    };
    let kept: Vec<usize> = names.filter(|(at, name)| is_kept(*at, name)).map(|(at, _)| at).collect();
    flight.topics = kept.iter().map(|at| flight.topics[*at].clone()).collect();
    let place = |topic: usize| kept.binary_search(&topic);
    flight.messages.retain(|sent| place(sent.topic).is_ok());
    for sent in &mut flight.messages {
        sent.topic = place(sent.topic).expect("a topic");
    }
    flight
}

/// A short flight. In quick mode, it has only every fourth topic, which is enough to recognize the release.
fn sample(label: &str) -> Flight<'static> {
    flight_with(label, |at, _| (at + 1).is_multiple_of(extent(1, 4)))
}

/// Converts a capture. Returns the report and the output.
pub(super) fn converted(bytes: &[u8], to: &str, settings: Settings) -> (ConversionReport, Vec<u8>) {
    try_converted(bytes, &LIBRARY, to, settings).expect("a conversion")
}

/// A cached plan, with the values that it depends on: the definitions of the capture, the name of the library, and the
/// target release.
type KnownPlan = (Arc<Definitions>, String, String, Arc<Plan>);

/// The plan of a conversion. Creating a plan takes longer than converting a small capture, so the tests share the most
/// recent plans.
fn plan(source: &Arc<Definitions>, library: &Library, to: &str) -> Arc<Plan> {
    static PLANS: Mutex<Vec<KnownPlan>> = Mutex::new(Vec::new());
    let plans = || PLANS.lock().unwrap_or_else(PoisonError::into_inner);
    let is_known = |(definitions, name, target, _): &&KnownPlan| {
        Arc::ptr_eq(definitions, source) && name == library.name() && target == to
    };
    if let Some((.., plan)) = plans().iter().find(is_known) {
        return Arc::clone(plan);
    }
    let plan = Arc::new(Plan::new(Arc::clone(source), library, Some(release(to)), None).expect("a plan"));
    let mut plans = plans();
    if plans.len() >= 20 {
        plans.remove(0);
    }
    plans.push((Arc::clone(source), library.name().to_owned(), to.to_owned(), Arc::clone(&plan)));
    plan
}

/// Converts a capture. The library contains the releases to which it is compared.
fn try_converted(
    bytes: &[u8],
    library: &Library,
    to: &str,
    settings: Settings,
) -> Result<(ConversionReport, Vec<u8>), Error> {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("in");
    fs::write(&path, bytes).expect("a file");
    let opened = open_path(&path, library, &|input| input).expect("a file").expect("a capture");
    let plan = plan(&opened.definitions, library, to);
    let mut output = Vec::new();
    let report = convert((&path, opened), &plan, settings, Output::Stream(&mut output))?;
    Ok((report, output))
}

fn checked(bytes: &[u8]) -> Checked {
    checked_against(bytes, &LIBRARY)
}

fn checked_against(bytes: &[u8], library: &Library) -> Checked {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("out");
    fs::write(&path, bytes).expect("a file");
    check_path(&path, None, library, &|input| input).expect("a capture")
}

#[test]
fn converted_bags_agree_with_the_target_release() {
    let pairs = [("1.16", "1.17"), ("1.17", "1.16"), ("1.13", "1.18"), ("main", "1.14")];
    for (from, to) in pairs.into_iter().step_by(extent(1, 2)) {
        let (from, to) = (format!("px4@{from}"), format!("px4@{to}"));
        let bag = sample(&from).bag();
        let (report, output) = converted(&bag.to_bytes(), &to, Settings::default());
        assert!(report.is_complete(), "{:?}", report.problems);
        assert_eq!(
            (report.from.as_slice(), report.to.as_deref()),
            ([from.clone()].as_slice(), Some(to.as_str()))
        );
        assert_eq!(report.topics.len(), bag.channels.len());
        assert_eq!(report.count(Action::Copied), 0);
        let left_out = report.topics.iter().filter(|topic| topic.action == Action::LeftOut);
        assert!(left_out.clone().all(|topic| topic.reason.is_some()));
        let found = checked(&output);
        let releases = found.result.summary.releases();
        let topics = report.count(Action::Converted) as u64;
        assert!(topics > extent(100, 15), "{topics}");
        let choice = (releases[0].release.as_str(), releases[0].matching, releases[0].topics);
        assert_eq!(choice, (to.as_str(), topics, topics), "{from}");
        assert_eq!(found.result.corruption.len(), 0);
        let messages: u64 = left_out.map(|topic| topic.messages).sum();
        assert_eq!(found.result.records, bag.messages.len() as u64 - messages);
        let wrong = found.result.findings.groups().map(|group| group.rule.id);
        let wrong: Vec<_> =
            wrong.filter(|id| id.starts_with("PX-HASH") || id.starts_with("PX-FMT")).collect();
        assert_eq!(wrong, Vec::<&str>::new());
    }
}

#[test]
fn a_bag_of_the_target_release_keeps_its_messages() {
    let bag = flight("px4@1.16");
    let (report, output) = converted(&bag.to_bytes(), "px4@1.16", Settings::default());
    assert_eq!(report.count(Action::Converted), bag.channels.len());
    assert!(report.topics.iter().all(|topic| topic.renamed.is_none() && topic.losses.is_empty()));
    let mut payloads: Vec<Vec<u8>> = ::mcap::MessageStream::new(&output)
        .expect("a bag")
        .map(|message| message.expect("a message").data.into_owned())
        .collect();
    let mut expected: Vec<Vec<u8>> = bag.messages.iter().map(|(.., payload)| payload.clone()).collect();
    payloads.sort();
    expected.sort();
    assert!(payloads == expected);
}

#[test]
fn unreadable_messages_of_unchanged_types_are_left_out() {
    let mut bag = flight("px4@1.16");
    let good = bag.messages.len();
    for (.., payload) in bag.messages.iter_mut().take(3) {
        payload.truncate(payload.len() - 1);
    }
    let (report, output) = converted(&bag.to_bytes(), "px4@1.16", Settings::default());
    assert_eq!(report.topics.iter().map(|topic| topic.unreadable).sum::<u64>(), 3);
    assert!(!report.is_complete());
    assert_eq!(::mcap::MessageStream::new(&output).expect("a bag").count(), good - 3);
}

#[test]
fn other_topics_are_copied_unchanged() {
    let mut bag = flight("px4@1.17");
    for (channel, name) in bag.channels.iter_mut().zip(["club_msgs/msg/Winch", "club_msgs/msg/Rope"]) {
        channel.schema = name.to_owned();
        channel.hash.clear();
        channel.text = "uint8 id\n".to_owned();
    }
    bag.channels[0].topic = "/winch".to_owned();
    bag.channels[1].topic = "/rope".to_owned();
    let (report, output) = converted(&bag.to_bytes(), "px4@1.16", Settings::default());
    let copied: Vec<&str> = report
        .topics
        .iter()
        .filter(|topic| topic.action == Action::Copied)
        .map(|topic| topic.topic.as_str())
        .collect();
    assert_eq!(copied, ["/rope", "/winch"]);
    let winch = ::mcap::MessageStream::new(&output).expect("a bag").find_map(|message| {
        let message = message.expect("a message");
        (message.channel.topic == "/winch").then_some(message)
    });
    let winch = winch.expect("a message");
    let schema = winch.channel.schema.clone().expect("a schema");
    assert_eq!((schema.name.as_str(), &*schema.data), ("club_msgs/msg/Winch", &b"uint8 id\n"[..]));
    let sent = bag.messages.iter().find(|(channel, ..)| *channel == 0).expect("a message");
    assert_eq!(*winch.data, *sent.2);
}

#[test]
fn unconverted_messages_are_kept_on_request() {
    let bag = sample("px4@1.18").bag();
    let bytes = bag.to_bytes();
    let (report, _) = converted(&bytes, "px4@1.13", Settings::default());
    let left_out = report.count(Action::LeftOut);
    assert!(left_out > extent(10, 5), "{left_out}");
    let text = report.to_text();
    assert!(text.contains("PX4 1.13 lacks the message"), "{text}");
    let (kept, output) =
        converted(&bytes, "px4@1.13", Settings { keeps_unconverted: true, ..Settings::default() });
    assert_eq!((kept.count(Action::LeftOut), kept.count(Action::Copied)), (0, left_out));
    assert_eq!(checked(&output).result.records, bag.messages.len() as u64);
}

/// The capture is from custom firmware: its type has the name of a PX4 message, but different fields.
#[test]
fn types_that_no_release_defines_are_left_out() {
    let mut bag = flight("px4@1.17");
    let at =
        bag.channels.iter().position(|channel| channel.topic.contains("battery_status")).expect("a channel");
    bag.channels[at].text.push('\n');
    bag.channels[at].text.insert_str(0, "uint8 cells_of_the_club\n");
    bag.channels[at].hash.clear();
    let (report, _) = converted(&bag.to_bytes(), "px4@1.16", Settings::default());
    let topic = report.topics.iter().find(|topic| topic.topic == bag.channels[at].topic).expect("the topic");
    assert_eq!(topic.action, Action::LeftOut);
    assert!(
        topic.reason.as_ref().is_some_and(|reason| reason.contains("its fields differ from PX4 1.17")),
        "{topic:?}"
    );
}

#[test]
fn losses_are_counted() {
    let (report, _) = converted(&flight("px4@1.17").to_bytes(), "px4@1.16", Settings::default());
    let losses = report.topics.iter().flat_map(|topic| topic.losses.iter().map(move |loss| (topic, loss)));
    let mut counted = losses.clone().filter_map(|(topic, loss)| Some((topic.messages, loss.messages?)));
    assert!(counted.clone().any(|(_, count)| count > 0));
    assert!(counted.all(|(messages, count)| count <= messages));
    let (topic, loss) = losses.clone().find(|(_, loss)| loss.messages > Some(0)).expect("a loss");
    let text = report.to_text();
    assert!(text.contains(&loss.text) && text.contains(&topic.topic), "{text}");
}

#[test]
fn readable_messages_of_a_truncated_bag_are_converted() {
    let bytes = sample("px4@1.16").bag().to_bytes();
    let (whole, _) = converted(&bytes, "px4@1.17", Settings::default());
    for cut in [bytes.len() * 19 / 20, bytes.len() - 40] {
        let (report, output) = converted(&bytes[..cut], "px4@1.17", Settings::default());
        assert!(!report.is_complete() && whole.is_complete());
        let found = checked(&output);
        assert_eq!(found.result.corruption.len(), 0);
        assert!(found.result.records > 0);
    }
}

#[test]
fn a_bag_that_grows_is_converted_up_to_its_end_at_the_start() {
    let bytes = sample("px4@1.16").bag().to_bytes();
    let (whole, expected) = converted(&bytes, "px4@1.17", Settings::default());
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("in.mcap");
    fs::write(&path, &bytes).expect("a file");
    let extend = |input: Box<dyn Read + Send>| {
        fs::write(&path, [&bytes[..], b"more"].concat()).expect("a file");
        input
    };
    let opened = open_path(&path, &LIBRARY, &extend).expect("a file").expect("a capture");
    let (plan, mut output) = (plan(&opened.definitions, &LIBRARY, "px4@1.17"), Vec::new());
    let report = convert((&path, opened), &plan, Settings::default(), Output::Stream(&mut output))
        .expect("a conversion");
    assert!(whole.is_complete() && !report.is_complete());
    let [problem] = &report.problems[..] else { panic!("{:?}", report.problems) };
    assert!(problem.starts_with("the file grew from "), "{problem}");
    assert!(output == expected);
}

#[test]
fn topics_follow_the_version_of_the_target() {
    let (report, _) = converted(&flight("px4@1.16").to_bytes(), "px4@1.17", Settings::default());
    let renamed: Vec<(&str, &str)> = report
        .topics
        .iter()
        .filter_map(|topic| Some((topic.topic.as_str(), topic.renamed.as_deref()?)))
        .collect();
    let expected = ("/fmu/out/arming_check_request", "/fmu/out/arming_check_request_v1");
    assert!(renamed.contains(&expected), "{renamed:?}");
}

#[test]
fn hints_with_mistakes_are_rejected() {
    let folder = TempDir::new().expect("a folder");
    let path = folder.path().join("hints.toml");
    let planned = |hints: &str| {
        fs::write(&path, hints).expect("a file");
        let source = Arc::clone(release("px4@1.16").base());
        let plan = Plan::new(source, &LIBRARY, Some(release("px4@1.17")), Some(Path::new(&path)));
        plan.map(|_| ()).map_err(|failure| failure.to_string())
    };
    let hint = "[[hint]]\nmessage = \"BatteryStatus\"\n";
    assert_eq!(planned(&format!("{hint}new.faults = 0\n")), Ok(()));
    for (wrong, expected) in [
        (format!("{hint}new.winch = 0\n"), "winch"),
        (format!("{hint}new.faults = \"winch + 1\"\n"), "winch"),
        ("[[hint]]\nmessage = \"Winch\"\nnew.id = 0\n".to_owned(), "Winch"),
        ("[[hint]\n".to_owned(), "hints.toml:1"),
    ] {
        let error = planned(&wrong).expect_err(&wrong);
        assert!(error.contains(expected) && error.contains("hints.toml:"), "{error}");
    }
}
