//! Reads PX4 logs for a conversion.

use std::io::Read;

use uavspec_capture::input::UpToError;
use uavspec_capture::ulog::{Event, Item, Log, LogProblem, Problem, Reader, Record};
use uavspec_dynamic::{MessageType, ULOG_PACKAGE};
use uavspec_model::Extent;
use uavspec_px4::comparison::{Comparison, compare};
use uavspec_rules::definitions::Definitions;

use super::Error;
use super::plan::{Converters, Plan, Treatment};
use super::report::Problems;
use super::topic::Topic;
use crate::StatedType;

/// Receives the parts of a log.
pub(super) trait Sink<'p> {
    /// True if the bytes of all other parts are copied, even if their content is unknown or invalid.
    const COPIES_BYTES: bool;

    /// Receives a message of a topic.
    fn record(&mut self, record: &Record<'_>, bytes: &[u8]) -> Result<(), Error>;

    /// Receives another part, which `log` has already processed.
    fn part(&mut self, item: &Item<'_>, log: &Log) -> Result<(), Error>;

    /// The topic that the id of a subscription denotes.
    fn topic(&mut self, id: u16) -> Option<&mut Topic<'p>>;

    /// The problems so far.
    fn problems(&mut self) -> &mut Problems;
}

/// The indices of topics, by the id of their subscription.
#[derive(Default)]
pub(super) struct Routes(Vec<Option<usize>>);

impl Routes {
    pub(super) fn get(&self, id: u16) -> Option<usize> {
        self.0.get(usize::from(id)).copied().flatten()
    }

    pub(super) fn set(&mut self, id: u16, topic: Option<usize>) {
        let slot = usize::from(id);
        if slot >= self.0.len() {
            self.0.resize(slot + 1, None);
        }
        self.0[slot] = topic;
    }
}

/// Reads a log up to its end, or up to the first unreadable byte.
pub(super) fn read<'p>(input: impl Read, sink: &mut impl Sink<'p>) -> Result<Log, Error> {
    let mut input = UpToError::new(input);
    let (mut reader, mut log) = (Reader::new(&mut input), Log::default());
    while let Ok(Some(item)) = reader.next() {
        take(&item, &mut log, sink)?;
    }
    let position = reader.position();
    sink.problems().add_unreadable_rest(position, input.error.as_ref());
    let mut found = Vec::new();
    log.finish(&mut |offset, problem| found.push((offset, problem)));
    for (offset, problem) in found {
        report(offset, &problem, sink);
    }
    Ok(log)
}

fn take<'p, S: Sink<'p>>(item: &Item<'_>, log: &mut Log, sink: &mut S) -> Result<(), Error> {
    let mut found = Vec::new();
    let record = log.take(item, &mut |offset, problem| found.push((offset, problem)));
    if let Some(record) = record {
        return sink.record(&record, item.bytes);
    }
    for (offset, problem) in found {
        report(offset, &problem, sink);
    }
    match &item.event {
        Event::Problem(problem) => {
            if loses_data(problem, S::COPIES_BYTES) {
                sink.problems().add(format!("byte {}: {problem}", item.offset));
            }
        }
        // Data that can't be read was reported above.
        Event::Data { .. } => {}
        _ => sink.part(item, log)?,
    }
    Ok(())
}

/// True if a problem means that data is missing in the output, or may be misread. `is_copied` is true if the bytes of messages
/// are copied.
fn loses_data(problem: &Problem, is_copied: bool) -> bool {
    match problem {
        Problem::NewerVersion(_) | Problem::FlagBitsNotFirst => true,
        Problem::UnknownKind(_) => !is_copied,
        _ if is_copied => problem.extent() != Extent::Whole,
        _ => !problem.is_harmless(),
    }
}

/// Counts data that can't be read, and reports formats that can't be used.
fn report<'p>(offset: u64, problem: &LogProblem, sink: &mut impl Sink<'p>) {
    match problem {
        LogProblem::DataSize { id, .. }
        | LogProblem::MissingFormat { id }
        | LogProblem::UnusableFormat { id } => {
            if let Some(topic) = sink.topic(*id) {
                topic.report.messages += 1;
                topic.unreadable(problem.to_string());
            }
        }
        LogProblem::Resubscribed { .. }
        | LogProblem::Redefined { .. }
        | LogProblem::LateSubscription { .. }
        | LogProblem::LateFormat { .. }
        | LogProblem::NotSubscribed { .. } => {}
        _ => sink.problems().add(format!("byte {offset}: {problem}")),
    }
}

/// The usable format with this name.
pub(super) fn format<'l>(name: &str, log: &'l Log) -> Option<MessageType<'l>> {
    log.types().find(ULOG_PACKAGE, name).filter(|format| format.size().is_some())
}

/// The treatment of the topic with this name and format. Also returns the release of its messages.
pub(super) fn treatment<'p>(
    plan: &'p Plan,
    name: &str,
    format: Option<MessageType<'_>>,
    converters: &mut Converters<'p>,
) -> (Option<String>, Treatment<'p>) {
    let definitions = plan.source();
    let id = definitions.message_of_logged_topic(name).filter(|id| plan.concerns(*id));
    let release = id.and_then(|id| definitions.release_of(id)).map(|release| release.label.clone());
    let stated = |target: &Definitions| {
        let (id, format) = target.message_of_logged_topic(name).zip(format)?;
        let is_same = compare(format, target.types().get(id)) == Comparison::Equal;
        Some(if is_same { StatedType::Same } else { StatedType::Other })
    };
    let treatment = match (format, id) {
        (_, None) => plan.undefined(stated),
        (Some(format), Some(id)) if compare(format, definitions.types().get(id)) != Comparison::Equal => {
            plan.differs(id)
        }
        (_, Some(id)) => plan.treatment(id, name, converters),
    };
    (release, treatment)
}
