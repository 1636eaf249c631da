//! Operations that continue after the response to their request.

use serde_json::Value;
use uavspec_types::flockwave::json::{
    Notification, Percentage, Progress, ReceiptId, async_resp, async_st, async_timeout,
};

/// The timeout of an operation without a result, in simulated seconds.
const ANSWER_TIMEOUT: f64 = 5.0;

/// The percentages at which the client receives progress notifications.
const MILESTONES: [u8; 3] = [25, 50, 75];

/// The percentage at which an operation waits for the client.
const SUSPEND_AT: u8 = 50;

/// An operation.
#[derive(Debug)]
pub(super) struct Operation {
    pub(super) receipt: String,
    /// The way in which the operation ends: with a result, or without a message.
    ending: Ending,
    /// The duration in simulated seconds.
    length: f64,
    passed: f64,
    /// The last percentage sent to the client.
    last_reported: u8,
    /// True if the operation waits for the client at the halfway point.
    is_suspending: bool,
    is_suspended: bool,
    is_cancelled: bool,
}

#[derive(Debug)]
enum Ending {
    Result(Value),
    Silence,
}

/// An event of an operation.
#[derive(Debug, PartialEq)]
pub(super) enum Report {
    /// The progress in percent.
    Progress(u8),
    /// The operation waits for the client, at this percentage.
    Suspension(u8),
    /// The operation has ended with this result.
    Result(Value),
    /// The operation was cancelled.
    Cancellation,
    /// The operation has timed out.
    Timeout,
}

impl Report {
    /// True if this is the last report.
    pub(super) fn is_last(&self) -> bool {
        !matches!(self, Self::Progress(_) | Self::Suspension(_))
    }

    /// The notification about the operation with this receipt.
    pub(super) fn into_notification(self, receipt: &str) -> Notification {
        let id = ReceiptId::from(receipt);
        let progress = |percentage: u8, message: Option<&str>| Progress {
            percentage: Some(Some(Percentage(percentage.into()))),
            message: message.map(|text| Some(text.to_owned())),
            object: None,
        };
        match self {
            Self::Progress(percentage) => {
                async_st::Notification { id, progress: progress(percentage, None), suspended: None }.into()
            }
            Self::Suspension(percentage) => {
                let progress = progress(percentage, Some("turn the UAV, then resume"));
                async_st::Notification { id, progress, suspended: Some(true) }.into()
            }
            Self::Result(result) => async_resp::Notification { id, result: Some(result), error: None }.into(),
            Self::Cancellation => {
                let error = Some("cancelled by the client".to_owned());
                async_resp::Notification { id, result: None, error }.into()
            }
            Self::Timeout => async_timeout::Notification { ids: vec![id] }.into(),
        }
    }
}

impl Operation {
    /// An operation that takes this many seconds and returns a result.
    pub(super) fn lasting(receipt: String, seconds: f64, result: Value) -> Self {
        Self {
            receipt,
            ending: Ending::Result(result),
            length: seconds,
            passed: 0.0,
            last_reported: 0,
            is_suspending: false,
            is_suspended: false,
            is_cancelled: false,
        }
    }

    /// An operation that waits for the client at the halfway point.
    pub(super) fn suspending(receipt: String, seconds: f64, result: Value) -> Self {
        Self { is_suspending: true, ..Self::lasting(receipt, seconds, result) }
    }

    /// An operation that times out.
    pub(super) fn unanswered(receipt: String) -> Self {
        Self { ending: Ending::Silence, ..Self::lasting(receipt, ANSWER_TIMEOUT, Value::Null) }
    }

    /// Cancels the operation, which still reports its end.
    pub(super) fn cancel(&mut self) {
        self.is_cancelled = true;
    }

    /// Resumes a suspended operation. Returns true if it was suspended.
    pub(super) fn resume(&mut self) -> bool {
        std::mem::take(&mut self.is_suspended)
    }

    /// Resumes a suspended operation without a request from the client.
    pub(super) fn overrun(&mut self) {
        self.is_suspended = false;
    }

    /// True if the operation waits for the client.
    pub(super) fn is_suspended(&self) -> bool {
        self.is_suspended
    }

    /// Advances the time. Returns an event to report, if there is one.
    pub(super) fn advance(&mut self, seconds: f64) -> Option<Report> {
        if self.is_cancelled {
            return Some(Report::Cancellation);
        }
        if self.is_suspended {
            return None;
        }
        self.passed += seconds;
        if let Ending::Silence = self.ending {
            return (self.passed >= self.length).then_some(Report::Timeout);
        }
        let reached = MILESTONES.into_iter().find(|milestone| {
            *milestone > self.last_reported && self.passed >= self.length * f64::from(*milestone) / 100.0
        });
        match (reached, &self.ending) {
            (Some(milestone), _) => {
                self.last_reported = milestone;
                self.is_suspended = self.is_suspending && milestone == SUSPEND_AT;
                Some(if self.is_suspended {
                    Report::Suspension(milestone)
                } else {
                    Report::Progress(milestone)
                })
            }
            (None, Ending::Result(result)) if self.passed >= self.length => {
                Some(Report::Result(result.clone()))
            }
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn reports(operation: &mut Operation, seconds: u32) -> Vec<Report> {
        let mut found = Vec::new();
        for _ in 0..seconds {
            let report = operation.advance(1.0);
            let is_last = report.as_ref().is_some_and(Report::is_last);
            found.extend(report);
            if is_last {
                break;
            }
        }
        found
    }

    #[test]
    fn reports_progress_and_result() {
        let mut operation = Operation::lasting("r1".to_owned(), 4.0, json!(true));
        let [first, second, third] = [25, 50, 75].map(Report::Progress);
        assert_eq!(reports(&mut operation, 9), [first, second, third, Report::Result(json!(true))]);
        assert_eq!(reports(&mut Operation::unanswered("r2".to_owned()), 9), [Report::Timeout]);
    }

    #[test]
    fn waits_while_suspended() {
        let mut operation = Operation::suspending("r1".to_owned(), 4.0, json!(true));
        assert!(!operation.resume());
        assert_eq!(reports(&mut operation, 9), [Report::Progress(25), Report::Suspension(50)]);
        assert!(operation.resume());
        assert_eq!(reports(&mut operation, 9), [Report::Progress(75), Report::Result(json!(true))]);
        operation.cancel();
        assert_eq!(operation.advance(0.0), Some(Report::Cancellation));
    }
}
