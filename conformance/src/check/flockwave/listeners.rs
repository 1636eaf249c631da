//! The checks of all rules on sessions, and the records that each of them gets.

use crate::definitions::Definitions;
use crate::flockwave::session::Exchange;
use crate::model::{Findings, Place, Rule};
use crate::rules::RuleContext;
use crate::rules::flockwave::{Check, Message, RULES, SessionCheck, StatusReport};

/// The checks of all rules.
pub(in crate::check) struct Listeners<'d> {
    definitions: &'d Definitions,
    all: Vec<Listener>,
}

/// A check of a rule, and the number of times that it had something to check.
struct Listener {
    rule: &'static Rule,
    running: Running,
    coverage: u64,
}

/// A check; of one that keeps a state, the state.
enum Running {
    Stateless(Check),
    Session(Box<dyn SessionCheck>),
}

/// A record, as the kinds of checks see it.
struct Views<'v> {
    exchange: &'v Exchange<'v>,
    message: Option<Message<'v>>,
    report: Option<StatusReport<'v>>,
}

impl<'d> Listeners<'d> {
    /// The checks of all rules, at the start of a session.
    pub(in crate::check) fn new(definitions: &'d Definitions) -> Self {
        let all = RULES.iter().flat_map(|of| {
            of.checks.iter().map(|check| {
                let running = match check {
                    Check::Session(start) => Running::Session(start()),
                    stateless => Running::Stateless(*stateless),
                };
                Listener { rule: &of.rule, running, coverage: 0 }
            })
        });
        Self { definitions, all: all.collect() }
    }

    /// A record.
    pub(in crate::check) fn record(&mut self, exchange: &Exchange<'_>, findings: &mut Findings) {
        let (message, report) = (Message::of(exchange), StatusReport::of(exchange));
        self.follow(&Views { exchange, message, report }, findings);
    }

    /// A status report whose message was checked already.
    pub(in crate::check) fn checked_report(&mut self, exchange: &Exchange<'_>, findings: &mut Findings) {
        self.follow(&Views { exchange, message: None, report: StatusReport::of(exchange) }, findings);
    }

    fn follow(&mut self, views: &Views<'_>, findings: &mut Findings) {
        let definitions = self.definitions;
        for Listener { rule, running, coverage } in &mut self.all {
            let mut context = RuleContext { rule, definitions, findings: &mut *findings, coverage };
            match (running, &views.message, &views.report) {
                (Running::Stateless(Check::Message(check)), Some(message), _) => check(message, &mut context),
                (Running::Stateless(Check::Exchange(check)), _, None) => check(views.exchange, &mut context),
                (Running::Stateless(Check::StatusReport(check)), _, Some(report)) => {
                    check(report, &mut context);
                }
                (Running::Session(state), _, Some(report)) => state.status_report(report, &mut context),
                (Running::Session(state), _, None) => state.exchange(views.exchange, &mut context),
                (Running::Stateless(_), ..) => {}
            }
        }
    }

    /// Something is unreadable, and records may be missing.
    pub(in crate::check) fn damage(&mut self, place: Place) {
        for listener in &mut self.all {
            if let Running::Session(state) = &mut listener.running {
                state.damage(place);
            }
        }
    }

    /// The end of the capture.
    pub(in crate::check) fn end(&mut self, findings: &mut Findings) {
        let definitions = self.definitions;
        for Listener { rule, running, coverage } in &mut self.all {
            if let Running::Session(state) = running {
                state.end(&mut RuleContext { rule, definitions, findings: &mut *findings, coverage });
            }
            findings.exercise(rule, *coverage);
        }
    }
}
