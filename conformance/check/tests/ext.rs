//! Tests of the communication between a flight controller and external components: findings, and cases that an
//! incomplete recording leaves undecided.

use std::fs;
use std::sync::LazyLock;

use serde_json::{Value, json};
use tempfile::TempDir;
use uavspec_check::{CaptureResult, check_capture};
use uavspec_model::Verdict;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::rule;
use uavspec_rules::sample::{Entry, Flight, Sent};
use uavspec_test_captures::mcap as file;

static DEFINITIONS: LazyLock<Definitions> = LazyLock::new(Definitions::built_in);
static FLIGHT: LazyLock<Flight<'static>> = LazyLock::new(|| Flight::new(&DEFINITIONS));

const REQUEST: &str = "ArmingCheckRequest";
const REPLY: &str = "ArmingCheckReply";

/// The time between requests, in ms.
const PERIOD: u64 = 300;

/// A recording that a test writes message by message, with times in ms.
#[derive(Clone)]
struct Script<'d> {
    typical: &'d Flight<'d>,
    flight: Flight<'d>,
}

impl Script<'static> {
    fn new() -> Self {
        Self::with_flight(&FLIGHT)
    }
}

impl<'d> Script<'d> {
    fn with_flight(typical: &'d Flight<'d>) -> Self {
        Self { typical, flight: Flight { messages: Vec::new(), ..typical.clone() } }
    }

    fn topic(&self, message: &str) -> usize {
        self.typical.topic(message).expect("a topic")
    }

    /// Adds a typical message, in which these fields are replaced.
    fn add(&mut self, message: &str, ms: u64, fields: &Value) {
        let topic = self.topic(message);
        let sent = self.typical.messages.iter().find(|sent| sent.topic == topic).expect("a message");
        let mut value = sent.value.clone();
        value["timestamp"] = (ms * 1000).into();
        for (field, new) in fields.as_object().expect("fields") {
            if let Some(location) = value.get_mut(field) {
                *location = new.clone();
            }
        }
        self.flight.messages.push(Sent { topic, value });
    }

    fn request(&mut self, ms: u64, id: u8, registrations: &[u8]) {
        let mask: u32 = registrations.iter().map(|id| 1 << id).sum();
        self.add(REQUEST, ms, &json!({ "request_id": id, "valid_registrations_mask": mask }));
    }

    fn reply(&mut self, ms: u64, id: u8, registration: u8) {
        let fields = json!({
            "request_id": id, "registration_id": registration, "can_arm_and_run": true, "num_events": 0,
        });
        self.add(REPLY, ms, &fields);
    }

    /// Adds a reply that refuses arming.
    fn refusal(&mut self, ms: u64, id: u8, registration: u8) {
        let fields = json!({
            "request_id": id, "registration_id": registration, "can_arm_and_run": false, "num_events": 1,
        });
        self.add(REPLY, ms, &fields);
    }

    /// Adds a message with the name of a component: a registration or unregistration request, or a negative reply to
    /// one.
    fn name(&mut self, message: &str, ms: u64, id: u64, name: &str) {
        self.add(message, ms, &json!({ "request_id": id, "name": name, "success": false }));
    }

    fn register(&mut self, ms: u64, registration: i8) {
        let fields = json!({ "success": true, "arming_check_id": registration });
        self.add("RegisterExtComponentReply", ms, &fields);
    }

    fn unregister(&mut self, ms: u64, registration: i8) {
        self.add("UnregisterExtComponent", ms, &json!({ "arming_check_id": registration }));
    }

    /// Adds the requests with the numbers `from..to`, each with replies from all registered components.
    fn exchange(&mut self, from: u64, to: u64, registrations: &[u8]) {
        for number in from..to {
            self.request(number * PERIOD, id(number), registrations);
            for registration in registrations {
                self.reply(number * PERIOD + 5, id(number), *registration);
            }
        }
    }

    /// The findings of the rules on external components, except repeated replies, which many scripts contain. Asserts
    /// that the findings are the same for `ULog`, JSON and MCAP.
    fn found(&self) -> Vec<String> {
        let log = self.run_check(&self.flight.log().to_bytes());
        let is_other = |text: &String| !text.starts_with("PX-EXT-06");
        for other in [self.flight.rosbridge().to_bytes(), self.flight.bag().to_bytes()] {
            let other = self.run_check(&other);
            assert_eq!(reported(&log), reported(&other));
            for id in ["PX-EXT-01", "PX-EXT-02", "PX-EXT-03"] {
                let rule = rule(id).expect("a rule");
                assert_eq!(log.findings.covered(rule), other.findings.covered(rule), "{id}");
            }
        }
        reported(&log).into_iter().filter(is_other).collect()
    }

    /// The number of repeated replies.
    fn repeated(&self) -> u64 {
        let [log, bag] = [self.flight.log().to_bytes(), self.flight.bag().to_bytes()].map(|bytes| {
            let result = self.run_check(&bytes);
            let rule = rule("PX-EXT-06").expect("a rule");
            result.findings.groups_of(rule).map(|group| group.count).sum::<u64>()
        });
        assert_eq!(log, bag);
        log
    }

    fn run_check(&self, bytes: &[u8]) -> CaptureResult {
        check_capture(bytes, None, self.flight.definitions).expect("bytes can be read")
    }

    fn covered(&self, id: &str) -> u64 {
        self.run_check(&self.flight.log().to_bytes()).findings.covered(rule(id).expect("a rule"))
    }
}

/// The id of a request, which wraps around.
fn id(number: u64) -> u8 {
    u8::try_from(number % 256).expect("a byte")
}

/// The findings of these rules: the rule, the subject without the folder of the topic, the count, and the first message.
fn reported(result: &CaptureResult) -> Vec<String> {
    let groups = result.findings.groups().filter(|group| group.rule.id.starts_with("PX-EXT"));
    groups
        .map(|group| {
            let Value::String(message) = json!(group.examples[0].1.to_string()) else { unreachable!() };
            let subject = group.subject.replace("/fmu/out/", "").replace("/fmu/in/", "");
            format!("{} {subject} {}: {message}", group.rule.id, group.count)
        })
        .collect()
}

const NOTHING: [&str; 0] = [];

/// The time of a registration shortly before request 100, in ms.
const REGISTRATION_TIME: u64 = 100 * PERIOD - 200;

#[test]
fn accepts_request_ids_that_wrap_around() {
    let mut script = Script::new();
    script.register(0, 3);
    script.register(1, 5);
    script.exchange(250, 260, &[3, 5]);
    script.unregister(260 * PERIOD, 5);
    script.exchange(261, 270, &[3]);
    assert_eq!(script.found(), NOTHING);
    assert_eq!(script.covered("PX-EXT-01"), 29);
    assert_eq!(script.covered("PX-EXT-02"), 29);
    // In each part, the last two requests aren't checked. One request before the second part is missing.
    assert_eq!(script.covered("PX-EXT-03"), 2 * 8 + 7);
}

#[test]
fn a_reply_to_the_previous_request_is_late() {
    let mut script = Script::new();
    script.exchange(100, 105, &[3]);
    script.request(105 * PERIOD, 105, &[3]);
    script.request(106 * PERIOD, 106, &[3]);
    script.reply(106 * PERIOD + 20, 105, 3);
    script.reply(106 * PERIOD + 25, 106, 3);
    script.exchange(107, 110, &[3]);
    let late = "request 105: registration 3 replies after the next request";
    assert_eq!(script.found(), [format!("PX-EXT-03 arming_check_request 1: {late}")]);
}

#[test]
fn reports_replies_to_other_requests() {
    for (answered, is_wrong) in [(103, true), (104, false), (105, false), (106, true), (250, true)] {
        let mut script = Script::new();
        script.exchange(100, 106, &[3]);
        script.reply(105 * PERIOD + 20, answered, 3);
        script.exchange(106, 109, &[3]);
        let message = format!(
            "PX-EXT-01 arming_check_reply.request_id 1: registration 3 answers request {answered}, \
             but the latest request is 105"
        );
        let expected = if is_wrong { vec![message] } else { vec![] };
        assert_eq!(script.found(), expected);
    }
}

#[test]
fn reports_only_old_request_ids_at_the_end() {
    for (answered, is_wrong) in
        [(103, true), (100, true), (234, true), (233, false), (104, false), (106, false), (110, false)]
    {
        let mut script = Script::new();
        script.exchange(100, 106, &[3]);
        script.reply(105 * PERIOD + 20, answered, 3);
        assert_eq!(script.found().len(), usize::from(is_wrong), "{answered}");
    }
    let mut script = Script::new();
    script.request(PERIOD, 100, &[3]);
    script.reply(PERIOD + 5, 90, 3);
    assert_eq!(script.found(), NOTHING, "the previous request may have had any id");
}

#[test]
fn accepts_topics_in_any_order() {
    // One reply precedes its request in the file, and another one follows the next request. Their times are correct.
    for times in [[5, 5], [0, 0]] {
        let mut script = Script::new();
        script.exchange(100, 105, &[3]);
        let time = |number: u64, at: usize| if times[at] == 0 { 0 } else { number * PERIOD + times[at] };
        script.reply(time(105, 0), 105, 3);
        script.request(105 * PERIOD, 105, &[3]);
        script.request(106 * PERIOD, 106, &[3]);
        script.request(107 * PERIOD, 107, &[3]);
        script.reply(time(106, 1), 106, 3);
        script.reply(107 * PERIOD + 5, 107, 3);
        script.exchange(108, 112, &[3]);
        assert_eq!(script.found(), NOTHING);
    }
    // A reply is compared with the request that was the latest at the time of the reply, even if the reply is stored
    // much later.
    let mut script = Script::new();
    script.exchange(100, 105, &[]);
    script.reply(102 * PERIOD + 5, 101, 3);
    script.reply(102 * PERIOD + 5, 100, 3);
    script.exchange(105, 107, &[]);
    assert_eq!(script.found().len(), 1);
    assert!(script.found()[0].contains("registration 3 answers request 100"));
}

#[test]
fn components_may_use_another_clock() {
    for offset in [8, 1_000_000] {
        let mut script = Script::new();
        for number in 100..110 {
            script.request(2_000_000 + number * PERIOD, id(number), &[3]);
            script.reply(2_000_000 + number * PERIOD - offset, id(number), 3);
        }
        assert_eq!(script.found(), NOTHING);
        assert!(script.covered("PX-EXT-03") > 0);
    }
}

#[test]
fn reports_nothing_before_the_first_request() {
    let mut script = Script::new();
    script.reply(5, 17, 3);
    script.exchange(100, 103, &[3]);
    assert_eq!(script.found(), NOTHING);
    assert_eq!(script.covered("PX-EXT-01"), 3);
}

/// A log starts with the latest message of each topic, which may be an old reply.
#[test]
fn ignores_an_answer_older_than_all_requests() {
    for is_first in [false, true] {
        let mut script = Script::new();
        if is_first {
            script.reply(70 * PERIOD, 70, 3);
        }
        script.request(100 * PERIOD, 100, &[3]);
        if !is_first {
            script.reply(70 * PERIOD, 70, 3);
        }
        script.reply(100 * PERIOD + 5, 100, 3);
        script.exchange(101, 110, &[3]);
        assert_eq!(script.found(), NOTHING);
        script.reply(110 * PERIOD, 70, 3);
        assert_eq!(script.found().len(), 1);
    }
}

/// A log in which other entries separate two parts.
fn interrupted(before: &Script<'_>, between: Vec<Entry>, after: &Script<'_>) -> Vec<u8> {
    let mut log = before.flight.log();
    log.entries.extend(between);
    let data = after.flight.log().entries.into_iter().filter(|entry| matches!(entry, Entry::Data(..)));
    log.entries.extend(data);
    log.to_bytes()
}

#[test]
fn knows_no_state_after_a_dropout() {
    let mut before = Script::new();
    before.register(REGISTRATION_TIME, 3);
    before.exchange(100, 105, &[3]);
    before.unregister(105 * PERIOD - 100, 3);
    let mut after = Script::new();
    after.reply(105 * PERIOD, 50, 3);
    after.reply(105 * PERIOD, 104, 9);
    after.exchange(105, 106, &[]);
    after.reply(105 * PERIOD + 5, 105, 3);
    after.exchange(106, 108, &[]);
    let wrong = before.run_check(&interrupted(&before, vec![], &after));
    let rules: Vec<&str> = wrong.findings.groups().map(|group| group.rule.id).collect();
    assert_eq!(rules, ["PX-EXT-01", "PX-EXT-02"]);
    assert_eq!(
        reported(&before.run_check(&interrupted(&before, vec![Entry::Dropout(100)], &after))),
        NOTHING
    );
}

#[test]
fn reports_no_missing_reply_that_may_be_lost() {
    let [mut before, mut after] = [Script::new(), Script::new()];
    before.exchange(100, 105, &[3]);
    before.request(105 * PERIOD, 105, &[3]);
    after.exchange(106, 110, &[3]);
    let missing = before.run_check(&interrupted(&before, vec![], &after));
    let message = "request 105: registration 3 does not reply";
    assert_eq!(reported(&missing), [format!("PX-EXT-03 arming_check_request 1: {message}")]);
    let lost = before.run_check(&interrupted(&before, vec![Entry::Dropout(9)], &after));
    assert_eq!(reported(&lost), NOTHING);
    assert!(lost.findings.covered(rule("PX-EXT-03").expect("a rule")) > 0);

    // The unreadable messages: JSON with an error, and text that isn't JSON.
    let mut whole = before.clone();
    whole.reply(105 * PERIOD + 5, 105, 3);
    whole.flight.messages.extend(after.flight.messages.clone());
    let lines = whole.flight.rosbridge().lines;
    let at = lines.iter().rposition(|line| line.contains("\"request_id\":105")).expect("a line");
    for (wrong, is_missed) in [("", true), ("{\"op\":", false), ("mistake", false)] {
        let mut lines = lines.clone();
        lines[at] = match wrong {
            "mistake" => lines[at].replace("\"registration_id\":3", "\"registration_id\":3.5"),
            _ => wrong.to_owned(),
        };
        assert_eq!(
            reported(&whole.run_check(lines.join("\n").as_bytes())).len(),
            usize::from(is_missed),
            "{wrong}"
        );
    }
}

#[test]
fn uses_masks_if_the_recording_starts_late() {
    let mut script = Script::new();
    script.exchange(100, 103, &[3]);
    script.reply(102 * PERIOD + 8, 102, 5);
    script.exchange(103, 106, &[3]);
    assert_eq!(script.found(), NOTHING);
    script.unregister(105 * PERIOD + 100, 3);
    // The component answers the request that preceded its unregistration.
    script.reply(105 * PERIOD + 102, 105, 3);
    script.exchange(106, 107, &[]);
    assert_eq!(script.found(), NOTHING);
    script.reply(106 * PERIOD + 5, 106, 3);
    script.exchange(107, 109, &[]);
    let message = "registration id 3 was released before the request";
    let expected = [format!("PX-EXT-02 arming_check_reply.registration_id 1: {message}")];
    assert_eq!(script.found(), expected);
}

#[test]
fn reports_unassigned_ids_if_the_start_is_recorded() {
    let message = |id: u8| {
        let message = format!("registration id {id} was never assigned");
        vec![format!("PX-EXT-02 arming_check_reply.registration_id 1: {message}")]
    };
    let unknown_component = |begin: fn(&mut Script<'static>), mask: &[u8]| {
        let mut script = Script::new();
        begin(&mut script);
        script.exchange(100, 102, mask);
        script.reply(101 * PERIOD + 8, 101, 9);
        script.exchange(102, 104, mask);
        script.found()
    };
    assert_eq!(unknown_component(|script| script.register(REGISTRATION_TIME, 3), &[3]), message(9));
    assert_eq!(unknown_component(|_| {}, &[3]), NOTHING);
    assert_eq!(
        unknown_component(|script| script.register(REGISTRATION_TIME, 3), &[3, 5]),
        NOTHING,
        "5 was there before"
    );
    assert_eq!(unknown_component(|script| script.register(REGISTRATION_TIME, 3), &[3, 9]), NOTHING);
    for first in [
        |script: &mut Script<'static>| script.unregister(9, 1),
        |script: &mut Script<'static>| script.reply(9, 1, 3),
        |script: &mut Script<'static>| script.request(9, 99, &[]),
    ] {
        let mut script = Script::new();
        first(&mut script);
        script.register(REGISTRATION_TIME, 3);
        script.exchange(100, 102, &[3]);
        script.reply(101 * PERIOD + 8, 101, 9);
        script.exchange(102, 104, &[3]);
        assert_eq!(script.found(), NOTHING);
    }
    // A registration that fails, or that has no arming checks, assigns no id.
    let failed = unknown_component(
        |script| {
            script.register(REGISTRATION_TIME, 3);
            let fields = json!({ "success": false, "arming_check_id": 9 });
            script.add("RegisterExtComponentReply", REGISTRATION_TIME + 1, &fields);
            script.register(REGISTRATION_TIME + 2, -1);
        },
        &[3],
    );
    assert_eq!(failed, message(9));
}

/// A slow component gets no requests but still replies, so the time of its registration is unknown.
#[test]
fn an_old_registration_does_not_mark_the_start() {
    let late = |registered: u64| {
        let mut script = Script::new();
        script.register(registered, 1);
        for number in 100..110 {
            script.request(number * PERIOD, id(number), &[1]);
            script.reply(number * PERIOD + 5, id(number), 1);
            script.reply(number * PERIOD + 20, id(number - 1), 0);
        }
        script.found().len()
    };
    assert_eq!(late(500), 0);
    assert_eq!(late(100 * PERIOD - 601), 0);
    assert_eq!(late(100 * PERIOD - 600), 1);
    assert_eq!(late(100 * PERIOD + 10), 1);
    assert_eq!(late(100 * PERIOD + 11), 0, "the reply precedes the request only in the file");
    assert_eq!(late(0), 0, "the reply has no time");
}

/// The header of the test log says that the log starts at 1,000 ms.
#[test]
fn a_registration_before_the_log_does_not_mark_the_start() {
    for (registered, is_wrong) in [(999, false), (1_000, true)] {
        let mut script = Script::new();
        script.register(registered, 3);
        script.exchange(4, 6, &[3]);
        script.reply(5 * PERIOD + 8, 5, 9);
        script.exchange(6, 8, &[3]);
        let log = script.run_check(&script.flight.log().to_bytes());
        assert_eq!(reported(&log).len(), usize::from(is_wrong), "{registered}");
    }
}

#[test]
fn a_registration_after_a_dropout_does_not_mark_the_start() {
    let [mut before, mut after] = [Script::new(), Script::new()];
    before.exchange(90, 92, &[9]);
    after.register(REGISTRATION_TIME, 3);
    after.exchange(100, 102, &[3]);
    after.reply(101 * PERIOD + 8, 101, 9);
    after.exchange(102, 104, &[3]);
    assert_eq!(
        reported(&before.run_check(&interrupted(&before, vec![Entry::Dropout(100)], &after))),
        NOTHING
    );
    assert_eq!(after.found().len(), 1);
}

#[test]
fn a_mask_shows_that_an_id_was_reused() {
    let mut script = Script::new();
    script.register(REGISTRATION_TIME, 3);
    script.exchange(100, 105, &[3]);
    script.unregister(105 * PERIOD - 100, 3);
    script.exchange(105, 107, &[]);
    // The recording doesn't contain the registration.
    script.exchange(107, 112, &[3]);
    // Now the component is slow and gets no requests.
    script.request(112 * PERIOD, 112, &[]);
    script.reply(112 * PERIOD + 5, 112, 3);
    // The recording need not contain other components either.
    script.reply(112 * PERIOD + 6, 112, 9);
    script.exchange(113, 116, &[]);
    assert_eq!(script.found(), NOTHING);
}

#[test]
fn without_times_uses_the_order_of_arrival() {
    let mut script = Script::new();
    script.exchange(100, 103, &[3]);
    script.unregister(0, 3);
    script.exchange(103, 104, &[]);
    script.reply(0, 103, 3);
    let message = "registration id 3 was released before the request";
    assert_eq!(script.found(), [format!("PX-EXT-02 arming_check_reply.registration_id 1: {message}")]);
}

#[test]
fn accepts_a_late_answer_after_an_unregistration() {
    let mut script = Script::new();
    script.exchange(100, 103, &[3]);
    script.unregister(103 * PERIOD - 50, 3);
    script.request(103 * PERIOD, 103, &[]);
    script.reply(103 * PERIOD + 5, 102, 3);
    script.exchange(104, 106, &[]);
    assert_eq!(script.found(), NOTHING);
}

#[test]
fn finds_the_request_of_a_delayed_reply_among_eight() {
    for (requests, is_found) in [(8, true), (9, false)] {
        let mut script = Script::new();
        script.exchange(100, 100 + requests, &[]);
        script.reply(100 * PERIOD + 5, 99, 3);
        script.exchange(100 + requests, 102 + requests, &[]);
        assert_eq!(script.found(), NOTHING, "{requests}");
        assert_eq!(script.covered("PX-EXT-01"), u64::from(is_found), "{requests}");
    }
}

/// ROS 2 nodes often don't set the time in their messages.
#[test]
fn replies_without_a_time_are_late_if_several_follow_the_next_request() {
    for (late, found) in [(1, 0), (2, 0), (3, 1), (5, 3)] {
        let mut script = Script::new();
        for number in 100..115 {
            script.request(number * PERIOD, id(number), &[3]);
            if (105..105 + late).contains(&(number - 1)) {
                script.reply(0, id(number - 1), 3);
            }
            if !(105..105 + late).contains(&number) {
                script.reply(0, id(number), 3);
            }
        }
        let message = "request 107: registration 3 replies after the next request";
        let expected: Vec<String> = match found {
            0 => vec![],
            _ => vec![format!("PX-EXT-03 arming_check_request {found}: {message}")],
        };
        assert_eq!(script.found(), expected, "{late}");
    }
    // Duplicate replies and replies from other components don't count.
    let mut script = Script::new();
    script.exchange(100, 103, &[3, 5]);
    for number in 103..115 {
        script.request(number * PERIOD, id(number), &[3, 5]);
        script.reply(0, id(number - 1), 3);
        script.reply(0, id(number), 3);
        script.reply(0, id(number - number % 2), 5);
        script.reply(0, id(number - 1 + number % 2), 5);
    }
    assert_eq!(script.found(), NOTHING);
}

/// An unreadable message may have been the reply.
#[test]
fn reports_no_missing_reply_that_may_be_unreadable() {
    let mut script = Script::new();
    script.exchange(100, 110, &[3]);
    let [reply, other] =
        [REPLY, "FailsafeFlags"].map(|name| u16::try_from(script.topic(name)).expect("an id"));
    // If an unrelated message is unreadable, the missing reply is reported.
    for (id, found) in [(reply, &["PX-DATA-01"][..]), (other, &["PX-DATA-01", "PX-EXT-03"])] {
        let mut log = script.flight.log();
        let at = log.entries.iter().rposition(|entry| matches!(entry, Entry::Data(id, _) if *id == reply));
        log.entries[at.expect("a reply") - 8] = Entry::Data(id, b"abc".to_vec());
        assert_eq!(rules_violated(&script.run_check(&log.to_bytes())), found);

        let mut bag = script.flight.bag();
        let message = bag.messages.iter_mut().rev().filter(|message| message.0 == reply).nth(4);
        let (channel, _, payload) = message.expect("a reply");
        (*channel, *payload) = (id, payload[..8].to_vec());
        let found: Vec<&str> =
            found.iter().map(|id| if *id == "PX-DATA-01" { "PX-CDR-02" } else { id }).collect();
        assert_eq!(rules_violated(&script.run_check(&bag.to_bytes())), found);
    }
}

fn rules_violated(result: &CaptureResult) -> Vec<&'static str> {
    result.findings.groups().map(|group| group.rule.id).collect()
}

#[test]
fn checks_sessions_in_json_of_mcap() {
    let mut script = Script::new();
    script.exchange(100, 110, &[3]);
    script.reply(109 * PERIOD + 9, 50, 3);
    let topics = [REQUEST, REPLY].map(|message| script.topic(message));
    let mut records = Vec::new();
    for (id, topic) in (1..).zip(topics) {
        let name = format!("/fmu/out/{}", script.flight.topics[topic].name);
        records.extend(file::channel(id, 0, &name, "json", &[]));
    }
    for sent in &script.flight.messages {
        let id = (1..).zip(topics).find(|(_, topic)| *topic == sent.topic).map(|(id, _)| id);
        records.extend(file::message(id.expect("a channel"), sent.value.to_string().as_bytes()));
    }
    let result = script.run_check(&file::file(&records));
    assert_eq!(rules_violated(&result), ["PX-EXT-01"]);
    assert_eq!(result.findings.covered(rule("PX-EXT-03").expect("a rule")), 8);
}

/// A topic may be unsubscribed, and then subscribed again with a different id.
#[test]
fn accepts_new_subscription_ids() {
    let [mut before, mut after] = [Script::new(), Script::new()];
    before.exchange(100, 105, &[3]);
    after.exchange(105, 110, &[3]);
    after.reply(109 * PERIOD + 9, 50, 3);
    let request = u16::try_from(before.topic(REQUEST)).expect("an id");
    let mut bytes = before.flight.log().to_bytes();
    bytes.extend([2, 0, b'R']);
    bytes.extend(request.to_le_bytes());
    let mut log = after.flight.log();
    log.entries.retain(|entry| matches!(entry, Entry::Data(..)));
    for entry in &mut log.entries {
        if let Entry::Data(id, _) = entry
            && *id == request
        {
            *id = 900;
        }
    }
    log.entries.insert(0, Entry::Subscription(900, 0, "arming_check_request".to_owned()));
    // Appends the log without its header.
    bytes.extend(&log.to_bytes()[16..]);
    assert_eq!(rules_violated(&before.run_check(&bytes)), ["PX-EXT-01"]);
}

#[test]
fn accepts_a_registration_after_the_first_reply_in_the_file() {
    let mut script = Script::new();
    script.register(REGISTRATION_TIME, 3);
    script.exchange(100, 102, &[3]);
    script.request(102 * PERIOD, 102, &[3]);
    script.reply(102 * PERIOD + 5, 102, 3);
    script.reply(102 * PERIOD + 7, 102, 5);
    script.register(102 * PERIOD + 2, 5);
    script.exchange(103, 106, &[3, 5]);
    assert_eq!(script.found(), NOTHING);
}

#[test]
fn reports_impossible_ids() {
    for (id, is_wrong) in [(127, false), (128, true), (255, true)] {
        let mut script = Script::new();
        script.reply(5, 17, id);
        assert_eq!(script.found().len(), usize::from(is_wrong), "{id}");
    }
}

#[test]
fn accepts_reassigned_ids() {
    let mut script = Script::new();
    script.register(10, 3);
    script.exchange(100, 105, &[3]);
    script.unregister(105 * PERIOD - 100, 3);
    script.exchange(105, 107, &[]);
    script.register(107 * PERIOD - 100, 3);
    script.exchange(107, 112, &[3]);
    assert_eq!(script.found(), NOTHING);
    // The registration may follow the first request that includes it in the file.
    let at = script
        .flight
        .messages
        .iter()
        .rposition(|sent| sent.topic == script.topic("RegisterExtComponentReply"));
    let at = at.expect("a registration");
    script.flight.messages.swap(at, at + 1);
    assert_eq!(script.found(), NOTHING);
}

#[test]
fn ignores_an_unregistration_older_than_the_registration() {
    let mut script = Script::new();
    script.exchange(100, 102, &[3]);
    script.unregister(50 * PERIOD, 3);
    script.request(102 * PERIOD, 102, &[]);
    script.reply(102 * PERIOD + 5, 102, 3);
    script.exchange(103, 105, &[]);
    assert_eq!(script.found(), NOTHING);
    // In the same way, an old registration doesn't assign an id that was released later.
    let mut script = Script::new();
    script.exchange(100, 102, &[3]);
    script.unregister(102 * PERIOD - 50, 3);
    script.register(10, 3);
    script.request(102 * PERIOD, 102, &[]);
    script.reply(102 * PERIOD + 5, 102, 3);
    assert_eq!(script.found().len(), 1);
}

#[test]
fn accepts_a_pending_request_during_an_unregistration() {
    for (mask, ms, is_wrong) in [(&[3][..], 100, false), (&[], 105, false), (&[], 150, true)] {
        let mut script = Script::new();
        script.exchange(1, 3, &[3]);
        script.unregister(3 * PERIOD + 95, 3);
        script.request(3 * PERIOD + ms, 3, mask);
        script.reply(3 * PERIOD + ms + 5, 3, 3);
        assert_eq!(script.found().len(), usize::from(is_wrong), "{ms}");
    }
}

#[test]
fn ignores_recordings_with_only_some_requests() {
    let mut script = Script::new();
    for number in 100..130 {
        if number % 3 == 0 {
            script.request(number * PERIOD, id(number), &[3]);
        }
        script.reply(number * PERIOD + 5, id(number), 3);
    }
    assert_eq!(script.found(), NOTHING);
}

#[test]
fn ignores_recordings_with_only_some_replies() {
    for step in [2, 3] {
        let mut script = Script::new();
        for number in 100..130 {
            script.request(number * PERIOD, id(number), &[3]);
            if number % step > 0 {
                script.reply(number * PERIOD + 5, id(number), 3);
            }
        }
        assert_eq!(script.found(), NOTHING);
        assert_eq!(script.covered("PX-EXT-03"), 28);
    }
}

#[test]
fn names_the_component_that_does_not_reply() {
    let mut script = Script::new();
    script.exchange(100, 103, &[3, 5]);
    for number in 103..107 {
        script.request(number * PERIOD, id(number), &[3, 5]);
        script.reply(number * PERIOD + 5, id(number), 3);
    }
    // The flight controller no longer expects a reply from the component.
    script.exchange(107, 112, &[3]);
    let message = "request 103: registration 5 does not reply";
    assert_eq!(script.found(), [format!("PX-EXT-03 arming_check_request 3: {message}")]);
}

#[test]
fn new_and_leaving_components_need_not_reply() {
    let mut script = Script::new();
    script.exchange(100, 105, &[3, 5]);
    script.request(105 * PERIOD, 105, &[3, 5]);
    script.unregister(105 * PERIOD + 2, 5);
    script.reply(105 * PERIOD + 5, 105, 3);
    script.request(106 * PERIOD, 106, &[3, 5]);
    script.register(106 * PERIOD + 2, 5);
    script.reply(106 * PERIOD + 5, 106, 3);
    // The new component starts slowly.
    for number in 107..112 {
        script.request(number * PERIOD, id(number), &[3, 5]);
        script.reply(number * PERIOD + 5, id(number), 3);
    }
    assert_eq!(script.found(), NOTHING);
}

#[test]
fn a_restart_of_the_flight_controller_starts_over() {
    for (ms, is_wrong) in [(105 * PERIOD, true), (50, false)] {
        let mut script = Script::new();
        script.register(REGISTRATION_TIME, 3);
        script.exchange(100, 105, &[3]);
        // The ids of later requests may continue the sequence by chance.
        script.request(ms, 105, &[3]);
        script.reply(ms + 5, 105, 3);
        script.reply(ms + 6, 105, 9);
        script.request(ms + PERIOD, 106, &[3]);
        assert_eq!(script.found().len(), usize::from(is_wrong), "{ms}");
    }
}

/// Equal times don't count as going backwards.
#[test]
fn accepts_requests_with_equal_times() {
    let mut script = Script::new();
    script.request(100 * PERIOD, 100, &[3]);
    script.request(100 * PERIOD, 101, &[3]);
    script.reply(100 * PERIOD + 5, 90, 3);
    let message = "registration 3 answers request 90, but the latest request is 101";
    assert_eq!(script.found(), [format!("PX-EXT-01 arming_check_reply.request_id 1: {message}")]);
}

#[test]
fn a_reply_before_the_request_does_not_count() {
    let mut script = Script::new();
    script.exchange(100, 105, &[3]);
    script.reply(104 * PERIOD + 9, 105, 3);
    script.request(105 * PERIOD, 105, &[3]);
    script.exchange(106, 110, &[3]);
    let found = script.found();
    assert_eq!(found.len(), 2, "{found:?}");
    assert!(found[0].starts_with("PX-EXT-01") && found[1].starts_with("PX-EXT-03"), "{found:?}");
}

#[test]
fn components_may_use_instances_of_a_topic() {
    let mut script = Script::new();
    script.exchange(100, 110, &[3, 5]);
    script.reply(109 * PERIOD + 9, 50, 3);
    let mut log = script.flight.log();
    let reply = u16::try_from(script.topic(REPLY)).expect("an id");
    let last_subscription = log.entries.iter().rposition(|entry| matches!(entry, Entry::Subscription(..)));
    let second = Entry::Subscription(900, 1, "arming_check_reply".to_owned());
    log.entries.insert(last_subscription.expect("a subscription") + 1, second);
    let replies = log.entries.iter_mut().filter_map(|entry| match entry {
        Entry::Data(id, _) if *id == reply => Some(id),
        _ => None,
    });
    replies.step_by(2).for_each(|id| *id = 900);
    let result = script.run_check(&log.to_bytes());
    let rules: Vec<&str> = result.findings.groups().map(|group| group.rule.id).collect();
    assert_eq!(rules, ["PX-EXT-01"]);
    assert_eq!(result.findings.covered(rule("PX-EXT-03").expect("a rule")), 16);

    // A logger also subscribes to instances that were never published.
    let at = last_subscription.expect("a subscription") + 1;
    log.entries.insert(at, Entry::Subscription(901, 1, "arming_check_request".to_owned()));
    assert_eq!(reported(&script.run_check(&log.to_bytes())).len(), 1);

    // If there are two requesters, it is unknown which of them a reply answers.
    let request = u16::try_from(script.topic(REQUEST)).expect("an id");
    let of_another = log.entries.iter().find_map(|entry| match entry {
        Entry::Data(id, payload) if *id == request => Some(Entry::Data(901, payload.clone())),
        _ => None,
    });
    log.entries.insert(at + 2, of_another.expect("a request"));
    let result = script.run_check(&log.to_bytes());
    assert_eq!(reported(&result), NOTHING);
    assert_eq!(result.findings.covered(rule("PX-EXT-01").expect("a rule")), 0);
}

#[test]
fn does_not_check_indistinguishable_vehicles() {
    let mut script = Script::new();
    script.exchange(100, 104, &[3]);
    script.reply(103 * PERIOD + 9, 50, 3);
    script.exchange(104, 106, &[3]);
    let mut lines = script.flight.rosbridge().lines;
    assert_eq!(reported(&script.run_check(lines.join("\n").as_bytes())).len(), 1);
    for topic in ["arming_check_request", "arming_check_reply"] {
        let mut lines = lines.clone();
        let of_another = lines.iter().find(|line| line.contains(topic)).expect("a line");
        lines.insert(0, of_another.replace("/fmu/", "/second/fmu/"));
        assert_eq!(reported(&script.run_check(lines.join("\n").as_bytes())), NOTHING, "{topic}");
    }
    lines.insert(0, r#"{"op":"publish","topic":"/second/wind","msg":{"timestamp":1}}"#.to_owned());
    assert_eq!(reported(&script.run_check(lines.join("\n").as_bytes())).len(), 1);
}

#[test]
fn ignores_duplicate_messages() {
    let mut script = Script::new();
    script.exchange(100, 110, &[3]);
    let messages = std::mem::take(&mut script.flight.messages);
    script.flight.messages = messages.into_iter().flat_map(|sent| [sent.clone(), sent]).collect();
    assert_eq!(script.found(), NOTHING);
    assert_eq!(script.covered("PX-EXT-03"), 8);
}

#[test]
fn stores_a_bounded_number_of_replies() {
    let mut script = Script::new();
    script.exchange(100, 102, &[3]);
    for _ in 0..100 {
        script.reply(101 * PERIOD + 9, 50, 9);
    }
    script.exchange(102, 104, &[3]);
    let message = "registration 9 answers request 50, but the latest request is 101";
    assert_eq!(script.found(), [format!("PX-EXT-01 arming_check_reply.request_id 64: {message}")]);
}

const TALK: [(&str, &str); 4] = [
    ("ArmingCheckRequest", "uint64 timestamp\nuint8 request_id\n"),
    (
        "ArmingCheckReply",
        "uint64 timestamp\nuint8 request_id\nuint8 registration_id\nbool can_arm_and_run\nuint8 num_events\n",
    ),
    ("RegisterExtComponentReply", "uint64 timestamp\nbool success\nint8 arming_check_id\n"),
    ("UnregisterExtComponent", "uint64 timestamp\nint8 arming_check_id\n"),
];

#[test]
fn without_masks_uses_registrations() {
    let folder = TempDir::new().expect("a folder");
    for (name, text) in TALK {
        fs::write(folder.path().join(format!("{name}.msg")), text).expect("a file");
    }
    let definitions = Definitions::load(folder.path()).expect("definitions");
    let flight = Flight::new(&definitions);
    let mut script = Script::with_flight(&flight);
    script.register(10, 3);
    script.exchange(100, 105, &[3, 5]);
    script.request(105 * PERIOD, 105, &[]);
    script.reply(105 * PERIOD + 5, 105, 5);
    script.exchange(106, 109, &[3]);
    script.unregister(109 * PERIOD - 5, 3);
    script.exchange(109, 114, &[]);
    let message = "request 105: registration 3 does not reply";
    let expected = [format!("PX-EXT-03 arming_check_request 1: {message}")];
    assert_eq!(script.found(), expected, "it is unknown whether 5 was registered");
    // Requests 100 to 107. The component was unregistered before request 109, so it need not answer request 108.
    assert_eq!(script.covered("PX-EXT-03"), 8);
    script.reply(113 * PERIOD + 5, 113, 3);
    assert_eq!(script.found().len(), 1, "the component may have been registered again");
    script.exchange(114, 116, &[]);
    assert_eq!(script.found().len(), 1);
    script.exchange(116, 117, &[]);
    assert_eq!(script.found().len(), 2);
}

#[test]
fn without_masks_further_replies_imply_a_registration() {
    let folder = TempDir::new().expect("a folder");
    for (name, text) in TALK {
        fs::write(folder.path().join(format!("{name}.msg")), text).expect("a file");
    }
    let definitions = Definitions::load(folder.path()).expect("definitions");
    let flight = Flight::new(&definitions);
    let left = |after: &dyn Fn(&mut Script<'_>)| {
        let mut script = Script::with_flight(&flight);
        script.register(10, 3);
        script.exchange(100, 105, &[3]);
        script.unregister(105 * PERIOD - 100, 3);
        after(&mut script);
        script.exchange(110, 116, &[]);
        script.found().iter().filter(|message| message.starts_with("PX-EXT-02")).count()
    };
    let once = left(&|script| {
        script.exchange(105, 106, &[3]);
        script.exchange(106, 110, &[]);
    });
    assert_eq!(once, 1);
    let twice = left(&|script| {
        script.exchange(105, 106, &[3]);
        script.reply(105 * PERIOD + 9, 105, 3);
        script.exchange(106, 110, &[]);
    });
    assert_eq!(twice, 1, "both replies answer the same request");
    assert_eq!(left(&|script| script.exchange(105, 110, &[3])), 0, "the component continues");
    let returned = left(&|script| {
        script.exchange(105, 107, &[]);
        script.register(107 * PERIOD - 100, 3);
        script.exchange(107, 108, &[3]);
        script.exchange(108, 110, &[]);
    });
    assert_eq!(returned, 0, "the component registered again");
    // The registration follows the first reply.
    let registered = left(&|script| {
        script.exchange(105, 106, &[3]);
        script.register(105 * PERIOD - 50, 3);
        script.exchange(106, 110, &[]);
    });
    assert_eq!(registered, 0);
    // One of the requests in between is missing.
    let missing = left(&|script| {
        script.exchange(105, 106, &[3]);
        script.exchange(107, 110, &[]);
    });
    assert_eq!(missing, 0);
    // Messages of different topics have no defined order. The component unregistered, and then registered again.
    let mut script = Script::with_flight(&flight);
    script.register(10, 3);
    script.exchange(100, 105, &[3]);
    script.register(105 * PERIOD - 100, 3);
    script.unregister(105 * PERIOD - 105, 3);
    script.exchange(105, 106, &[3]);
    script.exchange(106, 112, &[]);
    assert_eq!(script.found(), NOTHING);
}

#[test]
fn does_not_check_fields_that_a_release_lacks() {
    let folder = TempDir::new().expect("a folder");
    for (name, text) in TALK {
        let text = text.replace("uint8 request_id\n", "").replace("bool success\n", "");
        let text = text.replace("uint8 num_events\n", "");
        fs::write(folder.path().join(format!("{name}.msg")), text).expect("a file");
    }
    let definitions = Definitions::load(folder.path()).expect("definitions");
    let flight = Flight::new(&definitions);
    let mut script = Script::with_flight(&flight);
    script.register(10, 3);
    script.exchange(100, 105, &[3]);
    script.reply(105 * PERIOD, 9, 200);
    assert_eq!(script.found(), NOTHING);
    for id in ["PX-EXT-01", "PX-EXT-02", "PX-EXT-03", "PX-EXT-04", "PX-EXT-05"] {
        assert_eq!(script.covered(id), 0, "{id}");
    }
}

/// The findings for a reply with these values and event ids.
fn reported_for(can_arm: bool, in_use: u8, ids: [u32; 5]) -> (Vec<String>, u64) {
    let mut script = Script::new();
    script.reply(5, 17, 3);
    let reply = &mut script.flight.messages[0].value;
    reply["can_arm_and_run"] = can_arm.into();
    reply["num_events"] = in_use.into();
    for (at, id) in ids.into_iter().enumerate() {
        reply["events"][at]["id"] = id.into();
    }
    (script.found(), script.covered("PX-EXT-04"))
}

#[test]
fn events_in_use_have_an_id() {
    assert_eq!(reported_for(true, 0, [0; 5]), (vec![], 0));
    assert_eq!(reported_for(true, 2, [1, 2, 0, 0, 0]), (vec![], 2));
    assert_eq!(reported_for(false, 5, [1; 5]), (vec![], 5));
    let message = "PX-EXT-04 arming_check_reply.events 1: events[1].id: an entry among the first 2 has no id";
    assert_eq!(reported_for(true, 2, [1, 0, 0, 0, 0]).0, [message]);
    assert!(
        reported_for(true, 5, [0; 5]).0[0].starts_with("PX-EXT-04 arming_check_reply.events 5: events[0].id")
    );
}

#[test]
fn refusals_have_a_reason() {
    let message = "PX-EXT-05 arming_check_reply.num_events 1: can_arm_and_run is false, \
                   but no event gives the reason";
    assert_eq!(reported_for(false, 0, [1; 5]).0, [message]);
    assert_eq!(reported_for(false, 1, [1; 5]).0, NOTHING);
    assert_eq!(reported_for(true, 0, [1; 5]).0, NOTHING);
}

#[test]
fn counts_flags_that_no_mode_requires() {
    let flags = |fields: &Value| {
        let mut script = Script::new();
        for round in 1..=5 {
            script.add("FailsafeFlags", round * 20, fields);
        }
        script
    };
    let script = flags(&json!({
        "mode_req_attitude": 0, "attitude_invalid": true,
        "mode_req_local_alt": 0, "local_altitude_invalid": false,
        "mode_req_mission": 2, "auto_mission_missing": true,
        "mode_req_wind_and_flight_time_compliance": 0, "wind_limit_exceeded": true,
        "flight_time_limit_exceeded": true, "gcs_connection_lost": true,
    }));
    let shown = rule("PX-FSF-03").expect("a rule");
    for bytes in [script.flight.log().to_bytes(), script.flight.lines().to_bytes()] {
        let result = script.run_check(&bytes);
        let found: Vec<(String, u64)> =
            result.findings.groups().map(|group| (group.subject.clone(), group.count)).collect();
        let example = |flag: &str| {
            let name = if bytes.starts_with(b"{") { "px4/FailsafeFlags" } else { "failsafe_flags" };
            (format!("{name}.{flag}"), 5)
        };
        let expected = ["attitude_invalid", "flight_time_limit_exceeded", "wind_limit_exceeded"].map(example);
        assert_eq!(found, expected);
        assert_eq!(result.findings.verdict(shown), Verdict::Shown);
        let group = result.findings.groups_of(shown).next().expect("a group");
        assert_eq!(
            group.examples[0].1.to_string(),
            "set, but no mode has a matching requirement: mode_req_attitude is 0"
        );
    }
    // Twelve flags of this release have a requirement.
    let script = flags(&json!({ "attitude_invalid": true, "mode_req_attitude": 1 }));
    assert_eq!(script.covered("PX-FSF-03"), 12 * 5);
}

#[test]
fn finds_replies_that_change() {
    for (request, repeated) in [(105, 1), (104, 1), (103, 0)] {
        let mut script = Script::new();
        script.exchange(100, 106, &[3, 5]);
        script.refusal(105 * PERIOD + 9, request, 3);
        script.exchange(106, 109, &[3, 5]);
        assert_eq!(script.repeated(), repeated, "{request}");
    }
}

#[test]
fn accepts_replies_that_were_recorded_twice() {
    let mut script = Script::new();
    script.exchange(100, 106, &[3]);
    script.reply(105 * PERIOD + 5, 105, 3);
    // The flight controller sets the time when it receives a reply.
    script.reply(105 * PERIOD + 9, 105, 3);
    script.exchange(106, 109, &[3]);
    assert_eq!(script.repeated(), 0);
}

#[test]
fn accepts_replies_to_later_requests_with_the_same_id() {
    let mut script = Script::new();
    script.exchange(100, 106, &[3]);
    // The next 255 requests are missing, with or without their replies.
    script.refusal((105 + 256) * PERIOD + 5, 105, 3);
    assert_eq!(script.repeated(), 0);
    let mut script = Script::new();
    script.exchange(100, 106, &[3]);
    script.reply(0, 107, 3);
    script.refusal(0, 105, 3);
    assert_eq!(script.repeated(), 0);
}

#[test]
fn accepts_replies_of_a_new_component_with_the_same_registration() {
    let mut script = Script::new();
    script.exchange(100, 106, &[3]);
    script.register(105 * PERIOD + 20, 3);
    script.refusal(105 * PERIOD + 30, 105, 3);
    assert_eq!(script.repeated(), 0);
}

const REGISTRATION_REQUEST: &str = "RegisterExtComponentRequest";
const REGISTRATION_REPLY: &str = "RegisterExtComponentReply";

#[test]
fn finds_replies_with_other_names() {
    let mut script = Script::new();
    script.name(REGISTRATION_REQUEST, 10, 7, "Landing");
    script.name(REGISTRATION_REPLY, 20, 7, "Land");
    script.name(REGISTRATION_REPLY, 30, 7, "Lan");
    let message = "the reply to request 7 has the name \"Land\", but the request has \"Landing\"";
    assert_eq!(script.found(), [format!("PX-EXT-07 register_ext_component_reply.name 1: {message}")]);
}

#[test]
fn accepts_replies_whose_request_may_be_missing() {
    // Two components chose the same id, and the capture lacks the request of one of them.
    for replies in [["Landing", "Survey"], ["Survey", "Landing"]] {
        let mut script = Script::new();
        script.name(REGISTRATION_REQUEST, 10, 7, "Landing");
        for name in replies {
            script.name(REGISTRATION_REPLY, 20, 7, name);
        }
        assert_eq!(script.found(), NOTHING);
    }
    // The request follows its reply in the file, or is unknown.
    let mut script = Script::new();
    script.name(REGISTRATION_REQUEST, 10, 7, "Landing");
    script.name(REGISTRATION_REPLY, 20, 7, "Survey");
    script.name(REGISTRATION_REPLY, 20, 8, "Survey");
    script.name(REGISTRATION_REQUEST, 20, 7, "Survey");
    assert_eq!(script.found(), NOTHING);
}
