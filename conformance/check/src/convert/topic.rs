//! The conversion of a topic's messages, and its part of the report.

use std::rc::Rc;

use uavspec_dynamic::DynamicMessage;

use super::Settings;
use super::plan::{Converted, Plan, Treatment};
use super::report::{Action, Loss, TopicReport};

/// A topic of a capture.
pub(super) struct Topic<'p> {
    pub(super) report: TopicReport,
    /// The conversion of the messages, if they are converted.
    pub(super) converted: Option<Rc<Converted<'p>>>,
    /// The number of messages that contain the data of each loss.
    losses: Vec<u64>,
}

impl<'p> Topic<'p> {
    /// Creates a topic. `from` is the release of its messages.
    pub(super) fn new(
        name: &str,
        (from, treatment): (Option<String>, Treatment<'p>),
        plan: &Plan,
        settings: Settings,
    ) -> Self {
        let mut report =
            TopicReport { topic: name.to_owned(), action: Action::Copied, ..TopicReport::default() };
        let (mut converted, mut losses) = (None, Vec::new());
        match treatment {
            Treatment::Convert(found) => {
                losses = vec![0; found.conversion.losses.len()];
                report.renamed = plan.renamed(name, &found);
                (report.from, report.action) = (from, Action::Converted);
                converted = Some(found);
            }
            Treatment::Copy => {}
            Treatment::LeaveOut(reason) => {
                report.reason = Some(reason);
                if !settings.keeps_unconverted {
                    report.action = Action::LeftOut;
                }
            }
        }
        Self { report, converted, losses }
    }

    /// Creates a topic that is left out.
    pub(super) fn left_out(name: &str, reason: String) -> Self {
        let report = TopicReport { topic: name.to_owned(), reason: Some(reason), ..TopicReport::default() };
        Self { report, converted: None, losses: Vec::new() }
    }

    /// The name in the output.
    pub(super) fn output_name(&self) -> &str {
        self.report.renamed.as_deref().unwrap_or(&self.report.topic)
    }

    /// The name of the messages' type in the output, if it differs.
    pub(super) fn renamed_type(&self, ty: &str, plan: &Plan) -> Option<String> {
        self.converted.as_ref().and_then(|converted| plan.renamed_type(ty, &converted.conversion))
    }

    /// Leaves out the messages.
    pub(super) fn leave_out(&mut self, reason: String) {
        self.converted = None;
        (self.report.renamed, self.report.from) = (None, None);
        (self.report.reason, self.report.action) = (Some(reason), Action::LeftOut);
    }

    /// Converts a message by calling `work` with the conversion and the loss counters. Returns `None` if the message
    /// can't be converted.
    pub(super) fn convert<T>(
        &mut self,
        work: impl FnOnce(&Converted<'p>, &mut [u64]) -> Result<T, String>,
    ) -> Option<T> {
        let converted = self.converted.as_ref()?;
        match work(converted, &mut self.losses) {
            Ok(message) => Some(message),
            Err(error) => {
                self.unreadable(error);
                None
            }
        }
    }

    /// Counts a message that is left out, because it can't be read.
    pub(super) fn unreadable(&mut self, error: String) {
        self.report.unreadable += 1;
        self.report.error.get_or_insert(error);
    }

    /// Returns the topic's part of the report.
    pub(super) fn finish(self) -> TopicReport {
        let Self { mut report, converted, losses } = self;
        if let Some(converted) = converted {
            let counted = converted.conversion.losses.iter().zip(losses).enumerate();
            let losses = counted.map(|(at, (loss, count))| Loss {
                text: loss.text.clone(),
                messages: converted.converter.is_counted(at).then_some(count),
            });
            report.losses = losses.collect();
            let fields = converted.converter.target().fields();
            let unchecked = converted.conversion.unchecked.iter().filter_map(|at| fields.get(*at));
            report.unchecked = unchecked.map(|field| field.name.to_string()).collect();
        }
        report
    }
}

impl<'p> Converted<'p> {
    /// Converts a message, and counts the losses.
    pub(super) fn message(
        &self,
        message: &DynamicMessage<'_>,
        losses: &mut [u64],
    ) -> Result<DynamicMessage<'p>, String> {
        if self.converter.counts_losses() {
            self.converter.count_losses(message, losses);
        }
        self.converter.convert(message).map_err(|error| error.to_string())
    }
}
