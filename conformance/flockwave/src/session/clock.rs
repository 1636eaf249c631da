//! The server's clock. Its offset from the client's clock follows from the answers to requests of the type SYS-TIME.

use uavspec_model::Location;
use uavspec_model::json::Tree;

use super::{Exchange, MAX_CLOCK_JITTER, SentRequest};

/// The assumed maximum time until the server has handled a request that adjusts its clock, in seconds. This includes
/// copies of the request that a network delivers later.
const MAX_ADJUSTMENT_TIME: f64 = 60.0;

/// The assumed maximum drift between the clocks of the client and the server, in seconds per second. NTP corrects
/// clocks at up to this rate.
const MAX_DRIFT: f64 = 0.0005;

/// The change in the server's clock between two answers that contain the server's time.
#[derive(Clone, Copy, Debug)]
pub struct ClockMove {
    /// The minimum change in seconds; 0 if the two answers are consistent with an unchanged clock.
    pub by: f64,
    /// The time since the previous answer, in seconds.
    pub since: f64,
    /// True if the client has requested an adjustment by 0 since the previous answer.
    pub is_after_nothing: bool,
}

/// The server's clock, as known from one connection.
#[derive(Clone, Debug, Default)]
pub(super) struct ServerClock {
    /// The bounds of the clock's offset, in seconds.
    bounds: Option<(f64, f64)>,
    /// The time when the bounds were determined.
    time: f64,
    /// The number of adjustments before the bounds were determined.
    num_adjustments: u64,
    /// The location of a request to adjust the clock by 0. This location is cleared when an answer to a later request
    /// contains the time.
    adjusted_by_nothing: Option<Location>,
}

/// The requests that may have adjusted the server's clock, on any connection. Several connections may lead to the same
/// server.
#[derive(Debug)]
pub(super) struct Adjustments {
    /// True if a client may have set the clock back.
    may_set_back: bool,
    count: u64,
    /// The time until which the server may still handle adjustment requests.
    until: f64,
    /// The location of the latest adjustment request, if the server handles no other one at about the same time. Its
    /// answer then contains the time after the adjustment.
    only: Option<Location>,
}

impl ServerClock {
    /// Forgets the offset.
    pub(super) fn forget(&mut self) {
        self.bounds = None;
    }

    /// The bounds of the offset at this time, in seconds, unless the clock may have been adjusted since.
    pub(super) fn at(&self, time: Option<f64>, adjustments: &Adjustments) -> Option<(f64, f64)> {
        let (low, high) = self.bounds.filter(|_| self.num_adjustments == adjustments.count)?;
        let drift = time.map_or(0.0, |time| (time - self.time).max(0.0) * MAX_DRIFT);
        Some((low - drift, high + drift))
    }

    /// Handles a request from the client.
    pub(super) fn request(&mut self, exchange: &Exchange<'_>, request: &SentRequest) {
        if exchange.type_name == Some("SYS-TIME") && exchange.field("adjustment") == Some(&Tree::Int(0)) {
            self.adjusted_by_nothing = Some(request.location);
        }
    }

    /// Determines the offset from an answer. The server may handle requests in any order, so only some answers contain
    /// the time after an adjustment.
    pub(super) fn answer(&mut self, exchange: &mut Exchange<'_>, adjustments: &mut Adjustments) {
        let Some(request) = &exchange.request else { return };
        let location = request.location;
        let is_only_adjustment = adjustments.only == Some(location);
        let is_certain = if request.is_adjustment() {
            is_only_adjustment
        } else {
            request.time.is_some_and(|time| time > adjustments.until)
        };
        if !is_certain {
            return;
        }
        let (Some(now), Some(time)) = (exchange.clock_reading(), exchange.time) else { return };
        exchange.clock_move = exchange.clock.map(|before| ClockMove {
            // The change is 0 if the same offset is possible for both answers.
            by: (now.0 - before.1).max(before.0 - now.1).max(0.0),
            since: time - self.time,
            is_after_nothing: self.adjusted_by_nothing.is_some(),
        });
        (self.bounds, self.time) = (Some(now), time);
        self.num_adjustments = adjustments.count;
        if is_only_adjustment {
            adjustments.until = time + MAX_CLOCK_JITTER;
        }
        self.adjusted_by_nothing = self.adjusted_by_nothing.filter(|asked| location <= *asked);
    }
}

impl Default for Adjustments {
    fn default() -> Self {
        Self { may_set_back: false, count: 0, until: f64::NEG_INFINITY, only: None }
    }
}

impl Adjustments {
    /// True if a client may have set the clock back.
    pub(super) fn may_set_back(&self) -> bool {
        self.may_set_back
    }

    /// Handles a request from the client.
    pub(super) fn request(&mut self, exchange: &Exchange<'_>, request: &SentRequest) {
        if request.is_adjustment() {
            let is_ordered = exchange.record.connection.is_ordered;
            let is_only = is_ordered && request.time.is_some_and(|time| time > self.until);
            self.may_follow(request.time.map(|time| time + MAX_ADJUSTMENT_TIME));
            self.only = is_only.then_some(request.location);
            self.may_set_back |= !is_forward(exchange.field("adjustment"));
        }
    }

    /// Records that the server may still adjust its clock until this time. If the time is unknown, the server may
    /// adjust its clock at any later time.
    pub(super) fn may_follow(&mut self, until: Option<f64>) {
        self.count += 1;
        self.until = self.until.max(until.unwrap_or(f64::INFINITY));
        self.only = None;
    }
}

/// True if an adjustment can't set the clock back.
fn is_forward(adjustment: Option<&Tree<'_>>) -> bool {
    match adjustment {
        Some(Tree::Int(by)) => *by >= 0,
        Some(Tree::Float(by, _)) => *by >= 0.0,
        _ => false,
    }
}
