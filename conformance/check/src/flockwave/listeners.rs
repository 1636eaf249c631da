//! The checks of all session rules, and the dispatch of records to these checks.

use uavspec_flockwave::session::Exchange;
use uavspec_model::json::Tree;
use uavspec_model::{Findings, Location, Rule};
use uavspec_rules::RuleContext;
use uavspec_rules::definitions::Definitions;
use uavspec_rules::flockwave::{Check, Message, RULES, SessionCheck, StatusReport};

/// The checks of all rules.
pub(crate) struct Listeners<'d> {
    definitions: &'d Definitions,
    all: Vec<Listener>,
}

/// The check of a rule, and the number of items that it has checked.
struct Listener {
    rule: &'static Rule,
    running: Running,
    coverage: u64,
}

/// A check, with its state, if any.
enum Running {
    Stateless(Check),
    Session(Box<dyn SessionCheck>),
}

/// The views of a record, one for each kind of check.
struct Views<'v> {
    exchange: &'v Exchange<'v>,
    message: Option<Message<'v>>,
    report: Option<StatusReport<'v>>,
}

impl<'d> Listeners<'d> {
    /// Creates the checks of all rules, for the start of a session.
    pub(crate) fn new(definitions: &'d Definitions) -> Self {
        let all = RULES.iter().flat_map(|rule| {
            rule.checks.iter().map(|check| {
                let running = match check {
                    Check::Session(start) => Running::Session(start()),
                    stateless => Running::Stateless(*stateless),
                };
                Listener { rule: &rule.rule, running, coverage: 0 }
            })
        });
        Self { definitions, all: all.collect() }
    }

    /// Passes a record to the checks.
    pub(crate) fn record(&mut self, exchange: &Exchange<'_>, findings: &mut Findings) {
        let (message, report) = (Message::from_exchange(exchange), StatusReport::from_exchange(exchange));
        let views = Views { exchange, message, report };
        views.show(&mut self.all, self.definitions, findings);
    }

    /// Passes a status report to all checks except message checks, whose results are already known.
    pub(crate) fn checked_report(
        &mut self,
        exchange: &Exchange<'_>,
        timestamps: &[(&str, Tree<'_>)],
        findings: &mut Findings,
    ) {
        let views =
            Views { exchange, message: None, report: Some(StatusReport::checked(exchange, timestamps)) };
        views.show(&mut self.all, self.definitions, findings);
    }

    /// Notifies the checks of an unreadable part of the capture, which may have contained records.
    pub(crate) fn corruption(&mut self, location: Location) {
        for listener in &mut self.all {
            if let Running::Session(state) = &mut listener.running {
                state.corruption(location);
            }
        }
    }

    /// Ends all checks.
    pub(crate) fn end(&mut self, findings: &mut Findings) {
        let definitions = self.definitions;
        for Listener { rule, running, coverage } in &mut self.all {
            if let Running::Session(state) = running {
                state.end(&mut RuleContext {
                    rule,
                    definitions,
                    events: &definitions.events,
                    findings: &mut *findings,
                    coverage,
                });
            }
            findings.cover(rule, *coverage);
        }
    }
}

impl Views<'_> {
    /// Calls each listener with the view of the record that its kind of check requires.
    fn show(&self, listeners: &mut [Listener], definitions: &Definitions, findings: &mut Findings) {
        for Listener { rule, running, coverage } in listeners {
            let mut context = RuleContext {
                rule,
                definitions,
                events: &definitions.events,
                findings: &mut *findings,
                coverage,
            };
            match (running, &self.message, &self.report) {
                (Running::Stateless(Check::Message(check)), Some(message), _) => check(message, &mut context),
                (Running::Stateless(Check::Exchange(check)), _, None) => check(self.exchange, &mut context),
                (Running::Stateless(Check::StatusReport(check)), _, Some(report)) => {
                    check(report, &mut context);
                }
                (Running::Session(state), _, Some(report)) => state.status_report(report, &mut context),
                (Running::Session(state), _, None) => state.exchange(self.exchange, &mut context),
                (Running::Stateless(_), ..) => {}
            }
        }
    }
}
