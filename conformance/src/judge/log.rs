//! Judges logs of PX4.

use std::collections::BTreeMap;
use std::io::Read;

use uavspec_codegen::dynamic::FormatProblem;
use uavspec_codegen::schema::MessageId;

use super::{Course, Judgement, Source, timestamp_offset};
use crate::comparison::{Comparison, compare};
use crate::definitions::Definitions;
use crate::detail::Detail;
use crate::finding::Findings;
use crate::plan::Plan;
use crate::record::{Channel, Extent, Message, Place};
use crate::rule::rule;
use crate::source::ulog::{Event, Item, Log, LogProblem, Problem, Reader, Record};

/// What a log says of itself.
#[derive(Debug)]
pub struct LogSource {
    /// What it says of the firmware, such as its version.
    pub firmware: Option<String>,
    /// How many dropouts it tells of.
    pub dropouts: u64,
    /// The formats of its topics, compared with the definitions, by name.
    pub formats: Vec<(String, Comparison)>,
}

/// Judges a log of PX4, as far as it can be read.
pub fn judge_ulog(input: impl Read, definitions: &Definitions) -> Judgement {
    let mut judge = LogJudge::new(definitions);
    let mut reader = Reader::new(input);
    let mut log = Log::default();
    loop {
        let item = match reader.next() {
            Ok(Some(item)) => item,
            Ok(None) => break,
            // What was judged until then stays judged.
            Err(error) => {
                judge.course.unreadable(Place::Byte(reader.position()), &error);
                break;
            }
        };
        judge.item(&item);
        let topic = match item.event {
            Event::Subscription { id, .. } => Some(id),
            _ => None,
        };
        let record = log.take(&item, &mut |offset, problem| judge.tell(offset, &problem));
        if let Some(record) = record {
            judge.record(&record, item.offset);
        }
        if let Some(subscription) = topic.and_then(|id| log.subscription(id)) {
            let (id, topic, multi_id) = (subscription.id, subscription.topic.clone(), subscription.multi_id);
            judge.open(id, &topic, multi_id, item.offset);
        }
    }
    log.finish(&mut |offset, problem| judge.tell(offset, &problem));
    judge.finish(&log, reader.position())
}

/// A topic of the log and its state.
struct Open {
    index: usize,
    topic: String,
    multi_id: u8,
    offset: u64,
    definition: Option<MessageId>,
    /// Made with the first message.
    plan: Option<Plan>,
    /// Where the payload has its `timestamp`.
    timestamp: Option<usize>,
    messages: u64,
}

struct LogJudge<'d> {
    course: Course<'d>,
    /// By the id of the data.
    open: Vec<Option<Box<Open>>>,
    firmware: Option<String>,
    dropouts: u64,
}

impl<'d> LogJudge<'d> {
    fn new(definitions: &'d Definitions) -> Self {
        Self { course: Course::new(definitions), open: Vec::new(), firmware: None, dropouts: 0 }
    }

    fn item(&mut self, item: &Item<'_>) {
        let place = Place::Byte(item.offset);
        match &item.event {
            Event::Information { key: "ver_sw_release" | "ver_sw_branch" | "sys_name", value, ty } => {
                self.information(ty, value);
            }
            Event::Dropout { milliseconds } => {
                self.dropouts += 1;
                self.course.dropout(*milliseconds, place);
            }
            Event::Data { .. } => self.course.records += 1,
            // Logs of the first version have none.
            Event::Problem(Problem::NoFlagBits { version: 0 }) => {}
            Event::Problem(problem) => self.course.damage(place, problem.to_string(), problem.extent()),
            _ => {}
        }
    }

    fn open(&mut self, id: u16, topic: &str, multi_id: u8, offset: u64) {
        // Who subscribes again and again asks for no more room.
        let slot = usize::from(id);
        if slot >= self.open.len() {
            self.open.resize_with(slot + 1, || None);
        }
        let before = self.open[slot].take();
        let index = before.as_ref().map_or_else(|| self.course.number_channel(), |before| before.index);
        let open = Open {
            index,
            topic: topic.to_owned(),
            multi_id,
            offset,
            definition: self.course.definitions.message_of_topic(topic),
            plan: None,
            timestamp: None,
            messages: 0,
        };
        self.course.opened(&open.channel());
        self.open[slot] = Some(Box::new(open));
        if let Some(before) = before {
            before.close(&mut self.course.findings);
        }
    }

    fn record(&mut self, record: &Record<'_>, offset: u64) {
        let Some(Some(open)) = self.open.get_mut(usize::from(record.subscription.id)) else { return };
        let place = Place::Byte(offset);
        let plan = match &mut open.plan {
            Some(plan) => plan,
            empty => {
                open.timestamp = timestamp_offset(record.of);
                if let Some(rule) = rule("PX-FMT-03") {
                    self.course.findings.exercise(rule, 1);
                    if open.timestamp.is_none() {
                        let text = || Detail::new("its format has no `uint64_t timestamp`");
                        self.course.findings.report(rule, &open.topic, place, None, text);
                    }
                }
                empty.insert(Plan::new(
                    record.of,
                    open.definition,
                    &self.course.definitions.schema,
                    &open.topic,
                ))
            }
        };
        plan.check(record.payload, place, &mut self.course.findings);
        open.messages += 1;
        let bytes = open.timestamp.and_then(|at| record.payload.get(at..at + 8));
        let timestamp = bytes.and_then(|bytes| Some(u64::from_le_bytes(bytes.try_into().ok()?)));
        let values = self.course.wants_values(open.index).then(|| record.of.view_uorb(record.payload).ok());
        let message = Message { timestamp, values: values.flatten(), place };
        self.course.message(&open.channel(), &message);
    }

    /// What is wrong with formats, subscriptions and sizes: a rule, where one is about that.
    fn tell(&mut self, offset: u64, problem: &LogProblem) {
        let topic = |id: &u16| self.opened(*id).map_or_else(|| format!("id {id}"), |open| open.topic.clone());
        let (id, subject) = match problem {
            LogProblem::DataSize { id, .. } => ("PX-DATA-01", topic(id)),
            LogProblem::UnknownId { id } | LogProblem::Unsubscribed { id } => ("PX-DATA-02", topic(id)),
            LogProblem::Format { name, problem: FormatProblem::UnknownType { .. } } => {
                ("PX-FMT-02", name.clone())
            }
            _ => return self.course.damage(Place::Byte(offset), problem.to_string(), Extent::Whole),
        };
        if let Some(rule) = rule(id) {
            let detail = || Detail::new(problem.to_string());
            self.course.findings.report(rule, &subject, Place::Byte(offset), None, detail);
        }
    }

    fn finish(mut self, log: &Log, bytes: u64) -> Judgement {
        for open in std::mem::take(&mut self.open).into_iter().flatten() {
            open.close(&mut self.course.findings);
        }
        for id in ["PX-DATA-01", "PX-DATA-02"] {
            if let Some(rule) = rule(id) {
                self.course.findings.exercise(rule, self.course.records);
            }
        }
        let formats = formats(log, self.course.definitions, &mut self.course.findings);
        let source = LogSource { firmware: self.firmware, dropouts: self.dropouts, formats };
        self.course.finish(bytes, Source::Log(source))
    }

    fn opened(&self, id: u16) -> Option<&Open> {
        self.open.get(usize::from(id))?.as_deref()
    }

    fn information(&mut self, ty: &str, value: &[u8]) {
        let text = match <[u8; 4]>::try_from(value) {
            // The version as a number: major, minor and patch level, and the type of the release.
            Ok(bytes) if ty == "uint32_t" => {
                let [_, patch, minor, major] = bytes;
                format!("v{major}.{minor}.{patch}")
            }
            _ if ty.starts_with("char[") => String::from_utf8_lossy(value).into_owned(),
            _ => return,
        };
        self.firmware = Some(match self.firmware.take() {
            Some(known) => format!("{known} {text}"),
            None => text,
        });
    }
}

impl Open {
    fn channel(&self) -> Channel<'_> {
        Channel {
            index: self.index,
            topic: &self.topic,
            multi_id: Some(self.multi_id),
            definition: self.definition,
            place: Place::Byte(self.offset),
        }
    }

    fn close(self, findings: &mut Findings) {
        if let Some(plan) = self.plan {
            plan.exercise(self.messages, findings);
        }
    }
}

/// The formats of all subscribed topics, compared with the definitions.
fn formats(log: &Log, definitions: &Definitions, findings: &mut Findings) -> Vec<(String, Comparison)> {
    let types = definitions.types();
    let mut opened: BTreeMap<&str, u64> = BTreeMap::new();
    for subscription in log.subscriptions() {
        opened.entry(&subscription.topic).or_insert(subscription.offset);
    }
    let mut compared: BTreeMap<String, Comparison> = BTreeMap::new();
    for of in log.types().iter() {
        if let Some(rule) = rule("PX-FMT-02") {
            findings.exercise(rule, 1);
        }
        let Some(offset) = opened.get(of.name()) else { continue };
        let comparison = match definitions.message_of_topic(of.name()) {
            None => Comparison::Undefined,
            Some(id) => compare(of, types.get(id)),
        };
        if let (Some(rule), false) = (rule("PX-FMT-01"), comparison == Comparison::Undefined) {
            findings.exercise(rule, 1);
            if let Comparison::Differs(differences) = &comparison {
                let place = Place::Byte(*offset);
                findings.report(rule, of.name(), place, None, || Detail::new(differences.to_string()));
            }
        }
        compared.insert(of.name().to_owned(), comparison);
    }
    compared.into_iter().collect()
}
